/* Energies of trials that displace single particles, in turns with turns of torsions: their changes are those of an
 * oracle in long double and of another scene at these positions, have the same bits by every instruction set, and
 * belong to the positions alone. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "beadenergy.h"

enum { TRIALS = 240 };

static const char* const instructionSets[] = {"avx512", "avx2", "portable"};
static double now[3 * BEADS];

static bool haveSameBits(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0;
}

/* ---- In long double ---- */

static long double distanceOf(const double* x, int i, int j) {
  long double squared = 0;
  for (int d = 0; d < 3; d++) {
    const long double apart = (long double)x[3 * i + d] - x[3 * j + d];
    squared += apart * apart;
  }
  return sqrtl(squared);
}

static long double switched(long double r, long double from, long double to) {
  const long double t = r > from ? (r - from) / (to - from) : 0;
  return 1 - t * t * t * (10 - t * (15 - 6 * t));
}

static long double pairOf(const double* x, int i, int j) {
  const bool isExcluded = (i + 2) % BEADS == j || (j + 2) % BEADS == i;
  const long double r = distanceOf(x, i, j);
  long double energy = 0;
  if (!isExcluded && r < nonbonded.cutoff) {
    const long double cutoff = nonbonded.cutoff;
    const long double both = 2 * (long double)nonbonded.dielectric + 1;
    const long double k = (nonbonded.dielectric - 1) / (both * cutoff * cutoff * cutoff);
    const long double c = 3 * nonbonded.dielectric / (both * cutoff);
    const long double sixth = powl(0.1L / r, 6);
    energy += 4 * 0.2L * (sixth * sixth - sixth) * switched(r, nonbonded.switchingDistance, cutoff);
    energy += CT_COULOMB * (long double)charges[i] * charges[j] * (1 / r + k * r * r - c);
  }
  if (!isExcluded && r < pairSet.cutoff && (i % 2 == 0 || j % 2 == 0)) {
    const double height = heights[(int)kinds[i] + 2 * (int)kinds[j]];
    energy += height / (r * r) * switched(r, pairSet.switchingDistance, pairSet.cutoff);
  }
  return energy;
}

/* k (1 + cos phi) of a torsion of consecutive beads; periodicity and phase are 1 and 0. */
static long double torsionOf(const double* x, int first) {
  long double b[3][3];
  long double n[2][3];
  for (int k = 0; k < 3; k++) {
    for (int d = 0; d < 3; d++) {
      b[k][d] = (long double)x[3 * (first + k + 1) + d] - x[3 * (first + k) + d];
    }
  }
  for (int k = 0; k < 2; k++) {
    for (int d = 0; d < 3; d++) {
      n[k][d] = b[k][(d + 1) % 3] * b[k + 1][(d + 2) % 3] - b[k][(d + 2) % 3] * b[k + 1][(d + 1) % 3];
    }
  }
  long double products[3] = {0, 0, 0};
  for (int d = 0; d < 3; d++) {
    products[0] += n[0][d] * n[1][d];
    products[1] += n[0][d] * n[0][d];
    products[2] += n[1][d] * n[1][d];
  }
  return 3 * (1 + products[0] / sqrtl(products[1] * products[2]));
}

static long double oracle(const double* x) {
  long double energy = 0;
  for (int i = 0; i < BEADS; i++) {
    for (int j = 0; j < i; j++) {
      energy += pairOf(x, i, j);
    }
  }
  for (int i = 0; i < LINKS; i++) {
    energy += torsionOf(x, i);
  }
  return energy;
}

/* ---- Programs ---- */

static void accept(const Bench* bench) {
  CHECK(ctAccept(bench->tree, NULL) == ctSuccess);
  CHECK(ctAcceptEnergyChange(bench->energy) == ctSuccess);
}

/* A folded chain, whose leaves have many neighbours, with the constants of the stand-in. */
static Bench makeFolded(void) {
  Bench bench = makeBench();
  proposeTimes(&bench, 0.3);
  CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
  CHECK(ctRenewStandIn(bench.energy, NULL) == ctSuccess);
  return bench;
}

