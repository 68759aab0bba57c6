/* Energy and forces: by hand for a pair, by finite differences for a crowd. */
#include "arm.h"
#include "beads.h"

static void testPair(void) {
  const Beads beads = {
      .count = 2, .positions = {0, 0, 0, 0.3, 0.4, 0}, .radii = {0.4, 0.3}, .tolerance = 0.1}; /* 0.1 too deep */
  ctChainTree* tree = makeBeads(&beads);
  double energy;
  double forces[6] = {1, 2, 3, 4, 5, 6};
  CHECK_SUCCESS(ctComputeEnergy(tree, 1000, &energy, forces, NULL));
  CHECK_NEAR(energy, 0.5 * 1000 * 0.1 * 0.1, 1e-12);
  const double expected[6] = {1 - 60, 2 - 80, 3, 4 + 60, 5 + 80, 6};
  for (int i = 0; i < 6; i++) {
    CHECK_NEAR(forces[i], expected[i], 1e-11);
  }
  CHECK_FAILURE(tree, ctInvalidArgument, "nan", ctComputeEnergy(tree, NAN, &energy, forces, NULL));
  ctDestroy(tree);
}

/* Particles at one place are pushed apart along x, the lower one to +x, whatever the order of the links. */
static void testCoincident(void) {
  const Beads beads = {.count = 4,
                       .positions = {0.7, 0.1, 0.2, 1.9, 0.3, 0.9, 0.7, 0.1, 0.2, 1.9, 0.3, 0.9},
                       .radii = {0.1, 0.1, 0.1, 0.1}};
  ctChainTree* tree = makeBeads(&beads);
  double energy;
  double forces[12] = {0};
  CHECK_SUCCESS(ctComputeEnergy(tree, 1, &energy, forces, NULL));
  CHECK_NEAR(energy, 2 * 0.5 * 0.2 * 0.2, 1e-15);
  for (int i = 0; i < 12; i++) {
    CHECK_NEAR(forces[i], i % 3 != 0 ? 0 : i < 6 ? 0.2 : -0.2, 1e-15);
  }
  ctDestroy(tree);
}

static double energyAt(ctChainTree* tree, const double* positions) {
  double energy;
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  CHECK_SUCCESS(ctComputeEnergy(tree, 1, &energy, NULL, NULL));
  return energy;
}

/* A curled arm of fat beads, in a state that turns have made. */
static void testGradient(void) {
  enum { LINKS = 40, COORDINATES = 6 * LINKS };
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.8);
  for (int link = 1; link < LINKS; link++) {
    turnArm(arm, link, 0.9 + 0.01 * link * link);
  }
  double positions[COORDINATES];
  double forces[COORDINATES] = {0};
  double energy;
  ctGetPositions(arm, positions);
  CHECK_SUCCESS(ctComputeEnergy(arm, 1, &energy, forces, NULL));
  CHECK(energy > 10);
  CHECK_NEAR(energyAt(arm, positions), energy, 1e-10);
  double sum[3] = {0, 0, 0};
  double torque[3] = {0, 0, 0};
  for (int i = 0; i < COORDINATES; i++) {
    const double step = 1e-6;
    const double here = positions[i];
    positions[i] = here + step;
    const double above = energyAt(arm, positions);
    positions[i] = here - step;
    const double below = energyAt(arm, positions);
    positions[i] = here;
    /* half a step's kink if a pair just touches, and the rounding of the energies */
    CHECK_NEAR(forces[i], (below - above) / (2 * step), 1e-5);
    sum[i % 3] += forces[i];
  }
  for (int i = 0; i < COORDINATES; i += 3) {
    const double* x = positions + i;
    const double* f = forces + i;
    torque[0] += x[1] * f[2] - x[2] * f[1];
    torque[1] += x[2] * f[0] - x[0] * f[2];
    torque[2] += x[0] * f[1] - x[1] * f[0];
  }
  for (int d = 0; d < 3; d++) {
    CHECK_NEAR(sum[d], 0, 1e-10);
    CHECK_NEAR(torque[d], 0, 1e-9);
  }
  ctDestroy(arm);
}

int main(void) {
  testPair();
  testCoincident();
  testGradient();
  return checkResult();
}
