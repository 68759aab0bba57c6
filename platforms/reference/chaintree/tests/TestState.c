/* The state as numbers: what they are, and that a scene which is given them continues as if it had made them. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "arm.h"
#include "beads.h"
#include "lattice.h"

enum { LINKS = 30, ARM_COORDINATES = 6 * LINKS, ARM_SIZE = ARM_COORDINATES + 7 + LINKS - 1 };

static void testNumbers(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  double start[ARM_COORDINATES];
  double state[ARM_SIZE];
  ctGetPositions(arm, start);
  CHECK(ctGetStateSize(arm) == ARM_SIZE);
  ctGetState(arm, state);
  CHECK(memcmp(state, start, sizeof start) == 0);
  const double* placement = state + ARM_COORDINATES;
  const double* angles = placement + 6; /* of link l: angles[l] */
  CHECK(placement[0] == 1 && placement[1] == 0 && placement[2] == 0 && placement[3] == 0);
  for (int link = 1; link < LINKS; link++) {
    CHECK(angles[link] == 0);
  }
  const double origin[3] = {placement[4], placement[5], placement[6]};
  const ctChange changes[] = {{.link = 0, .rotation = {0, 0, PI / 2}, .pivot = {-1, 0, 0}, .translation = {0, 0, 5}},
                              {.link = 7, .angle = 1.25},
                              {.link = 9, .angle = -3 * PI}};
  CHECK_SUCCESS(ctPropose(arm, 3, changes));
  ctGetState(arm, state);
  CHECK(placement[0] == 1 && angles[7] == 0); /* a trial is no part of it */
  CHECK_SUCCESS(ctAccept(arm, NULL));
  ctGetState(arm, state);
  CHECK(memcmp(state, start, sizeof start) == 0);
  CHECK_NEAR(placement[0], sqrt(0.5), 1e-15);
  CHECK_NEAR(placement[3], sqrt(0.5), 1e-15);
  CHECK_NEAR(placement[4], origin[0], 1e-14); /* about particle 0, which is the origin of link 0 */
  CHECK_NEAR(placement[5], origin[1], 1e-14);
  CHECK_NEAR(placement[6], origin[2] + 5, 1e-14);
  CHECK(angles[7] == 1.25);
  CHECK_NEAR(fabs(angles[9]), PI, 1e-14);
  turnArm(arm, 7, 3);
  ctGetState(arm, state);
  CHECK_NEAR(angles[7], 4.25 - 2 * PI, 1e-14);
  CHECK_SUCCESS(ctSetState(arm, state));
  ctDestroy(arm);

  ctChainTree* fixed = makeArm(LINKS, ctFixedJoint, 0.1);
  CHECK(ctGetStateSize(fixed) == ARM_SIZE - 7);
  ctDestroy(fixed);
  ctChainTree* empty = checkedCreate(&(ctDefinition){0});
  CHECK(ctGetStateSize(empty) == 0);
  ctGetState(empty, state);
  CHECK_SUCCESS(ctSetState(empty, state));
  ctDestroy(empty);
}

/* A small generator of numbers in [0, 1), the same on every machine. */
static double draw(uint32_t* seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (double)(*seed >> 8) / (1 << 24);
}

/* Trials of links 1 ... links - 1; accepts trials without a clash and returns their number. */
static int wander(ctChainTree* tree, ctJointKind joint, int links, int trials, uint32_t seed) {
  int accepted = 0;
  for (int i = 0; i < trials; i++) {
    ctChange change = {.link = 1 + (int)(draw(&seed) * (links - 1))};
    if (joint == ctTorsionJoint) {
      change.angle = draw(&seed) - 0.5;
    } else {
      for (int k = 0; k < 3; k++) {
        change.rotation[k] = 0.2 * draw(&seed) - 0.1;
        change.translation[k] = 0.2 * draw(&seed) - 0.1;
        change.pivot[k] = SIDE * draw(&seed);
      }
    }
    bool clash;
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    if (!clash) {
      CHECK_SUCCESS(ctAccept(tree, NULL));
      accepted++;
    }
  }
  return accepted;
}

static void checkSamePositions(ctChainTree* a, ctChainTree* b) {
  static double x[3 * SITES];
  static double y[3 * SITES];
  ctGetPositions(a, x);
  ctGetPositions(b, y);
  CHECK(memcmp(x, y, sizeof x) == 0);
}

