/* Ball joints: what turns about a particle, of its own link or of the parent. */
#include "chain.h"

enum { BEADS = 40 };

static uint64_t lastRandom = 17;

/* From [-1, 1). */
static double randomSymmetric(void) {
  lastRandom = lastRandom * 6364136223846793005u + 1442695040888963407u;
  return (double)(lastRandom >> 11) * 0x1p-52 - 1;
}

/* A zigzag of beads. Each but the first hangs by a ball joint on the one before and turns about that, or with
 * aboutOwn about itself. */
static ctChainTree* makeBeadChain(int beads, bool aboutOwn, ctJointKind rootJoint) {
  const Chain chain = allocateChain(beads, beads, rootJoint);
  for (int i = 0; i < beads; i++) {
    const double position[3] = {0.3 * i, i % 2 == 0 ? 0 : 0.2, 10};
    setBead(&chain, i, position, 0.05);
    chain.joints[i] = (uint8_t)(i == 0 ? rootJoint : ctBallJoint);
    chain.torsions[i][1] = aboutOwn ? i : i - 1;
  }
  return createChain(&chain);
}

static void turn(ctChainTree* tree, int link, double x, double y, double z) {
  /* Members of a change that a ball joint does not have are not read. */
  const ctChange change = {.link = link, .rotation = {x, y, z}, .pivot = {NAN}, .translation = {INFINITY}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctAccept(tree, NULL));
}

/* A quarter turn about z takes (x, y) to (-y, x), about the pivot. */
static void testPivot(void) {
  for (int aboutOwn = 0; aboutOwn < 2; aboutOwn++) {
    ctChainTree* tree = makeBeadChain(6, aboutOwn, ctFreeJoint);
    double before[18];
    double after[18];
    ctGetPositions(tree, before);
    turn(tree, 3, 0, 0, 0.5 * PI);
    ctGetPositions(tree, after);
    const double* pivot = before + (size_t)(aboutOwn ? 9 : 6);
    CHECK(memcmp(before, after, sizeof(double[9])) == 0);
    for (int i = 3; i < 6; i++) {
      CHECK_NEAR(after[3 * i], pivot[0] - (before[3 * i + 1] - pivot[1]), 1e-14);
      CHECK_NEAR(after[3 * i + 1], pivot[1] + (before[3 * i] - pivot[0]), 1e-14);
      CHECK_NEAR(after[3 * i + 2], before[3 * i + 2], 1e-14);
    }
    /* Axes are those of the world, however far the parent and the link have turned: about x, then about z. */
    memcpy(before, after, sizeof before);
    turn(tree, 4, 0.5 * PI, 0, 0);
    turn(tree, 4, 0, 0, 0.5 * PI);
    ctGetPositions(tree, after);
    pivot = before + (size_t)(aboutOwn ? 12 : 9);
    double arm[3];
    for (int k = 0; k < 3; k++) {
      arm[k] = before[15 + k] - pivot[k];
    }
    CHECK_NEAR(after[15], pivot[0] + arm[2], 1e-14);
    CHECK_NEAR(after[16], pivot[1] + arm[0], 1e-14);
    CHECK_NEAR(after[17], pivot[2] + arm[1], 1e-14);
    CHECK(ctValidate(tree));
    ctDestroy(tree);
  }
}

static double bondLength(const double* positions, int i) {
  double squared = 0;
  for (int k = 0; k < 3; k++) {
    const double d = positions[3 * i + k] - positions[3 * i - 3 + k];
    squared += d * d;
  }
  return sqrt(squared);
}

/* Bonds keep their lengths through any number of moves, with joint centres in the parent and in the link, and a scene
 * made from the numbers of the state has its bits. */
static void testNoDrift(void) {
  ctChainTree* tree = makeBeadChain(BEADS, false, ctFixedJoint);
  for (int move = 0; move < 200000; move++) {
    const int link = 1 + move % (BEADS - 1);
    turn(tree, link, 3 * randomSymmetric(), 3 * randomSymmetric(), 3 * randomSymmetric());
  }
  double positions[3 * BEADS];
  ctGetPositions(tree, positions);
  for (int i = 1; i < BEADS; i++) {
    CHECK_NEAR(bondLength(positions, i), sqrt(0.13), 1e-14);
  }
  CHECK(ctValidate(tree));

  /* Reference positions, and a quaternion for each link but the fixed one. */
  enum { SIZE = 3 * BEADS + 4 * (BEADS - 1) };
  CHECK(ctGetStateSize(tree) == SIZE);
  double state[SIZE];
  double other[3 * BEADS];
  ctGetState(tree, state);
  for (int i = 0; i < BEADS - 1; i++) {
    const double* q = state + (size_t)(3 * BEADS + 4 * i);
    CHECK_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-15);
  }
  ctChainTree* fresh = makeBeadChain(BEADS, false, ctFixedJoint);
  CHECK_SUCCESS(ctSetState(fresh, state));
  ctGetPositions(fresh, other);
  CHECK(memcmp(positions, other, sizeof positions) == 0);
  state[3 * BEADS] += 1e-9;
  CHECK(ctSetState(fresh, state) == ctInvalidArgument);
  ctDestroy(fresh);
  ctDestroy(tree);
}

/* A trial that is dropped leaves every bit; turning there and back leads to the reference, up to rounding. */
static void testReject(void) {
  ctChainTree* tree = makeBeadChain(BEADS, true, ctFreeJoint);
  double before[3 * BEADS];
  double after[3 * BEADS];
  turn(tree, 7, 0.3, -1, 2);
  ctGetPositions(tree, before);
  const ctChange change = {.link = 20, .rotation = {1, 2, 3}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  ctReject(tree);
  ctGetPositions(tree, after);
  CHECK(memcmp(before, after, sizeof before) == 0);
  turn(tree, 20, 1, 2, 3);
  turn(tree, 20, -1, -2, -3);
  ctGetPositions(tree, after);
  for (int i = 0; i < 3 * BEADS; i++) {
    CHECK_NEAR(after[i], before[i], 1e-13);
  }
  const ctChange endless = {.link = 20, .rotation = {0, INFINITY, 0}};
  CHECK(ctPropose(tree, 1, &endless) == ctInvalidArgument);
  ctDestroy(tree);
}

int main(void) {
  testPivot();
  testNoDrift();
  testReject();
  return checkResult();
}
