/* Pairs within a cutoff by testing all pairs, in double precision: the measure of right and wrong. */
#include <math.h>

#include "pairfinder.h"
#include "rigid.h"

static void* make(const Scene* scene) {
  int* particleCount = malloc(sizeof *particleCount);
  if (particleCount != NULL) {
    *particleCount = scene->particleCount;
  }
  return particleCount;
}

static bool find(void* self, const double* positions, double cutoff, PairList* list) {
  const int* particleCount = self;
  list->count = 0;
  for (int i = 0; i < *particleCount; i++) {
    if (!pairListReserve(list, *particleCount)) {
      return false;
    }
    for (int j = i + 1; j < *particleCount; j++) {
      const double distance = sqrt(squaredDistance(positions + 3 * i, positions + 3 * j));
      if (distance <= cutoff) {
        list->first[list->count] = i;
        list->second[list->count] = j;
        list->distances[list->count++] = distance;
      }
    }
  }
  return true;
}

const PairFinder pairFinderBrute = {.name = "brute",
                                    .idea = "all pairs of particles",
                                    .order = pairsSorted,
                                    .make = make,
                                    .destroy = free,
                                    .find = find};
