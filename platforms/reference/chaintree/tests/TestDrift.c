/* By how much bonds, and angles at them, drift in a flexible scene, whose joints round the placements of their links at
 * each turn.
 *
 * Usage: TestDrift [trials]. 1e9 trials take a quarter of an hour. */
#include "check.h"

enum { LINKS = 5, SIDE = LINKS, PARTICLES = 2 * LINKS, TURNS = 100, DISTANCES = 3 };

static const double BOND = 0.15; /* nm */

/* nm: no distance may drift by more in 1e9 trials. */
static const double MOST_DRIFT = 1e-11;

static uint64_t lastRandom = 1;

/* From [-1, 1). */
static double randomSymmetric(void) {
  lastRandom = lastRandom * 6364136223846793005u + 1442695040888963407u;
  return (double)(lastRandom >> 11) * 0x1p-52 - 1;
}

static int randomBelow(int count) {
  return (int)((randomSymmetric() + 1) / 2 * count);
}

/* A chain whose link i has bead i, on its axis, and bead SIDE + i beside it. */
static ctChainTree* makeChain(ctJointKind joint) {
  double positions[3 * PARTICLES];
  double radii[PARTICLES];
  int links[PARTICLES];
  int parents[LINKS];
  uint8_t joints[LINKS];
  int torsions[LINKS][4];
  for (int i = 0; i < LINKS; i++) {
    const double bead[3] = {0.8 * BOND * i, i % 2 == 0 ? 0 : 0.6 * BOND, 0.3 * BOND * (i % 3)};
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = bead[k];
      positions[3 * (SIDE + i) + k] = bead[k] + (k == 2 ? 0.7 : 0.1) * BOND;
    }
    for (int particle = i; particle < PARTICLES; particle += SIDE) {
      radii[particle] = 0.01;
      links[particle] = i;
    }
    parents[i] = i - 1;
    joints[i] = (uint8_t)(i == 0 ? ctFreeJoint : joint);
    const int before = i == 0 ? 0 : i - 1;
    const int torsion[4] = {SIDE + before, before, i, SIDE + i};
    memcpy(torsions[i], torsion, sizeof torsion);
    if (joint == ctBallJoint && i % 2 == 0) {
      torsions[i][1] = i; /* turns about its own bead */
    }
  }
  const ctDefinition definition = {.particleCount = PARTICLES,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = LINKS,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions,
                                   .isFlexible = true};
  return checkedCreate(&definition);
}

static long double distanceOf(const double* positions, int i, int j) {
  long double squared = 0;
  for (int k = 0; k < 3; k++) {
    const long double apart = (long double)positions[3 * i + k] - positions[3 * j + k];
    squared += apart * apart;
  }
  return sqrtl(squared);
}

typedef long double Distances[LINKS][DISTANCES];

/* Distances that turns of a link keep: of the two beads of its bond, and of each from the other's side bead. Of a ball
 * joint: of its pivot from beads of both links. */
static void measure(const double* positions, ctJointKind joint, Distances distances) {
  for (int link = 1; link < LINKS; link++) {
    const bool isOwn = joint == ctTorsionJoint || link % 2 == 0;
    const bool isParents = joint == ctTorsionJoint || link % 2 == 1;
    distances[link][0] = distanceOf(positions, link - 1, link);
    distances[link][1] = isOwn ? distanceOf(positions, SIDE + link - 1, link) : distances[link][0];
    distances[link][2] = isParents ? distanceOf(positions, link - 1, SIDE + link) : distances[link][0];
  }
}

static void measureState(ctChainTree* tree, ctJointKind joint, Distances distances) {
  double positions[3 * PARTICLES];
  ctGetPositions(tree, positions);
  measure(positions, joint, distances);
}

static void turn(ctChainTree* tree) {
  const double most = randomBelow(2) == 0 ? 3.2 : 0.1;
  ctChange change = {.link = 1 + randomBelow(LINKS - 1), .angle = most * randomSymmetric()};
  for (int k = 0; k < 3; k++) {
    change.rotation[k] = most * randomSymmetric();
  }
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctAccept(tree, NULL));
}

/* Displaces a particle, unless a distance would become too short or long. */
static void displace(ctChainTree* tree, ctJointKind joint) {
  double positions[3 * PARTICLES];
  Distances distances;
  ctDisplacement displacement = {.particle = randomBelow(PARTICLES)};
  for (int k = 0; k < 3; k++) {
    displacement.shift[k] = 0.05 * BOND * randomSymmetric();
  }
  CHECK_SUCCESS(ctProposeDisplacements(tree, 1, &displacement));
  CHECK_SUCCESS(ctGetTrialPositions(tree, positions));
  measure(positions, joint, distances);
  for (int link = 1; link < LINKS; link++) {
    for (int n = 0; n < DISTANCES; n++) {
      if (distances[link][n] < 0.3L * BOND || distances[link][n] > 3 * BOND) {
        ctReject(tree);
        return;
      }
    }
  }
  CHECK_SUCCESS(ctAccept(tree, NULL));
}

/* Adds what turns have changed; returns the largest sum. */
static double addDrift(Distances before, Distances after, Distances drift) {
  long double most = 0;
  for (int link = 1; link < LINKS; link++) {
    for (int n = 0; n < DISTANCES; n++) {
      drift[link][n] += after[link][n] - before[link][n];
      most = fmaxl(most, fabsl(drift[link][n]));
    }
  }
  return (double)most;
}

/* Quaternions keep their length. */
static void checkQuaternions(ctChainTree* tree) {
  enum { PLACED = 10, SIZE = 3 * PARTICLES + 3 + PLACED * LINKS };
  double numbers[SIZE];
  CHECK(ctGetStateSize(tree) == SIZE);
  ctGetState(tree, numbers);
  for (int link = 0; link < LINKS; link++) {
    const double* q = numbers + 3 * PARTICLES + 3 + (size_t)PLACED * (size_t)link;
    CHECK_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-15);
  }
}

static void testDrift(ctJointKind joint, double trials) {
  ctChainTree* tree = makeChain(joint);
  Distances before;
  Distances after;
  Distances drift = {{0}};
  double most = 0;
  double nextLine = 1e4;
  for (double done = 0; done < trials;) {
    displace(tree, joint);
    measureState(tree, joint, before);
    for (int i = 0; i < TURNS; i++) {
      turn(tree);
    }
    measureState(tree, joint, after);
    most = addDrift(before, after, drift);
    done += TURNS + 1;
    if (done >= nextLine) {
      printf("%s joints, %g trials: %.2g nm\n", joint == ctBallJoint ? "ball" : "torsion", done, most);
      fflush(stdout);
      nextLine *= 10;
    }
  }
  /* As a random walk of roundings, with room for few turns and for what remains of a bias. */
  CHECK(most < MOST_DRIFT * sqrt(trials / 1e9));
  checkQuaternions(tree);
  ctDestroy(tree);
}

int main(int argumentCount, char** arguments) {
  const double trials = argumentCount > 1 ? atof(arguments[1]) : 1e6;
  testDrift(ctTorsionJoint, trials);
  testDrift(ctBallJoint, trials);
  return checkResult();
}
