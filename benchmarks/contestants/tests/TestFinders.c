/* Finders of pairs and of least distances, in every instruction set that is here, find what all pairs show. */
#include <math.h>
#include <string.h>

#include "branches.h"
#include "chains.h"
#include "nearestrace.h"
#include "pairrace.h"
#include "rigid.h"
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
static bool findNothing(void* self, const double* positions, double cutoff, PairList* list) {
  (void)self;
  (void)positions;
  (void)cutoff;
  list->count = 0;
  return true;
}

static void testDisagreement(void) {
  const InstructionSet* set = instructionSetFind("portable");
  const PairFinder* brute = pairFinderFind(set, "brute", strlen("brute"));
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

/* Each finder by itself, after each of some turns. */
static void testNearest(void) {
  enum { OBSTACLES = 50, TURNS = 40 };
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  Random random = {4};
  Scene* scene = makeBranches(MOST_BRANCH_LINKS, 3, 2);
  double obstacles[3 * OBSTACLES];
  for (int i = 0; i < 3 * OBSTACLES; i++) {
    obstacles[i] = 20 * randomReal(&random) + (i % 3 == 0 ? 10 : -10);
  }
  for (int s = 0; s < setCount; s++) {
    for (const NearestFinder* const* f = sets[s]->nearestFinders; *f != NULL; f++) {
      void* self = (*f)->make(scene, OBSTACLES, obstacles);
      Sphere* spheres = malloc((size_t)scene->particleCount * sizeof *spheres);
      CHECK(self != NULL && spheres != NULL);
      memcpy(spheres, scene->spheres, (size_t)scene->particleCount * sizeof *spheres);
      for (int t = 0; t < TURNS; t++) {
        const Turn turn = {randomInt(&random, scene->torsionCount), PI * (2 * randomReal(&random) - 1)};
        const Torsion* torsion = &scene->torsions[turn.torsion];
        const Rigid motion = rigidTurn(spheres[torsion->axis[0]].x, spheres[torsion->axis[1]].x, turn.angle);
        for (int i = torsion->first; i < torsion->last; i++) {
          const Sphere before = spheres[i];
          rigidApply(&motion, before.x, spheres[i].x);
        }
        double least = INFINITY;
        for (int i = 0; i < scene->particleCount * OBSTACLES; i++) {
          least = fmin(least, squaredDistance(spheres[i / OBSTACLES].x, obstacles + 3 * (i % OBSTACLES)));
        }
        Nearest nearest = {0};
        CHECK((*f)->turn(self, turn) && (*f)->find(self, &nearest));
        CHECK(fabs(nearest.distance - sqrt(least)) < 1e-5);
        CHECK(fabs(squaredDistance(spheres[nearest.particle].x, obstacles + 3 * nearest.obstacle) - least) < 1e-3);
      }
      free(spheres);
      (*f)->destroy(self);
    }
  }
  sceneFree(scene);
}

static void testNearestRace(void) {
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  Scene* scene = chainHilbert(200);
  for (int s = 0; s < setCount; s++) {
    NearestRace race = {.scene = scene, .obstacleCount = 100, .seed = 1, .repeats = 20};
    for (const NearestFinder* const* f = sets[s]->nearestFinders; *f != NULL; f++) {
      race.finders[race.finderCount++] = *f;
    }
    Quartiles times[MOST_NEAREST_FINDERS];
    char error[200] = "";
    if (!nearestRaceRun(&race, times, error, sizeof error)) {
      reportFailure("%s: %s\n", sets[s]->name, error);
    }
  }
  sceneFree(scene);
}

int main(void) {
  testPairs();
  testDisagreement();
  testNearest();
  testNearestRace();
  return checkResult();
}
