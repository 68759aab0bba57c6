/* propose -> test -> accept or reject: what each changes, and what it does not. */
#include "arm.h"

enum { LINKS = 30, COORDINATES = 6 * LINKS };

static void checkBits(ctChainTree* tree, const double* expected) {
  double positions[COORDINATES];
  ctGetPositions(tree, positions);
  CHECK(memcmp(positions, expected, sizeof positions) == 0);
}

/* Neither proposing nor testing nor rejecting leaves a trace; accepting gives the bits that the trial promised. */
static void testBits(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  turnArm(arm, 7, 0.5);
  double state[COORDINATES];
  double promised[COORDINATES];
  double again[COORDINATES];
  ctTransform before;
  ctTransform after;
  bool clash;
  ctGetPositions(arm, state);
  CHECK_SUCCESS(ctGetRelativeTransform(arm, 2, 25, &before));
  const ctChange changes[] = {{.link = 20, .angle = 1},
                              {.link = 0, .rotation = {0.3, 0.2, 0.1}, .pivot = {1, 2, 3}, .translation = {4, 5, 6}},
                              {.link = 12, .angle = -2}};
  CHECK_SUCCESS(ctPropose(arm, 3, changes));
  checkBits(arm, state);
  CHECK_SUCCESS(ctTestTrial(arm, &clash, NULL, NULL));
  CHECK_SUCCESS(ctGetTrialPositions(arm, promised));
  CHECK(memcmp(promised, state, sizeof state) != 0);
  checkBits(arm, state);
  CHECK_SUCCESS(ctGetRelativeTransform(arm, 2, 25, &after));
  CHECK(memcmp(&before, &after, sizeof before) == 0);
  CHECK(ctHasTrial(arm));
  ctReject(arm);
  CHECK(!ctHasTrial(arm));
  ctReject(arm);
  checkBits(arm, state);
  CHECK(ctValidate(arm));

  CHECK_SUCCESS(ctPropose(arm, 3, changes));
  CHECK_SUCCESS(ctGetTrialPositions(arm, again));
  CHECK(memcmp(promised, again, sizeof again) == 0);
  CHECK_SUCCESS(ctAccept(arm, NULL));
  CHECK(!ctHasTrial(arm));
  checkBits(arm, promised);
  CHECK(ctValidate(arm));
  ctDestroy(arm);
}

static void checkFollowed(ctChainTree* tree, bool isNewArray, double* followed) {
  double trial[COORDINATES];
  CHECK_SUCCESS(ctGetTrialPositions(tree, trial));
  CHECK_SUCCESS(ctFollowTrialPositions(tree, isNewArray, followed));
  CHECK(memcmp(followed, trial, sizeof trial) == 0);
}

/* An array that is kept from trial to trial always has the bits of the trial, and is left alone where nothing moves. */
static void testFollowing(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  double followed[COORDINATES];
  double moved[COORDINATES];
  const ctChange end = {.link = 28, .angle = 0.3};
  const ctChange middle = {.link = 14, .angle = 1};
  const ctChange all = {.link = 0, .rotation = {0.3, 0.2, 0.1}, .translation = {4, 5, 6}};
  CHECK_SUCCESS(ctPropose(arm, 1, &end));
  checkFollowed(arm, false, followed); /* nothing was there before, so this is all */
  CHECK_SUCCESS(ctPropose(arm, 1, &all));
  checkFollowed(arm, false, followed);
  ctReject(arm);
  CHECK_SUCCESS(ctPropose(arm, 1, &middle)); /* particles of the rejected trial go back */
  checkFollowed(arm, false, followed);
  CHECK_SUCCESS(ctAccept(arm, NULL));
  turnArm(arm, 9, 0.5); /* not followed */
  CHECK_SUCCESS(ctPropose(arm, 1, &end));
  checkFollowed(arm, false, followed);
  CHECK_SUCCESS(ctAccept(arm, NULL));
  followed[0] = NAN;
  CHECK_SUCCESS(ctPropose(arm, 1, &end));
  CHECK_SUCCESS(ctFollowTrialPositions(arm, false, followed));
  CHECK(isnan(followed[0]));
  checkFollowed(arm, true, followed);
  ctGetPositions(arm, moved);
  CHECK_SUCCESS(ctSetPositions(arm, moved));
  CHECK_SUCCESS(ctPropose(arm, 1, &middle));
  checkFollowed(arm, false, followed);
  ctDestroy(arm);
}

