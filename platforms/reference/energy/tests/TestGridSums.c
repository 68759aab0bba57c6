/* Sums that are kept by sections of leaves: leaves whose particles are far apart, particles that are 32 nm from each
 * other and would be one on the grid, energies that are too large for sums of integers, atoms that move alone and
 * together. Against sums over all pairs in double, and with the same bits by every instruction set. Where what moves is
 * one section, what is kept has the bits of what is computed anew. */
#define _POSIX_C_SOURCE 200809L /* setenv */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "branches.h"
#include "ctenergy.h"

enum { TRIALS = 400, MOST_SETS = 3 };

#define CUTOFF 1.0

static Branches branches;
static uint8_t listed[MOST_ATOMS];
static double charges[MOST_ATOMS];
static bool isLeafLink[MOST_ATOMS]; /* of a link: it has no children */

/* q1 q2 / r^2 */
static const ctOperation operations[] = {{ctInputOperator, {0}, 0},     {ctParameterOperator, {0}, 0},
                                         {ctParameterOperator, {1}, 0}, {ctMultiplyOperator, {1, 2}, 0},
                                         {ctSquareOperator, {0}, 0},    {ctDivideOperator, {3, 4}, 0}};

typedef struct Bench {
  ctChainTree* tree;
  ctEnergy* energy;
} Bench;

static Bench makeBench(const char* instructions) {
  ctDefinition scene = describeBranches(&branches);
  scene.listed = listed;
  const ctPairSet set = {.operationCount = 6,
                         .operations = operations,
                         .parametersPerParticle = 1,
                         .parameters = charges,
                         .cutoff = CUTOFF,
                         .switchingDistance = CUTOFF};
  const ctEnergyDefinition definition = {.scene = &scene, .pairSetCount = 1, .pairSets = &set};
  Bench bench;
  setenv("CHAINTREE_SIMD", instructions, 1);
  CHECK(ctCreate(&scene, &bench.tree, NULL, 0) == ctSuccess);
  CHECK(ctCreateEnergy(bench.tree, &definition, &bench.energy, NULL, 0) == ctSuccess);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  return bench;
}

static void destroyBench(Bench* bench) {
  ctDestroyEnergy(bench->energy);
  ctDestroy(bench->tree);
}

/* The energy over all pairs, and the sum of their sizes. */
static double oracle(const Bench* bench, double* size) {
  static double positions[3 * MOST_ATOMS];
  double sum = 0;
  *size = 0;
  ctGetPositions(bench->tree, positions);
  for (int i = 0; i < branches.atomCount; i++) {
    for (int j = 0; j < i; j++) {
      double squared = 0;
      for (int d = 0; d < 3; d++) {
        const double along = positions[3 * i + d] - positions[3 * j + d];
        squared += along * along;
      }
      if (squared < CUTOFF * CUTOFF) {
        sum += charges[i] * charges[j] / squared;
        *size += fabs(charges[i] * charges[j] / squared);
      }
    }
  }
  return sum;
}

static void checkEnergy(const Bench* bench, const char* what, int trial) {
  double size;
  const double expected = oracle(bench, &size);
  const double found = ctGetPairSetEnergy(bench->energy, 0);
  if (!(fabs(found - expected) <= 1e-5 * size + 1e-6)) {
    reportFailure("%s, trial %d: the energy is %.12g, not %.12g\n", what, trial, found, expected);
  }
}

