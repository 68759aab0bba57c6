/* Trials that displace particles within their links, and turns about axes whose particles have been displaced. */
#include "chain.h"

enum { LINKS = 60, PARTICLES = 2 * LINKS, SIDE = LINKS };

static uint64_t lastRandom = 5;

/* From [-1, 1). */
static double randomSymmetric(void) {
  lastRandom = lastRandom * 6364136223846793005u + 1442695040888963407u;
  return (double)(lastRandom >> 11) * 0x1p-52 - 1;
}

static int randomBelow(int count) {
  return (int)((randomSymmetric() + 1) / 2 * count);
}

/* Each link has its bead i of the chain, about which links turn, and a side bead SIDE + i, which may be without a
 * radius. */
static Chain describeChain(double radius, ctJointKind joint) {
  const Chain chain = allocateChain(PARTICLES, LINKS, ctFreeJoint);
  for (int i = 0; i < LINKS; i++) {
    const double position[3] = {0.3 * i, i % 2 == 0 ? 0 : 0.2, 10 + 0.1 * (i % 3)};
    setBead(&chain, i, position, radius);
    double* side = chain.positions + 3 * (size_t)(SIDE + i);
    memcpy(side, position, sizeof position);
    side[2] += 0.25;
    chain.radii[SIDE + i] = i % 5 == 0 ? 0 : radius;
    chain.particleLinks[SIDE + i] = i;
    if (i > 0) {
      chain.joints[i] = (uint8_t)joint;
    }
    if (joint == ctBallJoint) {
      chain.torsions[i][1] = i % 2 == 0 ? i : i - 1;
    }
  }
  return chain;
}

static ctChainTree* makeFlexible(double radius, ctJointKind joint, double tolerance) {
  const Chain chain = describeChain(radius, joint);
  const ctDefinition definition = {.particleCount = PARTICLES,
                                   .positions = chain.positions,
                                   .radii = chain.radii,
                                   .particleLinks = chain.particleLinks,
                                   .linkCount = LINKS,
                                   .linkParents = chain.parents,
                                   .linkJoints = chain.joints,
                                   .linkTorsions = (const int(*)[4])chain.torsions,
                                   .overlapTolerance = tolerance,
                                   .isFlexible = true};
  ctChainTree* tree = checkedCreate(&definition);
  free(chain.positions);
  free(chain.radii);
  free(chain.particleLinks);
  free(chain.parents);
  free(chain.joints);
  free(chain.torsions);
  return tree;
}

/* ---- What is expected, from positions alone ---- */

typedef long double Point[3];

static void turnAbout(const Point from, const long double axis[3], long double angle, Point x) {
  long double length = sqrtl(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const long double u[3] = {axis[0] / length, axis[1] / length, axis[2] / length};
  const long double r[3] = {x[0] - from[0], x[1] - from[1], x[2] - from[2]};
  const long double along = u[0] * r[0] + u[1] * r[1] + u[2] * r[2];
  const long double c = cosl(angle);
  const long double s = sinl(angle);
  for (int k = 0; k < 3; k++) {
    const long double crossed = u[(k + 1) % 3] * r[(k + 2) % 3] - u[(k + 2) % 3] * r[(k + 1) % 3];
    x[k] = from[k] + c * r[k] + s * crossed + (1 - c) * along * u[k];
  }
}

static int linkOf(int particle) {
  return particle % SIDE;
}

/* Turns all that hang on a link about the bond from the bead before. */
static void expectTurn(Point* x, int link, double angle) {
  long double axis[3];
  Point from;
  for (int k = 0; k < 3; k++) {
    axis[k] = x[link][k] - x[link - 1][k];
    from[k] = x[link][k];
  }
  for (int i = 0; i < PARTICLES; i++) {
    if (linkOf(i) >= link) {
      turnAbout(from, axis, angle, x[i]);
    }
  }
}

static void expectBallTurn(Point* x, int link, const double rotation[3]) {
  const int pivot = link % 2 == 0 ? link : link - 1;
  const long double axis[3] = {rotation[0], rotation[1], rotation[2]};
  Point from;
  memcpy(from, x[pivot], sizeof from);
  const long double angle = sqrtl(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  for (int i = 0; i < PARTICLES; i++) {
    if (linkOf(i) >= link) {
      turnAbout(from, axis, angle, x[i]);
    }
  }
}

static long double distanceOf(const Point a, const Point b) {
  long double squared = 0;
  for (int k = 0; k < 3; k++) {
    squared += (a[k] - b[k]) * (a[k] - b[k]);
  }
  return sqrtl(squared);
}

/* The largest overlap of a pair whose distance changes. */
static long double worstOverlap(const Point* before, const Point* after, double radius) {
  long double worst = -INFINITY;
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      const bool areModelled = (i < SIDE || linkOf(i) % 5 != 0) && (j < SIDE || linkOf(j) % 5 != 0);
      const long double distance = distanceOf(after[i], after[j]);
      if (areModelled && fabsl(distance - distanceOf(before[i], before[j])) > 1e-10) {
        worst = fmaxl(worst, 2 * radius - distance);
      }
    }
  }
  return worst;
}