/* The energy of all positions, as another scene of the same definition has it. */
static double recompute(const Bench* other, const double* x) {
  CHECK(ctSetPositions(other->tree, x) == ctSuccess);
  CHECK(ctRefreshEnergy(other->energy, NULL) == ctSuccess);
  return total(other);
}

/* kJ/mol: rounding of pairs, and of radii that are at the middle between two of the grid. */
static double tolerance = 2e-3;

static void testChanges(bool hasOracle) {
  Bench bench = makeFolded();
  Bench other = makeFolded();
  ctGetPositions(bench.tree, now);
  double before = recompute(&other, now);
  long double expectedBefore = hasOracle ? oracle(now) : 0;
  double greatest = 0;
  double worst = 0;
  for (unsigned number = 0; number < TRIALS; number++) {
    double change = NAN;
    proposeNumber(&bench, number);
    CHECK(computeChange(&bench, &change) == ctSuccess);
    CHECK(ctGetTrialPositions(bench.tree, now) == ctSuccess);
    const double after = recompute(&other, now);
    CHECK_NEAR(change, after - before, tolerance);
    worst = fmax(worst, fabs(change - (after - before)));
    greatest = fmax(greatest, fabs(change));
    if (hasOracle && number % 4 == 1) {
      ctGetPositions(bench.tree, now);
      expectedBefore = oracle(now);
      CHECK(ctGetTrialPositions(bench.tree, now) == ctSuccess);
      CHECK_NEAR(change, (double)(oracle(now) - expectedBefore), tolerance);
    }
    if (number % 3 == 2) {
      ctReject(bench.tree);
    } else {
      accept(&bench);
      before = after;
    }
    CHECK_NEAR(total(&bench), before, tolerance);
  }
  CHECK(greatest > 1);
  printf("worst error %.2g kJ/mol\n", worst);
  destroyBench(&bench);
  destroyBench(&other);
}

/* What trials change, and what comes out in the end. */
typedef struct Course {
  double changes[TRIALS];
  double energy;
  double whole[2];
} Course;

/* `rejects`: before each trial others are rejected, after none of their parts, some or all. */
static void run(bool rejects, Course* course) {
  Bench bench = makeFolded();
  for (unsigned number = 0; number < TRIALS; number++) {
    for (int parts = 0; parts <= CT_ENERGY_PARTS && rejects; parts++) {
      proposeNumber(&bench, 1000 + 4 * number + (unsigned)parts);
      for (int part = 0; part < parts; part++) {
        double ignored;
        CHECK(ctComputeEnergyChange(bench.energy, (ctEnergyPart)part, &ignored, NULL) == ctSuccess);
      }
      ctReject(bench.tree);
    }
    proposeNumber(&bench, number);
    CHECK(computeChange(&bench, &course->changes[number]) == ctSuccess);
    accept(&bench);
  }
  course->energy = total(&bench);
  CHECK(ctComputeWholeEnergy(bench.energy, &course->whole[0], &course->whole[1], NULL) == ctSuccess);
  destroyBench(&bench);
}

/* By each instruction set, with rejected trials in between or without. */
static void testBits(void) {
  static Course courses[2];
  for (int i = 0; i < 3; i++) {
    for (int rejects = 0; rejects < 2; rejects++) {
      setenv("CHAINTREE_SIMD", instructionSets[i], 1);
      Course* course = &courses[i + rejects > 0 ? 1 : 0];
      run(rejects == 1, course);
      CHECK(memcmp(course, &courses[0], sizeof *course) == 0);
    }
  }
  unsetenv("CHAINTREE_SIMD");
}

