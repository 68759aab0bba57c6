/* Rigid motion of one molecule among several, and of a part that hangs on another. */
#include "check.h"

/* Two molecules of two links each, and a ring of one link that moves freely on the second. Each link is a triangle. */
enum { LINKS = 5, PARTICLES = 3 * LINKS, RING = 4 };

static ctChainTree* makeMolecules(void) {
  double positions[3 * PARTICLES];
  double radii[PARTICLES];
  int particleLinks[PARTICLES];
  for (int i = 0; i < PARTICLES; i++) {
    const int link = i / 3;
    const double triangle[3][3] = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0.1}};
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = triangle[i % 3][k];
    }
    positions[3 * i] += link % 2; /* the second link of a molecule is beside its first */
    positions[3 * i + 1] += 3 * (link / 2);
    radii[i] = 0.1;
    particleLinks[i] = link;
  }
  const int parents[LINKS] = {CT_NULL, 0, CT_NULL, 2, 3};
  const uint8_t joints[LINKS] = {ctFreeJoint, ctTorsionJoint, ctFreeJoint, ctTorsionJoint, ctFreeJoint};
  const int torsions[LINKS][4] = {{0}, {2, 1, 3, 5}, {0}, {8, 7, 9, 11}, {0}};
  const ctDefinition definition = {.particleCount = PARTICLES,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = LINKS,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = torsions};
  return checkedCreate(&definition);
}

static double distanceIn(const double* positions, int i, int j) {
  const double* a = positions + 3 * i;
  const double* b = positions + 3 * j;
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static bool isOfSecond(int particle) {
  return particle >= 6;
}

static bool mixesMolecules(void* context, int particle1, int particle2, double before, double after) {
  int* count = context;
  CHECK(isOfSecond(particle1) != isOfSecond(particle2));
  CHECK(before != after);
  ++*count;
  return true;
}

/* The second molecule turns a quarter about the z axis through its own centroid, then goes up by 2. */
static void testMoveAboutCentroid(void) {
  ctChainTree* tree = makeMolecules();
  double before[3 * PARTICLES];
  double after[3 * PARTICLES];
  double centroid[3];
  double expected[3] = {0, 0, 0};
  ctGetPositions(tree, before);
  for (int i = 6; i < PARTICLES; i++) {
    for (int k = 0; k < 3; k++) {
      expected[k] += before[3 * i + k] / (PARTICLES - 6);
    }
  }
  CHECK_SUCCESS(ctGetCentroid(tree, 2, centroid));
  ctChange change = {.link = 2, .rotation = {0, 0, PI / 2}, .translation = {0, 0, 2}};
  for (int k = 0; k < 3; k++) {
    CHECK_NEAR(centroid[k], expected[k], 1e-14);
    change.pivot[k] = centroid[k];
  }
  int changed = 0;
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctForEachChangedPair(tree, 100, mixesMolecules, &changed, NULL));
  CHECK(changed == 6 * (PARTICLES - 6));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK_SUCCESS(ctGetCentroid(tree, 2, centroid));
  CHECK_NEAR(centroid[0], expected[0], 1e-14);
  CHECK_NEAR(centroid[1], expected[1], 1e-14);
  CHECK_NEAR(centroid[2], expected[2] + 2, 1e-14);
  ctGetPositions(tree, after);
  CHECK(memcmp(before, after, sizeof(double[18])) == 0);
  for (int i = 6; i < PARTICLES; i++) {
    CHECK_NEAR(after[3 * i] - expected[0], -(before[3 * i + 1] - expected[1]), 1e-14);
    CHECK_NEAR(after[3 * i + 1] - expected[1], before[3 * i] - expected[0], 1e-14);
    CHECK_NEAR(after[3 * i + 2], before[3 * i + 2] + 2, 1e-14);
  }
  double angle;
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 3, &angle));
  CHECK(ctValidate(tree));
  ctDestroy(tree);
}

/* A test compares molecules, not pairs within the one that moves as a whole. */
static void testVerdict(void) {
  ctChainTree* tree = makeMolecules();
  bool clash;
  int pair[2] = {CT_NULL, CT_NULL};
  const ctChange onto = {.link = 2, .translation = {0.05, -3, 0}};
  CHECK_SUCCESS(ctPropose(tree, 1, &onto));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, pair, NULL));
  CHECK(clash && !isOfSecond(pair[0]) && isOfSecond(pair[1]));
  const ctChange beside = {.link = 2, .translation = {0, -2, 0}};
  CHECK_SUCCESS(ctPropose(tree, 1, &beside));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, pair, NULL));
  CHECK(!clash);
  ctDestroy(tree);
}