/* Tries a change of one joint, and takes one of two; false if the joint is fixed. Adds the bits of the change. */
static bool runTrial(const Bench* bench, int link, const char* what, int trial, uint64_t* bits) {
  const ctChange change = drawChange(&branches, link);
  double sum = 0;
  if (ctPropose(bench->tree, 1, &change) != ctSuccess) {
    return false;
  }
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    double ofPart;
    CHECK(ctComputeEnergyChange(bench->energy, (ctEnergyPart)part, &ofPart, NULL) == ctSuccess);
    sum += ofPart;
  }
  uint64_t own;
  memcpy(&own, &sum, sizeof own);
  *bits = *bits * 31 + own;
  const double before = ctGetPairSetEnergy(bench->energy, 0);
  if (trial % 2 == 0) {
    ctDiscard(bench->tree);
    return true;
  }
  CHECK(ctCommit(bench->tree, NULL) == ctSuccess);
  CHECK(ctAcceptEnergyChange(bench->energy) == ctSuccess);
  const double after = ctGetPairSetEnergy(bench->energy, 0);
  if (!(fabs(before + sum - after) <= 1e-9 * (fabs(before) + fabs(after) + fabs(sum)))) {
    reportFailure("%s, trial %d: the energy changes by %.12g, not %.12g\n", what, trial, after - before, sum);
  }
  return true;
}

/* Runs trials by each instruction set; with `alone` only such as move one section. */
static void runTrials(const char* what, bool alone) {
  static const char* const sets[MOST_SETS] = {"portable", "avx2", "avx512"};
  const uint64_t start = branches.chance;
  uint64_t first = 0;
  for (int i = 0; i < MOST_SETS; i++) {
    branches.chance = start;
    uint64_t bits = 0;
    Bench bench = makeBench(sets[i]);
    checkEnergy(&bench, what, -1);
    int run = 0;
    for (int trial = 0; run < TRIALS; trial++) {
      const int link = drawBelow(&branches, branches.linkCount);
      if (branches.joints[link] == ctFixedJoint || (alone && !isLeafLink[link])) {
        continue;
      }
      run += runTrial(&bench, link, what, trial, &bits) ? 1 : 0;
      if (run % 16 == 0) {
        checkEnergy(&bench, what, trial);
      }
    }
    const double kept = ctGetPairSetEnergy(bench.energy, 0);
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    const double anew = ctGetPairSetEnergy(bench.energy, 0);
    if (alone && memcmp(&kept, &anew, sizeof kept) != 0) {
      reportFailure("%s: the energy is kept as %.17g, but is %.17g\n", what, kept, anew);
    }
    first = i == 0 ? bits : first;
    if (bits != first) {
      reportFailure("%s: %s has other bits\n", what, sets[i]);
    }
    destroyBench(&bench);
  }
}

/* Two molecules `apart` from each other along x, all far out along y. */
static void describe(uint64_t seed, double apart, double farOut) {
  memset(&branches, 0, sizeof branches);
  branches.chance = seed;
  addMolecule(&branches, 75, ctFreeJoint, 0.2, 0.5);
  addMolecule(&branches, 57, ctFreeJoint, 0.2, 0.5);
  for (int i = 0; i < branches.atomCount; i++) {
    branches.radii[i] = 0;
    listed[i] = 1;
    charges[i] = drawReal(&branches) - 0.4;
    branches.positions[3 * i] += i < 75 ? 0 : apart;
    branches.positions[3 * i + 1] += farOut;
  }
  for (int link = 0; link < branches.linkCount; link++) {
    isLeafLink[link] = branches.joints[link] == ctTorsionJoint;
  }
  for (int link = 0; link < branches.linkCount; link++) {
    if (branches.parents[link] != CT_NULL) {
      isLeafLink[branches.parents[link]] = false;
    }
  }
}

int main(void) {
  describe(0x1234567, 0, 0);
  runTrials("two molecules", false);
  describe(0x1234567, 0, 0);
  runTrials("atoms alone", true);
  describe(0x7654321, 32, 0);
  runTrials("32 nm apart", false);
  describe(0x7654321, 64, 1e5);
  runTrials("64 nm apart and far out", true);

  /* Two atoms that are near each other: 3e6 for that pair. */
  describe(0x1111111, 0, 0);
  for (int d = 0; d < 3; d++) {
    branches.positions[3 * 90 + d] = branches.positions[3 * 20 + d] + 3e-3;
  }
  charges[20] = 10;
  charges[90] = 10;
  runTrials("atoms near each other", false);
  return checkResult();
}