/* Another scene with the numbers of the state has the bits, of the energy and of trials. */
static void testOtherScene(void) {
  static double constants[BEADS];
  Bench bench = makeFolded();
  for (unsigned number = 0; number < TRIALS; number++) {
    double ignored;
    proposeNumber(&bench, number);
    CHECK(computeChange(&bench, &ignored) == ctSuccess);
    accept(&bench);
  }
  Bench other = makeBench();
  double* state = malloc(ctGetStateSize(bench.tree) * sizeof *state);
  ctGetState(bench.tree, state);
  CHECK(ctSetState(other.tree, state) == ctSuccess);
  free(state);
  ctGetStandIn(bench.energy, constants);
  CHECK(ctSetStandIn(other.energy, constants) == ctSuccess);
  const double kept = total(&bench);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  CHECK(ctRefreshEnergy(other.energy, NULL) == ctSuccess);
  CHECK_NEAR(kept, total(&bench), tolerance);
  CHECK(haveSameBits(total(&bench), total(&other)));
  double whole[2][2];
  CHECK(ctComputeWholeEnergy(bench.energy, &whole[0][0], &whole[0][1], NULL) == ctSuccess);
  CHECK(ctComputeWholeEnergy(other.energy, &whole[1][0], &whole[1][1], NULL) == ctSuccess);
  CHECK(memcmp(whole[0], whole[1], sizeof whole[0]) == 0);
  for (unsigned number = 500; number < 540; number++) {
    double changes[2];
    proposeNumber(&bench, number);
    proposeNumber(&other, number);
    CHECK(computeChange(&bench, &changes[0]) == ctSuccess);
    CHECK(computeChange(&other, &changes[1]) == ctSuccess);
    CHECK(haveSameBits(changes[0], changes[1]));
    accept(&bench);
    accept(&other);
  }
  destroyBench(&bench);
  destroyBench(&other);
}

/* A particle that is displaced onto others, one after another, and back leaves nothing of the large energies. */
static void testClashes(void) {
  Bench bench = makeFolded();
  const double before = total(&bench);
  for (int i = 0; i < 60; i++) {
    const int bead = 10 * i + 3;
    double pair[6];
    CHECK(ctGetPositionsOf(bench.tree, false, 2, (const int[]){bead, bead + 3 + i % 3}, pair) == ctSuccess);
    ctDisplacement displacement = {bead, {0, 0, 0}};
    for (int way = 1; way >= -1; way -= 2) {
      double change;
      for (int d = 0; d < 3; d++) {
        displacement.shift[d] = way * 0.995 * (pair[3 + d] - pair[d]);
      }
      CHECK(ctProposeDisplacements(bench.tree, 1, &displacement) == ctSuccess);
      CHECK(computeChange(&bench, &change) == ctSuccess);
      CHECK(fabs(change) > 1e4);
      accept(&bench);
    }
    CHECK_NEAR(total(&bench), before, tolerance);
  }
  destroyBench(&bench);
}

/* ---- Other models ---- */

/* Salt, spheres within others, neither necks nor rescaled radii; and necks of all pairs within the cutoff. */
static void testModels(void) {
  ctBorn born = bornOfBeads;
  ctEnergyDefinition d = definitionWithBorn;
  d.born = &born;
  described = &d;
  born.neckTypeCount = 0;
  born.isRescaled = false;
  born.isFilled = true;
  born.kappa = 5;
  testChanges(false);
  born = bornOfBeads;
  born.neckCut = 0.6;
  testChanges(false);
}

/* Charges alone, in a box that is so small that leaves are near their own images, and particles near any others. */
static void testSmallBox(void) {
  static const double box[3][3] = {{1.9, 0, 0}, {0.3, 2, 0}, {-0.4, 0.5, 2.1}};
  static double none[BEADS];
  const ctNonbonded plain = {.charges = charges,
                             .sigmas = none,
                             .epsilons = none,
                             .cutoff = 0.9,
                             .switchingDistance = INFINITY,
                             .dielectric = 78};
  ctBorn born = bornOfBeads;
  ctEnergyDefinition d = definitionWithBorn;
  born.cutoff = 0.9;
  d.born = &born;
  d.nonbonded = &plain;
  d.pairSetCount = 0;
  described = &d;
  boxOfBenches = box;
  tolerance = 0.01;
  testChanges(false);
  boxOfBenches = NULL;
}

int main(void) {
  describe();
  isFlexible = true;
  described = &definition;
  testChanges(true);
  testBits();
  testOtherScene();
  described = &definitionWithBorn;
  testChanges(false);
  testBits();
  testOtherScene();
  testClashes();
  testModels();
  testSmallBox();
  return checkResult();
}