/* A free link on another goes with it, and its own motion is given in the world before that. */
static void testFreeOnTurning(void) {
  ctChainTree* tree = makeMolecules();
  double before[3 * PARTICLES];
  double after[3 * PARTICLES];
  ctGetPositions(tree, before);
  const ctChange changes[] = {
      {.link = RING, .rotation = {0, PI / 2, 0}, .pivot = {0, 6, 0}, .translation = {1, 2, 3}},
      {.link = 2, .rotation = {0, 0, PI / 2}, .pivot = {0, 6, 0}},
  };
  CHECK_SUCCESS(ctPropose(tree, 2, changes));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  ctGetPositions(tree, after);
  for (int i = 3 * RING; i < PARTICLES; i++) {
    /* (x, y, z) -> (z, y, -x) + (1, 2, 3), then (x, y) -> (-y, x), all from (0, 6, 0) */
    const double* b = before + 3 * i;
    const double inner[3] = {b[2] + 1, b[1] - 6 + 2, -b[0] + 3};
    CHECK_NEAR(after[3 * i], -inner[1], 1e-14);
    CHECK_NEAR(after[3 * i + 1], inner[0] + 6, 1e-14);
    CHECK_NEAR(after[3 * i + 2], inner[2], 1e-14);
  }
  /* a torsion above it takes it along */
  const ctChange turn = {.link = 3, .angle = 1.5};
  double last[3 * PARTICLES];
  CHECK_SUCCESS(ctPropose(tree, 1, &turn));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  ctGetPositions(tree, last);
  for (int i = 3 * RING; i < PARTICLES; i++) {
    CHECK_NEAR(distanceIn(last, i, 10), distanceIn(after, i, 10), 1e-14);
    CHECK(fabs(distanceIn(last, i, 8) - distanceIn(after, i, 8)) > 1e-3);
  }
  CHECK(ctValidate(tree));
  ctDestroy(tree);
}

/* Placements are states, not sums: a thousand turns of a thousandth, and back, end where they began. */
static void testNoDrift(void) {
  ctChainTree* tree = makeMolecules();
  double before[3 * PARTICLES];
  double after[3 * PARTICLES];
  ctGetPositions(tree, before);
  for (int n = 0; n < 10000; n++) {
    const double sign = n < 5000 ? 1 : -1;
    const ctChange change = {.link = 0,
                             .rotation = {sign * 0.003, sign * 0.004, sign * 0.012},
                             .pivot = {1, 1, 1},
                             .translation = {0, 0, 0}};
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctAccept(tree, NULL));
  }
  ctGetPositions(tree, after);
  for (int i = 0; i < 6; i++) {
    for (int j = 0; j < i; j++) {
      CHECK_NEAR(distanceIn(after, i, j), distanceIn(before, i, j), 1e-14);
    }
    CHECK_NEAR(after[3 * i], before[3 * i], 1e-12);
  }
  double state[3 * PARTICLES + 3 * 7 + 2];
  CHECK(ctGetStateSize(tree) == sizeof state / sizeof state[0]);
  ctGetState(tree, state);
  const double* q = state + 3 * PARTICLES; /* of link 0 */
  CHECK_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-15);
  ctDestroy(tree);
}

/* The least of motions is one, whichever number of the state it is in; the other molecule keeps its bits. */
static void testSmallestMotions(void) {
  const double least = 1e-12;
  double before[3 * PARTICLES];
  double after[3 * PARTICLES];
  for (int number = 0; number < 6; number++) {
    ctChainTree* tree = makeMolecules();
    ctGetPositions(tree, before);
    ctChange change = {.link = 0}; /* which has its origin in the pivot */
    double* vector = number < 3 ? change.rotation : change.translation;
    vector[number % 3] = least;
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    ctGetPositions(tree, after);
    for (int i = 0; i < PARTICLES; i++) {
      for (int k = 0; k < 3; k++) {
        const double* x = before + 3 * i;
        const double turned[3][3] = {{0, -x[2], x[1]}, {x[2], 0, -x[0]}, {-x[1], x[0], 0}};
        const double moved = number < 3 ? least * turned[number][k] : (k == number - 3 ? least : 0);
        CHECK_NEAR(after[3 * i + k], isOfSecond(i) ? x[k] : x[k] + moved, isOfSecond(i) ? 0 : 1e-15);
      }
    }
    CHECK(ctValidate(tree));
    ctDestroy(tree);
  }
}

int main(void) {
  testMoveAboutCentroid();
  testVerdict();
  testFreeOnTurning();
  testNoDrift();
  testSmallestMotions();
  return checkResult();
}
