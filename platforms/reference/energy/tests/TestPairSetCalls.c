/* What creating an energy with pair sets refuses, and how; and how often pairs of interaction groups count. */
#include "beadenergy.h"

static ctStatus create(const ctPairSet* sets, int count, const uint8_t* whichAreListed, char* text, size_t size) {
  ctDefinition partly = scene;
  ctEnergyDefinition wanted = {.scene = &partly, .pairSetCount = count, .pairSets = sets};
  ctChainTree* tree;
  ctEnergy* energy;
  partly.listed = whichAreListed;
  CHECK(ctCreate(&partly, &tree, NULL, 0) == ctSuccess);
  const ctStatus status = ctCreateEnergy(tree, &wanted, &energy, text, size);
  CHECK((status == ctSuccess) == (energy != NULL));
  ctDestroyEnergy(energy);
  ctDestroy(tree);
  return status;
}

/* The second of two sets is wrong. */
static void checkRefused(const ctPairSet* set, const char* expected) {
  const ctPairSet sets[] = {pairSet, *set};
  char text[200] = "";
  CHECK(create(sets, 2, listed, text, sizeof text) == ctInvalidArgument);
  if (strcmp(text, expected) != 0) {
    reportFailure("\"%s\", not \"%s\"\n", text, expected);
  }
}

static void testCounts(void) {
  char text[200];
  CHECK(create(&pairSet, -1, listed, text, sizeof text) == ctInvalidArgument);
  CHECK(strcmp(text, "there are -1 pair sets") == 0);
  ctPairSet set = pairSet;
  set.operationCount = 0;
  checkRefused(&set, "pair set 1 has 0 operations, 1 tables, 1 parameters a particle, 600 exclusions and 1 groups");
  set = pairSet;
  set.groupCount = -1;
  checkRefused(&set, "pair set 1 has 6 operations, 1 tables, 1 parameters a particle, 600 exclusions and -1 groups");
  set = pairSet;
  set.cutoff = NAN;
  checkRefused(&set, "the cutoff of pair set 1 is nan nm, but has to be above 0");
  set.cutoff = 0;
  checkRefused(&set, "the cutoff of pair set 1 is 0 nm, but has to be above 0");
}

static void testOperations(void) {
  ctOperation operations[6];
  ctPairSet set = pairSet;
  set.operations = operations;
  const struct Wrong {
    int number;
    ctOperation operation;
    const char* text;
  } wrong[] = {
      {5, {(ctOperator)99, {0, 0, 0}, 0}, "operation 5 of pair set 1 has the unknown operator 99"},
      {5, {(ctOperator)-1, {0, 0, 0}, 0}, "operation 5 of pair set 1 has the unknown operator -1"},
      {0, {ctInputOperator, {1, 0, 0}, 0}, "operation 0 of pair set 1 reads input 1; there are 1"},
      {2, {ctParameterOperator, {2, 0, 0}, 0}, "operation 2 of pair set 1 reads parameter 2; there are 2"},
      {2, {ctParameterOperator, {-1, 0, 0}, 0}, "operation 2 of pair set 1 reads parameter -1; there are 2"},
      {3, {ctTableOperator, {1, 2, 0}, 1}, "operation 3 of pair set 1 reads table 1; there are 1"},
      {3, {ctTableOperator, {1, 2, 0}, 0.5}, "operation 3 of pair set 1 reads table 0.5; there are 1"},
      {3, {ctTableOperator, {1, 2, 0}, NAN}, "operation 3 of pair set 1 reads table nan; there are 1"},
      {3,
       {ctTableOperator, {1, 3, 0}, 0},
       "operation 3 of pair set 1 needs the result of operation 3, which is not an earlier one"},
      {5,
       {ctSelectOperator, {1, 2, 5}, 0},
       "operation 5 of pair set 1 needs the result of operation 5, which is not an earlier one"},
      {5,
       {ctAddOperator, {1, -1, 0}, 0},
       "operation 5 of pair set 1 needs the result of operation -1, which is not an earlier one"},
  };
  for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
    memcpy(operations, pairOperations, sizeof operations);
    operations[wrong[i].number] = wrong[i].operation;
    checkRefused(&set, wrong[i].text);
  }
}

static void testTables(void) {
  ctTable table = heightTable;
  ctPairSet set = pairSet;
  set.tables = &table;
  table.dimensions = 4;
  checkRefused(&set, "table 0 of pair set 1 has 4 dimensions");
  table = (ctTable){.dimensions = 3, .sizes = {1, 1, 1}, .maxima = {1, 1, 1}, .values = heights};
  checkRefused(&set, "table 0 of pair set 1 has 3 dimensions");
  table = heightTable;
  table.sizes[1] = 0;
  checkRefused(&set, "table 0 of pair set 1 has the size 0");
  table = (ctTable){.dimensions = 1, .sizes = {1}, .minima = {1}, .maxima = {1}, .values = heights};
  checkRefused(&set, "table 0 of pair set 1 has the range from 1 to 1");
}