/* Of two scenes made alike, one is given the other's state, in the midst of something else. They end up alike. */
static void testGoingOn(LatticeLinks kind, ctJointKind joint, int links) {
  static double positions[3 * SITES];
  const double radius = 0.49;
  ctChainTree* a = makeLattice(kind, radius, 0);
  ctChainTree* b = makeLattice(kind, radius, 0);
  double* state = calloc(ctGetStateSize(a), sizeof(double));
  if (state == NULL) {
    abort();
  }
  wander(a, joint, links, 300, 1);
  ctGetPositions(a, positions);
  CHECK_SUCCESS(ctSetPositions(a, positions));
  CHECK(wander(a, joint, links, 300, 2) > 0);
  ctGetState(a, state);

  wander(b, joint, links, 300, 3);
  CHECK_SUCCESS(ctPropose(b, 0, NULL));
  CHECK_SUCCESS(ctSetState(b, state));
  CHECK(!ctHasTrial(b));
  CHECK(ctValidate(b));
  checkSamePositions(a, b);
  CHECK(wander(a, joint, links, 300, 4) == wander(b, joint, links, 300, 4));
  checkSamePositions(a, b);

  /* and back, from where it has gone */
  CHECK_SUCCESS(ctSetState(a, state));
  CHECK(ctValidate(a));
  CHECK_SUCCESS(ctSetState(b, state));
  checkSamePositions(a, b);
  free(state);
  ctDestroy(a);
  ctDestroy(b);
}

static void testLimitsAreKept(void) {
  ctChainTree* tree = makeBeads(&(Beads){.count = 2, .positions = {0, 0, 0, 1, 0, 0}, .radii = {0.6, 0.6}});
  double state[20];
  int raised;
  CHECK(ctGetStateSize(tree) == 20);
  ctGetState(tree, state);
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  shift(tree, 1, 1);
  CHECK_SUCCESS(ctSetState(tree, state));
  CHECK(ctGetLimitCount(tree) == 1);
  CHECK(isListed(tree, 0, 1));
  CHECK(!clashesShifted(tree, 1, 0.01));
  CHECK(clashesShifted(tree, 1, -0.01));
  ctDestroy(tree);
}

/* Numbers that are no state change nothing. */
static void testNonsense(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  double before[ARM_COORDINATES];
  double after[ARM_COORDINATES];
  double state[ARM_SIZE];
  turnArm(arm, 5, 1);
  ctGetPositions(arm, before);
  CHECK_SUCCESS(ctPropose(arm, 0, NULL));
  const struct {
    int index;
    double value;
    const char* culprit;
  } nonsense[] = {
      {8, NAN, "particle 2 "},
      {ARM_COORDINATES - 1, INFINITY, "particle 59 "},
      {ARM_COORDINATES, 2, "link 0 "},
      {ARM_COORDINATES + 2, NAN, "link 0 "},
      {ARM_COORDINATES + 4, NAN, "link 0 "},
      {ARM_COORDINATES + 5, INFINITY, "link 0 "},
      {ARM_COORDINATES + 6, -INFINITY, "link 0 "},
      {ARM_COORDINATES + 7, 3.2, "link 1 "},
      {ARM_SIZE - 1, NAN, "link 29 "},
  };
  for (size_t i = 0; i < sizeof nonsense / sizeof nonsense[0]; i++) {
    ctGetState(arm, state);
    state[nonsense[i].index] = nonsense[i].value;
    CHECK_FAILURE(arm, ctInvalidArgument, nonsense[i].culprit, ctSetState(arm, state));
  }
  /* an axis of no length is nothing to turn about */
  ctGetState(arm, state);
  memcpy(state + 3 * armHand(4), state + 3 * armHand(4) + 3, 3 * sizeof(double));
  CHECK_FAILURE(arm, ctInvalidArgument, "link 5 ", ctSetState(arm, state));
  CHECK(ctHasTrial(arm));
  ctGetPositions(arm, after);
  CHECK(memcmp(before, after, sizeof before) == 0);
  CHECK(ctValidate(arm));
  ctDestroy(arm);
}

int main(void) {
  testNumbers();
  testGoingOn(LAYERS, ctFreeJoint, SIDE);
  testGoingOn(ONE_EACH, ctFreeJoint, SITES);
  testGoingOn(ROWS_ON_A_WALL, ctTorsionJoint, SIDE * SIDE + 1);
  testLimitsAreKept();
  testNonsense();
  setenv("CHAINTREE_TRIALS", "clearances", 1);
  testGoingOn(LAYERS, ctFreeJoint, SIDE);
  testGoingOn(ONE_EACH, ctFreeJoint, SITES);
  testGoingOn(ROWS_ON_A_WALL, ctTorsionJoint, SIDE * SIDE + 1);
  return checkResult();
}
