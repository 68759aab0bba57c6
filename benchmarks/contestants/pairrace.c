#include "pairrace.h"

#include <math.h>
#include <stdio.h>

#include "random.h"
#include "rigid.h"

/* Of distances in single precision, relative to the size of the scene. */
#define ROUNDING 1e-6

typedef struct PairLane {
  const PairFinder* finder;
  void* self;
  PairList list;
  double* times;
} PairLane;

/* ---- Comparison ---- */

static int compareKeys(const void* a, const void* b) {
  const int64_t x = *(const int64_t*)a;
  const int64_t y = *(const int64_t*)b;
  return (x > y) - (x < y);
}

/* A number for each pair, lower index first, sorted. */
static int64_t* keysOf(const PairList* list, int particleCount) {
  int64_t* keys = allocate(list->count, sizeof *keys);
  for (int k = 0; k < list->count; k++) {
    const int i = list->first[k];
    const int j = list->second[k];
    keys[k] = i < j ? (int64_t)i * particleCount + j : (int64_t)j * particleCount + i;
  }
  qsort(keys, (size_t)list->count, sizeof *keys, compareKeys);
  return keys;
}

/* Whether the pairs that only one of two lists has are about as far apart as the cutoff. */
static bool listsAgree(const PairRace* race, const double* positions, double precision, const PairList* a,
                       const PairList* b) {
  const int particleCount = race->scene->particleCount;
  int64_t* keysA = keysOf(a, particleCount);
  int64_t* keysB = keysOf(b, particleCount);
  bool agree = true;
  for (int i = 0, j = 0; (i < a->count || j < b->count) && agree;) {
    const int order = i == a->count ? 1 : j == b->count ? -1 : compareKeys(&keysA[i], &keysB[j]);
    if (order != 0) {
      const int64_t key = order < 0 ? keysA[i] : keysB[j];
      const double* x = positions + 3 * (key / particleCount);
      const double* y = positions + 3 * (key % particleCount);
      agree = fabs(sqrt(squaredDistance(x, y)) - race->cutoff) <= precision;
    }
    i += order <= 0;
    j += order >= 0;
  }
  free(keysA);
  free(keysB);
  return agree;
}

/* ---- Running ---- */

static double precisionOf(const PairRace* race) {
  double extent = race->cutoff;
  for (int i = 1; i < race->scene->particleCount; i++) {
    extent = fmax(extent, sqrt(squaredDistance(race->scene->spheres[0].x, race->scene->spheres[i].x)));
  }
  return ROUNDING * extent;
}

bool pairRaceRun(const PairRace* race, PairResult* results, char* error, size_t size) {
  const Scene* scene = race->scene;
  const double precision = precisionOf(race);
  double* positions = allocate(3 * scene->particleCount, sizeof(double));
  PairLane lanes[MOST_PAIR_FINDERS] = {{0}};
  for (int i = 0; i < race->finderCount; i++) {
    lanes[i].finder = race->finders[i];
    lanes[i].self = race->finders[i]->make(scene);
    lanes[i].times = allocate(race->repeats, sizeof(double));
  }
  Random random = {race->seed};
  bool success = true;
  for (int repeat = 0; repeat < race->repeats && success; repeat++) {
    for (int i = 0; i < 3 * scene->particleCount; i++) {
      positions[i] = scene->spheres[i / 3].x[i % 3] + 0.01 * race->cutoff * (2 * randomReal(&random) - 1);
    }
    for (int i = 0; i < race->finderCount; i++) {
      const double start = processorTime();
      lanes[i].finder->find(lanes[i].self, positions, race->cutoff, &lanes[i].list);
      lanes[i].times[repeat] = processorTime() - start;
    }
    for (int i = 1; i < race->finderCount && success; i++) {
      success = listsAgree(race, positions, precision, &lanes[0].list, &lanes[i].list);
      if (!success) {
        snprintf(error, size, "%s and %s list different pairs", lanes[0].finder->name, lanes[i].finder->name);
      }
    }
  }
  for (int i = 0; i < race->finderCount; i++) {
    if (success) {
      results[i] = (PairResult){medianOf(lanes[i].times, race->repeats), lanes[i].list.count};
    }
    lanes[i].finder->destroy(lanes[i].self);
    pairListFree(&lanes[i].list);
    free(lanes[i].times);
  }
  free(positions);
  return success;
}