static void testParticles(void) {
  static double wrongKinds[BEADS];
  static int wrongExclusions[BEADS][2];
  static uint8_t partlyListed[BEADS];
  ctPairSet set = pairSet;
  memcpy(wrongKinds, kinds, sizeof kinds);
  wrongKinds[17] = INFINITY;
  set.parameters = wrongKinds;
  checkRefused(&set, "parameter 0 of particle 17 of pair set 1 is inf");
  set = pairSet;
  memcpy(wrongExclusions, exclusions, sizeof exclusions);
  wrongExclusions[3][1] = BEADS;
  set.exclusions = (const int(*)[2])wrongExclusions;
  checkRefused(&set, "exclusion 3 of pair set 1 names particle 600, but there are 600 particles");
  const int strangers[] = {4, -2};
  ctInteractionGroup group = {.counts = {1, 2}, .particles = {allBeads, strangers}};
  set = pairSet;
  set.groups = &group;
  checkRefused(&set, "group 0 of pair set 1 names particle -2, but there are 600 particles");
  group.counts[1] = -1;
  checkRefused(&set, "group 0 of pair set 1 has a set of -1 particles");
  /* Only what counts has to stand in a leaf. */
  memcpy(partlyListed, listed, sizeof listed);
  partlyListed[4] = 0;
  char text[200];
  set = pairSet;
  CHECK(create(&set, 1, partlyListed, text, sizeof text) == ctInvalidArgument);
  CHECK(strcmp(text, "particle 4, which is in group 0 of pair set 0, stands in no leaf") == 0);
  group = (ctInteractionGroup){.counts = {2, 3}, .particles = {allBeads, allBeads + 5}};
  set.groups = &group;
  CHECK(create(&set, 1, partlyListed, text, sizeof text) == ctSuccess);
  set.groupCount = 0;
  CHECK(create(&set, 1, partlyListed, text, sizeof text) == ctInvalidArgument);
  CHECK(strcmp(text, "particle 4 stands in no leaf") == 0);
}

/* The energy of a set whose pairs are 1 each: how often pairs count. */
static double countPairs(int groupCount, const ctInteractionGroup* groups, int exclusionCount,
                         const int (*excluded)[2]) {
  const ctOperation one = {ctConstantOperator, {7, -7, 7}, 1};
  const ctPairSet set = {.operationCount = 1,
                         .operations = &one,
                         .cutoff = INFINITY,
                         .exclusionCount = exclusionCount,
                         .exclusions = excluded,
                         .groupCount = groupCount,
                         .groups = groups};
  const ctEnergyDefinition wanted = {.scene = &scene, .pairSetCount = 1, .pairSets = &set};
  ctChainTree* tree;
  ctEnergy* energy;
  CHECK(ctCreate(&scene, &tree, NULL, 0) == ctSuccess);
  CHECK(ctCreateEnergy(tree, &wanted, &energy, NULL, 0) == ctSuccess);
  CHECK(ctRefreshEnergy(energy, NULL) == ctSuccess);
  const double sum = ctGetPairSetEnergy(energy, 0);
  ctDestroyEnergy(energy);
  ctDestroy(tree);
  return sum;
}

static void testGroups(void) {
  const int excluded[][2] = {{0, 1}, {1, 0}, {5, 3}, {7, 7}};
  CHECK(countPairs(0, NULL, 0, NULL) == BEADS * (BEADS - 1) / 2);
  CHECK(countPairs(0, NULL, 4, excluded) == BEADS * (BEADS - 1) / 2 - 2);
  /* Both in both sets; one set in the other; apart; none. */
  const ctInteractionGroup groups[] = {{{10, 10}, {allBeads, allBeads}},
                                       {{4, 10}, {allBeads, allBeads}},
                                       {{4, 6}, {allBeads, allBeads + 300}},
                                       {{0, 6}, {allBeads, allBeads}}};
  CHECK(countPairs(1, groups, 0, NULL) == 45);
  CHECK(countPairs(1, groups + 1, 0, NULL) == 6 + 24);
  CHECK(countPairs(1, groups + 2, 0, NULL) == 24);
  CHECK(countPairs(1, groups + 3, 0, NULL) == 0);
  /* Each group counts for itself. */
  CHECK(countPairs(4, groups, 0, NULL) == 45 + 30 + 24);
  CHECK(countPairs(4, groups, 4, excluded) == 45 + 30 + 24 - 2 - 2);
}

int main(void) {
  describe();
  testCounts();
  testOperations();
  testTables();
  testParticles();
  testGroups();
  return checkResult();
}
