/* Positions and relative transforms along chains whose geometry is known. */
#include "arm.h"

/* The rotation about z by an angle, and a translation. */
static void checkTransform(const ctTransform* transform, double angle, double x, double y, double z) {
  const double expected[9] = {cos(angle), -sin(angle), 0, sin(angle), cos(angle), 0, 0, 0, 1};
  for (int i = 0; i < 9; i++) {
    CHECK_NEAR(transform->rotation[i], expected[i], 1e-12);
  }
  CHECK_NEAR(transform->translation[0], x, 1e-10);
  CHECK_NEAR(transform->translation[1], y, 1e-10);
  CHECK_NEAR(transform->translation[2], z, 1e-10);
}

/* In the reference positions all frames are parallel, wherever links begin and end in the tree's nodes. */
static void testStraightArm(void) {
  enum { LONGEST = 600 };
  for (int links = 1; links <= LONGEST; links = links < 20 ? links + 1 : links * 2 - 7) {
    ctChainTree* arm = makeArm(links, ctFixedJoint, 0.1);
    CHECK(ctValidate(arm));
    for (int n = 0; n < 50; n++) {
      const int a = n * 7919 % links;
      const int b = n * 104729 % links;
      ctTransform transform;
      CHECK_SUCCESS(ctGetRelativeTransform(arm, a, b, &transform));
      /* link 0's origin is particle 0 at (-1, 0, 0), that of others at (link - 1, 0, 1) */
      checkTransform(&transform, 0, b - a, 0, (b > 0) - (a > 0));
    }
    ctDestroy(arm);
  }
}

/* Equal angles bend the arm along a regular polygon. */
static void testPolygon(void) {
  enum { SIDES = 500 };
  const double angle = 2 * PI / SIDES;
  ctChainTree* arm = makeArm(SIDES + 1, ctFixedJoint, 0.1);
  for (int link = 1; link <= SIDES; link++) {
    turnArm(arm, link, angle);
  }
  CHECK(ctValidate(arm));
  static double positions[6 * (SIDES + 1)];
  ctGetPositions(arm, positions);
  double x = 0;
  double y = 0;
  for (int link = 1; link <= SIDES; link++) {
    x += cos(link * angle);
    y += sin(link * angle);
    const double* hand = positions + 3 * armHand(link);
    CHECK_NEAR(hand[0], x, 1e-10);
    CHECK_NEAR(hand[1], y, 1e-10);
    CHECK_NEAR(hand[2], 0, 1e-10);
  }
  /* the polygon closes */
  CHECK_NEAR(positions[3 * armHand(SIDES)], 0, 1e-10);
  CHECK_NEAR(positions[3 * armHand(SIDES) + 1], 0, 1e-10);
  const int pairs[][2] = {{1, 2}, {2, 1}, {7, 400}, {400, 7}, {16, 17}, {250, 250}, {1, SIDES}};
  for (int n = 0; n < 7; n++) {
    const int a = pairs[n][0];
    const int b = pairs[n][1];
    ctTransform transform;
    CHECK_SUCCESS(ctGetRelativeTransform(arm, a, b, &transform));
    /* from a's origin, the polygon's corner before it, to b's, seen in a's axes, which stand at a times the angle */
    double dx = 0;
    double dy = 0;
    for (int link = a; link < b; link++) {
      dx += cos((link - a) * angle);
      dy += sin((link - a) * angle);
    }
    for (int link = b; link < a; link++) {
      dx -= cos((link - a) * angle);
      dy -= sin((link - a) * angle);
    }
    checkTransform(&transform, (b - a) * angle, dx, dy, 0);
  }
  ctDestroy(arm);
}

