/* Finders of pairs, in every instruction set that is here, find the pairs of a search through all. */
#include <string.h>

#include "branches.h"
#include "chains.h"
#include "pairrace.h"
#include "sets.h"

/* The race compares lists; the first is that of all pairs. */
static int countPairs(const Scene* scene, double cutoff, const InstructionSet* set) {
  PairRace race = {.scene = scene, .cutoff = cutoff, .seed = 3, .repeats = 2};
  for (const PairFinder* const* f = set->pairFinders; *f != NULL; f++) {
    race.finders[race.finderCount++] = *f;
  }
  CHECK(strcmp(race.finders[0]->name, "brute") == 0);
  PairResult results[MOST_PAIR_FINDERS];
  char error[200] = "";
  if (!pairRaceRun(&race, results, error, sizeof error)) {
    reportFailure("cutoff %g, %s: %s\n", cutoff, set->name, error);
    return 0;
  }
  return results[0].pairCount;
}

static void testPairs(void) {
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  Random random = {1};
  Scene* cube = chainRandom(500, &random);
  Scene* branches = makeBranches(MOST_BRANCH_LINKS, 4, 1);
  Scene* straight = chainSerpentine(300);
  for (int i = 0; i < 300; i++) {
    straight->spheres[i].x[0] = 1000.0 * i; /* cells for all of them would be too many */
    straight->spheres[i].x[1] = straight->spheres[i].x[2] = 0;
  }
  for (int s = 0; s < setCount; s++) {
    CHECK(countPairs(cube, 1, sets[s]) == 0);
    CHECK(countPairs(cube, 4.5, sets[s]) > 1000);
    CHECK(countPairs(cube, 9, sets[s]) > 5000);
    CHECK(countPairs(cube, 100, sets[s]) == 500 * 499 / 2);
    CHECK(countPairs(branches, 2.5, sets[s]) > 100);
    CHECK(countPairs(straight, 5, sets[s]) == 0);
    CHECK(countPairs(straight, 1500, sets[s]) >= 299);
  }
  sceneFree(cube);
  sceneFree(branches);
  sceneFree(straight);
}

/* A race notices when finders disagree. */
static void findNothing(void* self, const double* positions, double cutoff, PairList* list) {
  (void)self;
  (void)positions;
  (void)cutoff;
  list->count = 0;
}

static void testDisagreement(void) {
  const InstructionSet* set = instructionSetFind("portable");
  const PairFinder* brute = pairFinderFind(set, "brute");
  PairFinder idle = *brute;
  idle.name = "idle";
  idle.find = findNothing;
  Scene* scene = chainHilbert(64);
  const PairRace race = {
      .scene = scene, .cutoff = 5, .seed = 1, .repeats = 1, .finderCount = 2, .finders = {brute, &idle}};
  PairResult results[2];
  char error[200] = "";
  CHECK(!pairRaceRun(&race, results, error, sizeof error));
  CHECK(strstr(error, "idle") != NULL);
  sceneFree(scene);
}

int main(void) {
  testPairs();
  testDisagreement();
  return checkResult();
}
