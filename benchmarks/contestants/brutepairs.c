/* Pairs within a cutoff by testing all pairs, in double precision: the measure of right and wrong. */
#include "pairfinder.h"
#include "rigid.h"

static void* make(const Scene* scene) {
  int* particleCount = allocate(1, sizeof *particleCount);
  *particleCount = scene->particleCount;
  return particleCount;
}

static void find(void* self, const double* positions, double cutoff, PairList* list) {
  const int particleCount = *(const int*)self;
  list->count = 0;
  for (int i = 0; i < particleCount; i++) {
    pairListReserve(list, particleCount);
    for (int j = i + 1; j < particleCount; j++) {
      if (squaredDistance(positions + 3 * i, positions + 3 * j) <= cutoff * cutoff) {
        list->first[list->count] = i;
        list->second[list->count++] = j;
      }
    }
  }
}

const PairFinder pairFinderBrute = {
    .name = "brute", .idea = "all pairs of particles", .make = make, .destroy = free, .find = find};