/* Each link is turned by all joints before it; fixed links never are, and setting the state again keeps every bit. */
static void testOrientations(void) {
  enum { LINKS = 40 };
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  double sums[LINKS] = {0};
  double orientations[LINKS][9];
  double again[LINKS][9];
  ctGetOrientations(arm, orientations);
  for (int link = 0; link < LINKS; link++) {
    for (int i = 0; i < 9; i++) {
      CHECK(orientations[link][i] == (i % 4 == 0 ? 1 : 0));
    }
  }
  for (int link = 1; link < LINKS; link++) {
    turnArm(arm, link, 0.1 * link);
    sums[link] = sums[link - 1] + 0.1 * link;
  }
  ctGetOrientations(arm, orientations);
  for (int link = 0; link < LINKS; link++) {
    const double expected[9] = {cos(sums[link]), -sin(sums[link]), 0, sin(sums[link]), cos(sums[link]), 0, 0, 0, 1};
    for (int i = 0; i < 9; i++) {
      CHECK_NEAR(orientations[link][i], expected[i], 1e-12);
    }
  }
  double* state = malloc(ctGetStateSize(arm) * sizeof(double));
  CHECK(state != NULL);
  ctGetState(arm, state);
  turnArm(arm, 7, 1);
  CHECK_SUCCESS(ctSetState(arm, state));
  ctGetOrientations(arm, again);
  CHECK(memcmp(orientations, again, sizeof again) == 0);
  free(state);
  ctDestroy(arm);
}

/* All joints at once bend the arm just as one after the other. */
static void testManyChanges(void) {
  enum { LINKS = 100 };
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  ctChange changes[LINKS - 1] = {{0}};
  double x = 0;
  double y = 0;
  double sum = 0;
  for (int link = 1; link < LINKS; link++) {
    /* given in an order that is neither inner nor outer first */
    ctChange* change = &changes[link * 37 % (LINKS - 1)];
    change->link = link;
    change->angle = 0.1 * link;
    sum += change->angle;
    x += cos(sum);
    y += sin(sum);
  }
  double positions[6 * LINKS];
  CHECK_SUCCESS(ctPropose(arm, LINKS - 1, changes));
  CHECK_SUCCESS(ctGetTrialPositions(arm, positions));
  CHECK_NEAR(positions[3 * armHand(LINKS - 1)], x, 1e-11);
  CHECK_NEAR(positions[3 * armHand(LINKS - 1) + 1], y, 1e-11);
  CHECK_SUCCESS(ctAccept(arm, NULL));
  ctTransform transform;
  CHECK_SUCCESS(ctGetRelativeTransform(arm, 0, LINKS - 1, &transform));
  checkTransform(&transform, sum, 1 + x - cos(sum), y - sin(sum), 1);
  ctDestroy(arm);
}

/* Links that have not moved keep their frame against the world, another fixed link included. */
static void testFixedFrames(void) {
  const double positions[] = {1, 2, 3, 4, 5, 6, 7, 8, 10};
  const double radii[] = {0.1, 0.1, 0.1};
  const int particleLinks[] = {0, 1, 2};
  const int parents[] = {CT_NULL, CT_NULL, CT_NULL};
  const uint8_t joints[] = {ctFixedJoint, ctFixedJoint, ctFreeJoint};
  const ctDefinition definition = {.particleCount = 3,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = 3,
                                   .linkParents = parents,
                                   .linkJoints = joints};
  ctChainTree* tree = checkedCreate(&definition);
  ctTransform transform;
  CHECK_SUCCESS(ctGetRelativeTransform(tree, 0, 1, &transform));
  checkTransform(&transform, 0, 3, 3, 3);
  const ctChange change = {.link = 2, .rotation = {0, 0, PI / 2}, .pivot = {4, 5, 6}, .translation = {0, 0, 1}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK_SUCCESS(ctGetRelativeTransform(tree, 1, 2, &transform));
  checkTransform(&transform, PI / 2, -3, 3, 5);
  CHECK_SUCCESS(ctGetRelativeTransform(tree, 2, 1, &transform));
  checkTransform(&transform, -PI / 2, -3, -3, -5);
  ctDestroy(tree);
}

int main(void) {
  testStraightArm();
  testPolygon();
  testOrientations();
  testManyChanges();
  testFixedFrames();
  return checkResult();
}
