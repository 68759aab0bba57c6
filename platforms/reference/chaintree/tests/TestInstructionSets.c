/* Every instruction set that the machine has gives the same bits: verdicts, counts, pairs, positions; whether trials
 * are tested by the tree or by clearances, which give the same verdicts. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "lattice.h"

enum { TRIALS = 3000 };

typedef struct Record {
  char name[16];
  bool clashes[TRIALS];
  int pairs[TRIALS][2];
  ctCounts counts;
  double positions[3 * SITES];
  PairCount neighbors;
  double energy;
  double forces[3 * SITES];
} Record;

/* Every third trial of a flexible scene displaces two particles, mostly neighbours. */
static ctStatus proposeTurnsOrShifts(ctChainTree* tree, int trial, const ctChange changes[2]) {
  if (!areFlexible || trial % 3 > 0) {
    return ctPropose(tree, 2, changes);
  }
  ctDisplacement displacements[2] = {{.particle = changes[0].link}, {.particle = changes[0].link + 1}};
  for (int k = 0; k < 3; k++) {
    displacements[0].shift[k] = 0.1 * changes[k % 2].angle;
    displacements[1].shift[k] = trial % 2 == 0 ? displacements[0].shift[k] : 0.01 * (k - trial % 5);
  }
  return ctProposeDisplacements(tree, 2, displacements);
}

static Record record(const char* set, const char* method) {
  Record result = {0};
  setenv("CHAINTREE_SIMD", set, 1);
  setenv("CHAINTREE_TRIALS", method, 1);
  ctChainTree* tree = makeLattice(ONE_CHAIN, 0.3, 0);
  snprintf(result.name, sizeof result.name, "%s", ctGetInstructionSet(tree));
  unsigned state = 1;
  for (int i = 0; i < TRIALS; i++) {
    /* Two turns of which the first is often small. */
    ctChange changes[2] = {{0}, {0}};
    for (int k = 0; k < 2; k++) {
      state = state * 1664525u + 1013904223u;
      changes[k].link = 2 * (1 + (int)(state >> 8) % (SITES / 2 - 2)) + k;
      changes[k].angle = (k == 0 ? 0.02 : 0.5) * (double)((int)(state >> 20) % 16 - 8);
    }
    CHECK_SUCCESS(proposeTurnsOrShifts(tree, i, changes));
    CHECK_SUCCESS(ctTestTrial(tree, &result.clashes[i], result.pairs[i], &result.counts));
    if (!result.clashes[i]) {
      CHECK_SUCCESS(ctAccept(tree, &result.counts));
    }
  }
  CHECK_SUCCESS(ctForEachNeighborPair(tree, 1.5, countPair, &result.neighbors, &result.counts));
  ctGetPositions(tree, result.positions);
  ctDestroy(tree);
  tree = makeLattice(ONE_CHAIN, 0.55, 0.01);
  CHECK_SUCCESS(ctSetPositions(tree, result.positions));
  CHECK_SUCCESS(ctComputeEnergy(tree, 2, &result.energy, result.forces, &result.counts));
  CHECK(result.energy > 0);
  ctDestroy(tree);
  return result;
}

static void testSets(void) {
  static Record byCourse[2];
  static Record found;
  const char* courses[] = {"tree", "clearances"};
  const char* sets[] = {"avx2", "avx512"};
  for (int c = 0; c < 2; c++) {
    Record* expected = &byCourse[c];
    *expected = record("portable", courses[c]);
    CHECK(strcmp(expected->name, "portable") == 0);
    for (int k = 0; k < 2; k++) {
      found = record(sets[k], courses[c]);
      printf("%s: %s\n", sets[k], found.name);
      CHECK(memcmp(expected->clashes, found.clashes, sizeof found.clashes) == 0);
      CHECK(memcmp(expected->pairs, found.pairs, sizeof found.pairs) == 0);
      CHECK(memcmp(&expected->counts, &found.counts, sizeof found.counts) == 0);
      CHECK(memcmp(expected->positions, found.positions, sizeof found.positions) == 0);
      CHECK(expected->neighbors.count == found.neighbors.count && expected->neighbors.value == found.neighbors.value);
    }
  }
  int accepted = 0;
  for (int i = 0; i < TRIALS; i++) {
    accepted += !byCourse[0].clashes[i];
  }
  CHECK(accepted > TRIALS / 10 && accepted < TRIALS);
  CHECK(memcmp(byCourse[0].clashes, byCourse[1].clashes, sizeof byCourse[0].clashes) == 0);
  CHECK(memcmp(byCourse[0].positions, byCourse[1].positions, sizeof byCourse[0].positions) == 0);
  CHECK(byCourse[0].counts.volumeTests != byCourse[1].counts.volumeTests);
}

int main(void) {
  testSets();
  areFlexible = true;
  testSets();
  return checkResult();
}