/* ---- The engine ---- */

/* Proposes a displacement of one to four particles, of the same or of different links, by one or by different shifts.
 */
static void proposeDisplacements(ctChainTree* tree, double size, Point* x) {
  ctDisplacement displacements[4];
  const int count = 1 + randomBelow(4);
  for (int i = 0; i < count; i++) {
    displacements[i].particle = (randomBelow(PARTICLES / 4) * 4 + i) % PARTICLES;
    for (int k = 0; k < 3; k++) {
      displacements[i].shift[k] = i > 0 && i % 2 == 1 ? displacements[i - 1].shift[k] : size * randomSymmetric();
      x[displacements[i].particle][k] += displacements[i].shift[k];
    }
  }
  CHECK_SUCCESS(ctProposeDisplacements(tree, count, displacements));
  const int* particles;
  const int* links;
  CHECK(ctGetTrialParticles(tree, &particles) == count);
  CHECK(ctGetTrialLinks(tree, &links) == 0);
}

static void proposeTurn(ctChainTree* tree, ctJointKind joint, Point* x) {
  ctChange change = {.link = 1 + randomBelow(LINKS - 1), .angle = 0.2 * randomSymmetric()};
  for (int k = 0; k < 3; k++) {
    change.rotation[k] = 0.3 * randomSymmetric();
  }
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  if (joint == ctTorsionJoint) {
    expectTurn(x, change.link, change.angle);
  } else {
    expectBallTurn(x, change.link, change.rotation);
  }
}

static void checkPositions(const double* positions, const Point* expected) {
  for (int i = 0; i < PARTICLES; i++) {
    for (int k = 0; k < 3; k++) {
      CHECK_NEAR(positions[3 * i + k], (double)expected[i][k], 1e-11);
    }
  }
}

/* A new scene with the numbers of the state has its bits. */
static void checkCopy(ctChainTree* tree, double radius, ctJointKind joint, double tolerance) {
  double* state = malloc(ctGetStateSize(tree) * sizeof *state);
  double positions[2][3 * PARTICLES];
  ctChainTree* copy = makeFlexible(radius, joint, tolerance);
  ctGetState(tree, state);
  CHECK(ctGetStateSize(copy) == ctGetStateSize(tree));
  CHECK_SUCCESS(ctSetState(copy, state));
  ctGetPositions(tree, positions[0]);
  ctGetPositions(copy, positions[1]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  ctDestroy(copy);
  free(state);
}

static void testProgram(ctJointKind joint, double radius, double tolerance) {
  ctChainTree* tree = makeFlexible(radius, joint, tolerance);
  static double positions[3 * PARTICLES];
  static double proposed[3 * PARTICLES];
  static Point x[PARTICLES];
  static Point trial[PARTICLES];
  ctGetPositions(tree, positions);
  for (int i = 0; i < 3 * PARTICLES; i++) {
    x[i / 3][i % 3] = positions[i];
  }
  int clashes = 0;
  int accepted = 0;
  for (int move = 0; move < 4000; move++) {
    memcpy(trial, x, sizeof trial);
    if (randomSymmetric() < 0.5) {
      proposeDisplacements(tree, 0.1, trial);
    } else {
      proposeTurn(tree, joint, trial);
    }
    bool clash;
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    const long double beyond = worstOverlap(x, trial, radius) - tolerance;
    CHECK(fabsl(beyond) < 1e-9L || clash == (beyond > 0));
    clashes += clash;
    if (clash) {
      ctReject(tree);
      ctGetPositions(tree, proposed);
      CHECK(memcmp(proposed, positions, sizeof positions) == 0);
    } else {
      CHECK_SUCCESS(ctGetTrialPositions(tree, proposed));
      CHECK_SUCCESS(ctAccept(tree, NULL));
      ctGetPositions(tree, positions);
      CHECK(memcmp(proposed, positions, sizeof positions) == 0);
      memcpy(x, trial, sizeof x);
      accepted++;
    }
    checkPositions(positions, x);
    if (move % 100 == 0) {
      CHECK(ctValidate(tree));
      checkCopy(tree, radius, joint, tolerance);
    }
  }
  CHECK(clashes > 100 && accepted > 500);
  ctDestroy(tree);
}

int main(void) {
  testProgram(ctTorsionJoint, 0.1, 0.02);
  testProgram(ctBallJoint, 0.1, 0.02);
  return checkResult();
}
