/* Where one particle may donate and the other accept, they may overlap by the allowance more. */
#include "beads.h"

static const double allowance = 0.06;

/* Two beads that overlap by 0.08, beyond the tolerance of 0.04 but within the allowance. */
static Beads makePair(const uint8_t* roles) {
  const Beads beads = {.count = 2,
                       .positions = {0, 0, 0, 0.12, 0, 0},
                       .radii = {0.1, 0.1},
                       .roles = roles,
                       .tolerance = 0.04,
                       .allowance = allowance};
  return beads;
}

static void testRoles(void) {
  static const bool bonds[4][4] = {{0, 0, 0, 0}, {0, 0, 1, 1}, {0, 1, 0, 1}, {0, 1, 1, 1}};
  for (uint8_t a = 0; a < 4; a++) {
    for (uint8_t b = 0; b < 4; b++) {
      const uint8_t roles[] = {a, b};
      const Beads beads = makePair(roles);
      ctChainTree* tree = makeBeads(&beads);
      const bool bond = bonds[a][b];
      CHECK(isListed(tree, 0, 1) == !bond);
      CHECK(clashesShifted(tree, 1, 0.001) == !bond);
      CHECK(clashesShifted(tree, 1, -0.03)); /* overlap 0.11 is too much for any */
      double energy;
      CHECK_SUCCESS(ctComputeEnergy(tree, 2, &energy, NULL, NULL));
      CHECK_NEAR(energy, bond ? 0 : 0.04 * 0.04, 1e-15);
      ctDestroy(tree);
    }
  }
}

static void testDepth(void) {
  const uint8_t roles[] = {ctDonor, ctAcceptor};
  Beads beads = makePair(roles);
  beads.positions[3] = 0.05; /* overlap 0.15: 0.05 beyond tolerance and allowance */
  ctChainTree* tree = makeBeads(&beads);
  PairCount pairs = {0};
  double energy;
  CHECK_SUCCESS(ctForEachClash(tree, countPair, &pairs, NULL));
  CHECK(pairs.count == 1);
  CHECK_NEAR(pairs.value, 0.15, 1e-15);
  CHECK_SUCCESS(ctComputeEnergy(tree, 2, &energy, NULL, NULL));
  CHECK_NEAR(energy, 0.05 * 0.05, 1e-15);
  /* the limit of a pair that may bond is above its allowance, or none */
  const int pair[][2] = {{0, 1}};
  const double within = 0.09;
  CHECK_SUCCESS(ctSetLimits(tree, 1, pair, &within));
  CHECK(ctGetLimitCount(tree) == 0);
  ctDestroy(tree);
}

static void testNoRoles(void) {
  const Beads beads = makePair(NULL);
  ctChainTree* tree = makeBeads(&beads);
  CHECK(isListed(tree, 0, 1));
  ctDestroy(tree);
}

int main(void) {
  testRoles();
  testDepth();
  testNoRoles();
  return checkResult();
}