/* So does one that is the state's and a trial's in turns. */
static void testFollowingState(void) {
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  double followed[COORDINATES];
  double state[COORDINATES];
  for (int i = 0; i < 12; i++) {
    const ctChange change = {.link = 3 + 2 * i, .angle = 0.3};
    CHECK_SUCCESS(ctPropose(arm, 1, &change));
    if (i % 3 != 0) {
      checkFollowed(arm, false, followed);
    }
    if (i % 2 == 0) {
      CHECK_SUCCESS(ctAccept(arm, NULL));
    }
    if (i != 8) {
      ctGetPositions(arm, state);
      ctFollowPositions(arm, i == 7, followed);
      CHECK(memcmp(followed, state, sizeof state) == 0);
    }
  }
  followed[0] = NAN;
  ctFollowPositions(arm, false, followed);
  CHECK(isnan(followed[0]));
  ctDestroy(arm);
}

/* A proposal takes the place of the one before; one that fails does not. */
static void testReplacement(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  double first[COORDINATES];
  double second[COORDINATES];
  const ctChange changes[] = {{.link = 5, .angle = 1}, {.link = 9, .angle = 2}, {.link = 5, .angle = 3}};
  CHECK_SUCCESS(ctPropose(arm, 1, changes));
  CHECK_SUCCESS(ctGetTrialPositions(arm, first));
  CHECK_FAILURE(arm, ctInvalidArgument, "link 5", ctPropose(arm, 3, changes));
  CHECK_FAILURE(arm, ctInvalidArgument, "link 0", ctPropose(arm, 1, &(ctChange){.link = 0}));
  CHECK_FAILURE(arm, ctInvalidArgument, "link 30", ctPropose(arm, 1, &(ctChange){.link = LINKS}));
  CHECK_FAILURE(arm, ctInvalidArgument, "link -1", ctPropose(arm, 1, &(ctChange){.link = -1}));
  CHECK_FAILURE(arm, ctInvalidArgument, "link 3", ctPropose(arm, 1, &(ctChange){.link = 3, .angle = INFINITY}));
  CHECK_FAILURE(arm, ctInvalidArgument, "-2 changes", ctPropose(arm, -2, changes));
  CHECK_SUCCESS(ctGetTrialPositions(arm, second));
  CHECK(memcmp(first, second, sizeof first) == 0);
  CHECK_SUCCESS(ctPropose(arm, 1, changes + 1));
  CHECK_SUCCESS(ctAccept(arm, NULL));
  double angle;
  CHECK_SUCCESS(ctGetTorsionAngle(arm, 5, &angle));
  CHECK_NEAR(angle, PI, 1e-14);
  CHECK_SUCCESS(ctGetTorsionAngle(arm, 9, &angle));
  CHECK_NEAR(angle, 2 - PI, 1e-14);
  /* new positions end a trial */
  CHECK_SUCCESS(ctPropose(arm, 1, changes));
  CHECK_SUCCESS(ctSetPositions(arm, first));
  CHECK(!ctHasTrial(arm));
  ctDestroy(arm);
}

/* The arm folds back on itself: at a right angle it is clear, at a straight one hand 4 meets hand 2. */
static void testVerdict(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  bool clash;
  int pair[2];
  ctCounts counts = {10, 20, 30};
  CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = 4, .angle = PI / 2}));
  CHECK_SUCCESS(ctTestTrial(arm, &clash, pair, &counts));
  CHECK(!clash);
  CHECK(counts.volumeTests >= 10 && counts.particleTests > 20 && counts.nodesUpdated == 30);
  CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = 4, .angle = PI}));
  CHECK_SUCCESS(ctTestTrial(arm, &clash, pair, NULL));
  CHECK(clash);
  CHECK(pair[0] < armHand(4) - 1 && pair[1] >= armHand(4) - 1);
  CHECK_SUCCESS(ctTestTrial(arm, &clash, NULL, NULL));
  CHECK(clash);
  /* a clashing trial may be accepted; then it is no fault of the next one that it leaves as it is */
  CHECK_SUCCESS(ctAccept(arm, &counts));
  CHECK(counts.nodesUpdated > 30);
  CHECK_SUCCESS(ctHasClash(arm, &clash, NULL, NULL));
  CHECK(clash);
  CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = LINKS - 1, .angle = PI / 2}));
  CHECK_SUCCESS(ctTestTrial(arm, &clash, NULL, NULL));
  CHECK(!clash);
  CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = 4, .angle = PI / 2}));
  CHECK_SUCCESS(ctTestTrial(arm, &clash, NULL, NULL));
  CHECK(!clash);
  CHECK_SUCCESS(ctAccept(arm, NULL));
  CHECK_SUCCESS(ctHasClash(arm, &clash, NULL, NULL));
  CHECK(!clash);
  ctDestroy(arm);
}

