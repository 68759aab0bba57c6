/* An energy that is kept, changed and taken back has the bits of one to which nothing has happened, and so have all
 * changes after that. */
#include "beadenergy.h"

static const int partCount = CT_ENERGY_PARTS;

/* Runs trials with these numbers, of which every third is dropped. Writes all changes. */
static void run(const Bench* bench, unsigned begin, unsigned end, double* changes) {
  for (unsigned number = begin; number < end; number++) {
    double ignored;
    proposeNumber(bench, number);
    for (int part = 0; part < partCount; part++) {
      double* change = changes != NULL ? changes++ : &ignored;
      CHECK(ctComputeEnergyChange(bench->energy, (ctEnergyPart)part, change, NULL) == ctSuccess);
    }
    if (number % 3 == 2) {
      ctReject(bench->tree);
    } else {
      CHECK(ctAccept(bench->tree, NULL) == ctSuccess);
      CHECK(ctAcceptEnergyChange(bench->energy) == ctSuccess);
    }
  }
}

static bool haveSameBits(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0;
}

/* Takes the first bench back as a test of many trials does, and compares it with one that has had none of them. */
static void testBits(void) {
  enum { BLOCK = 12 };
  static double changes[2][CT_ENERGY_PARTS * BLOCK];
  Bench bench = makeBench();
  Bench twin = makeBench();
  double* state = malloc(ctGetStateSize(bench.tree) * sizeof *state);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  CHECK(ctRefreshEnergy(twin.energy, NULL) == ctSuccess);
  run(&bench, 0, 20, NULL);
  run(&twin, 0, 20, NULL);
  double recomputed = 0;
  for (unsigned block = 0; block < 4; block++) {
    const unsigned begin = 100 * (block + 1);
    ctGetState(bench.tree, state);
    CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
    const double before = total(&bench);
    /* Twice from one copy; once with a trial left open, and once with a fold that gives leaves other neighbours. */
    for (int i = 0; i < 2; i++) {
      if (i == 1) {
        double change;
        propose(&bench);
        CHECK(computeChange(&bench, &change) == ctSuccess);
        CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
        CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
      }
      run(&bench, begin, begin + BLOCK, NULL);
      CHECK(fabs(total(&bench) - before) > 1e-3);
      if (i == 0) {
        proposeNumber(&bench, 7);
      }
      CHECK(ctSetState(bench.tree, state) == ctSuccess);
      CHECK(!ctIsEnergyOfState(bench.energy));
      CHECK(ctRestoreEnergy(bench.energy) == ctSuccess);
      CHECK(ctIsEnergyOfState(bench.energy));
      CHECK(haveSameBits(total(&bench), total(&twin)));
    }
    run(&bench, begin + 50, begin + 50 + BLOCK, changes[0]);
    run(&twin, begin + 50, begin + 50 + BLOCK, changes[1]);
    CHECK(memcmp(changes[0], changes[1], sizeof changes[0]) == 0);
    CHECK(haveSameBits(ctGetPairEnergy(bench.energy), ctGetPairEnergy(twin.energy)));
    CHECK(haveSameBits(ctGetTermEnergy(bench.energy, 0), ctGetTermEnergy(twin.energy, 0)));
    recomputed = total(&bench);
  }
  /* Recomputing would give other bits. */
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  CHECK(total(&bench) != recomputed && fabs(total(&bench) - recomputed) < 1e-3);
  free(state);
  destroyBench(&bench);
  destroyBench(&twin);
}

/* What is kept of no state belongs to none afterwards. */
static void testWithoutState(void) {
  Bench bench = makeBench();
  CHECK(ctRestoreEnergy(bench.energy) == ctInvalidArgument);
  CHECK(strstr(ctGetEnergyErrorText(bench.energy), "no copy") != NULL);
  CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  CHECK(ctRestoreEnergy(bench.energy) == ctSuccess);
  CHECK(!ctIsEnergyOfState(bench.energy));
  destroyBench(&bench);
}

/* A copy that was saved with other constants of the stand-in belongs to no state: the energy has to be refreshed. */
static void testConstants(void) {
  static double constants[BEADS];
  Bench bench = makeBench();
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  const double before = total(&bench);
  CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
  for (int i = 0; i < BEADS; i++) {
    constants[i] = 0.3;
  }
  ctSetStandIn(bench.energy, constants);
  CHECK(!ctIsEnergyOfState(bench.energy));
  CHECK(ctRestoreEnergy(bench.energy) == ctSuccess);
  CHECK(!ctIsEnergyOfState(bench.energy));
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  const double after = total(&bench);
  CHECK(fabs(after - before) > 1);
  CHECK(ctSaveEnergy(bench.energy) == ctSuccess);
  CHECK(ctRenewStandIn(bench.energy, NULL) == ctSuccess);
  CHECK(ctRestoreEnergy(bench.energy) == ctSuccess);
  CHECK(!ctIsEnergyOfState(bench.energy));
  destroyBench(&bench);
}

int main(void) {
  describe();
  for (int i = 0; i < 2; i++) {
    isFlexible = i == 1;
    described = &definition;
    testBits();
    testWithoutState();
    described = &definitionWithBorn;
    testBits();
    testWithoutState();
    testConstants();
  }
  return checkResult();
}
