/* The constants of a stand-in: near sums, less what is taken from them, and constants are the whole Born sums, in long
 * double; what is set is got back, with the bits of the energy; where no particle is far, the stand-in is the whole
 * energy. And what is refused. */
#include "beadenergy.h"
#include "bornoracle.h"

static double now[3 * BEADS];
static double constants[BEADS];

/* After a fold, so that constants of the first state would not do. */
static void testConstants(void) {
  static double before[BEADS];
  Bench bench = makeBench();
  Bench other = makeBench();
  CHECK(ctRenewStandIn(bench.energy, NULL) == ctSuccess);
  ctGetStandIn(bench.energy, before);
  propose(&bench);
  CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
  CHECK(ctRenewStandIn(bench.energy, NULL) == ctSuccess);
  CHECK(ctIsEnergyOfState(bench.energy));
  ctGetStandIn(bench.energy, constants);
  CHECK(memcmp(before, constants, sizeof before) != 0);
  ctGetPositions(bench.tree, now);
  for (int i = 0; i < BEADS; i++) {
    const long double whole = oracleBornSum(&bornOfBeads, BEADS, now, i, INFINITY);
    const double cutoff = standInOfBeads.bornCutoff;
    const long double plain = oracleBornSum(&bornOfBeads, BEADS, now, i, cutoff);
    const long double near = plain - oracleBornTaken(&bornOfBeads, BEADS, now, i, cutoff);
    CHECK(whole - plain > 1e-3L);
    CHECK(fabsl(near + constants[i] - whole) < 2e-6L * (5 + whole));
  }
  propose(&other);
  CHECK(ctAccept(other.tree, NULL) == ctSuccess);
  ctSetStandIn(other.energy, constants);
  CHECK(!ctIsEnergyOfState(other.energy));
  CHECK(ctRefreshEnergy(other.energy, NULL) == ctSuccess);
  CHECK(ctGetPairEnergy(other.energy) == ctGetPairEnergy(bench.energy));
  ctGetStandIn(other.energy, before);
  CHECK(memcmp(before, constants, sizeof before) == 0);
  destroyBench(&bench);
  destroyBench(&other);
}

/* With cutoffs beyond the scene, all that the stand-in misses is that pairs vanish at its cutoff. */
static void testBeyond(void) {
  const ctNonbonded all = {charges, sigmas, epsilons, INFINITY, INFINITY, 1, BEADS, (const int(*)[2])exclusions, 0};
  const ctStandIn wide = {.bornCutoff = 1e4, .pairCutoff = 1e4, .gridWidth = 1e-3};
  const ctEnergyDefinition d = {.scene = &scene, .nonbonded = &all, .born = &bornOfBeads, .standIn = &wide};
  described = &d;
  Bench bench = makeBench();
  described = &definitionWithBorn;
  double whole[2];
  CHECK(ctRenewStandIn(bench.energy, NULL) == ctSuccess);
  ctGetStandIn(bench.energy, constants);
  for (int i = 0; i < BEADS; i++) {
    CHECK(fabs(constants[i]) < 1e-6); /* leaves and blocks may sum by other series */
  }
  CHECK(ctComputeWholeEnergy(bench.energy, &whole[0], &whole[1], NULL) == ctSuccess);
  const double expected = whole[0] + whole[1];
  CHECK(fabs(whole[1]) > 100);
  if (!(fabs(ctGetPairEnergy(bench.energy) - expected) < 2e-5 * fabs(expected))) {
    reportFailure("the stand-in is %.9g, not %.9g\n", ctGetPairEnergy(bench.energy), expected);
  }
  destroyBench(&bench);
}

/* ---- Refusals ---- */

static void checkRefusal(const ctEnergyDefinition* d, const char* culprit) {
  char text[200] = "";
  ctChainTree* tree;
  ctEnergy* energy;
  CHECK(ctCreate(&scene, &tree, NULL, 0) == ctSuccess);
  if (ctCreateEnergy(tree, d, &energy, text, sizeof text) != ctInvalidArgument || strstr(text, culprit) == NULL) {
    reportFailure("\"%s\" should name \"%s\"\n", text, culprit);
  }
  CHECK(energy == NULL);
  ctDestroy(tree);
}

static void testRefusals(void) {
  ctEnergyDefinition d = definitionWithBorn;
  d.standIn = NULL;
  checkRefusal(&d, "needs a nonbonded energy and a stand-in");
  d = definitionWithBorn;
  d.nonbonded = NULL;
  checkRefusal(&d, "needs a nonbonded energy and a stand-in");
  d = definitionWithBorn;
  const double bad[] = {0, -1, NAN, INFINITY};
  for (int i = 0; i < 4; i++) {
    ctStandIn standIn = {bad[i], 0.9, 0.05};
    d.standIn = &standIn;
    checkRefusal(&d, "cutoffs of the stand-in");
    standIn = (ctStandIn){0.8, bad[i], 0.05};
    checkRefusal(&d, "cutoffs of the stand-in");
    standIn = (ctStandIn){0.8, 0.9, bad[i]};
    checkRefusal(&d, "grid width");
  }
  d = definitionWithBorn;
  d.born = NULL; /* the stand-in is not read */
  char text[200] = "";
  ctChainTree* tree;
  ctEnergy* energy;
  CHECK(ctCreate(&scene, &tree, NULL, 0) == ctSuccess);
  CHECK(ctCreateEnergy(tree, &d, &energy, text, sizeof text) == ctSuccess);
  ctDestroyEnergy(energy);
  ctDestroy(tree);
}

/* Without Born radii, near pairs change back by the opposite; those of pair sets in any case. */
static void testWayBack(void) {
  double there = 0;
  described = &definition;
  Bench bench = makeBench();
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  propose(&bench);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    double change;
    CHECK(ctComputeEnergyChange(bench.energy, (ctEnergyPart)part, &change, NULL) == ctSuccess);
    there = part == ctNearPairsPart ? change : there;
  }
  CHECK(fabs(there) > 0.1 && ctGetNearChangeBack(bench.energy) == -there);
  destroyBench(&bench);
  described = &definitionWithBorn;
}

int main(void) {
  describe();
  described = &definitionWithBorn;
  testConstants();
  testBeyond();
  testRefusals();
  testWayBack();
  return checkResult();
}