/* No change at all is a trial as well. */
static void testNothing(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 1);
  double state[COORDINATES];
  bool clash = true;
  ctGetPositions(arm, state);
  CHECK_SUCCESS(ctPropose(arm, 0, NULL));
  CHECK(ctHasTrial(arm));
  CHECK_SUCCESS(ctTestTrial(arm, &clash, NULL, NULL));
  CHECK(!clash); /* the beads overlap, but nothing has moved them */
  CHECK_SUCCESS(ctAccept(arm, NULL));
  checkBits(arm, state);
  ctDestroy(arm);
}

typedef struct Distances {
  int count;
  double error;
} Distances;

/* Of an arm folded at link 4, each pair across the fold has distances that its coordinates along the arm tell. */
static bool compareDistances(void* context, int particle1, int particle2, double before, double after) {
  Distances* distances = context;
  const int axis = 3;
  const double x1 = particle1 / 2 - (particle1 % 2 == 0);
  const double x2 = particle2 / 2 - (particle2 % 2 == 0);
  const double up = (particle1 % 2 != particle2 % 2 && particle1 > 0) || (particle1 == 0 && particle2 % 2 == 0);
  const double folded = 2 * axis - x2;
  distances->count++;
  distances->error = fmax(distances->error, fabs(before - hypot(x2 - x1, up)));
  distances->error = fmax(distances->error, fabs(after - hypot(folded - x1, up)));
  return true;
}

static void testChangedPairs(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  Distances distances = {0, 0};
  CHECK_FAILURE(arm, ctNoTrial, "trial", ctForEachChangedPair(arm, 1, compareDistances, &distances, NULL));
  CHECK_SUCCESS(ctPropose(arm, 1, &(ctChange){.link = 4, .angle = PI}));
  CHECK_SUCCESS(ctForEachChangedPair(arm, 1000, compareDistances, &distances, NULL));
  CHECK(distances.count == 8 * (2 * LINKS - 8));
  CHECK_NEAR(distances.error, 0, 1e-13);
  CHECK_FAILURE(arm, ctInvalidArgument, "cutoff is 0",
                ctForEachChangedPair(arm, 0, compareDistances, &distances, NULL));
  ctDestroy(arm);
}

/* An axis through particles so close together that it cannot be told from where rounding has left them, and a lever a
 * thousand million times as long: of its end and particle 0 alone. Returns whether they clash, and where they would be.
 */
static bool clashesOnShortAxis(double radius, double* distance) {
  static const double positions[] = {0, 0, 0, 0, 1, 0, 0, 2, 0, 10, 2, 3, 10 + 6e-7, 2 + 8e-7, 3, 810, 2, 503};
  static const int links[] = {0, 0, 1, 1, 2, 2};
  static const int parents[] = {CT_NULL, 0, 1};
  static const uint8_t joints[] = {ctFixedJoint, ctTorsionJoint, ctTorsionJoint};
  static const int torsions[][4] = {{0}, {0, 1, 2, 3}, {2, 3, 4, 5}};
  static const int exclusions[][2] = {{0, 1}, {0, 2}, {0, 3}, {0, 4}, {1, 2}, {1, 3}, {1, 4},
                                      {1, 5}, {2, 3}, {2, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}};
  const double radii[] = {radius, 0.1, 0.1, 0.1, 0.1, radius};
  const ctDefinition definition = {.particleCount = 6,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = 3,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = torsions,
                                   .exclusionCount = sizeof exclusions / sizeof exclusions[0],
                                   .exclusions = exclusions};
  const ctChange changes[] = {{.link = 1, .angle = 0.7}, {.link = 2, .angle = 0.9}};
  ctChainTree* tree = checkedCreate(&definition);
  CHECK_SUCCESS(ctPropose(tree, 1, &changes[0]));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK_SUCCESS(ctPropose(tree, 1, &changes[1]));
  bool clash = false;
  double x[18];
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  CHECK_SUCCESS(ctGetTrialPositions(tree, x));
  *distance = sqrt(x[15] * x[15] + x[16] * x[16] + x[17] * x[17]);
  ctDestroy(tree);
  return clash;
}

static void testShortAxis(void) {
  double distance;
  clashesOnShortAxis(0.1, &distance);
  CHECK(clashesOnShortAxis(0.5 * distance + 1e-8, &distance));
  CHECK(!clashesOnShortAxis(0.5 * distance - 1e-8, &distance));
}

int main(void) {
  testBits();
  testFollowing();
  testFollowingState();
  testReplacement();
  testVerdict();
  testNothing();
  testChangedPairs();
  testShortAxis();
  return checkResult();
}
