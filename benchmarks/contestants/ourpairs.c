/* Pairs within a cutoff by the engine of this project. */
#include "ourtree.h"
#include "pairfinder.h"

static void destroy(void* self) {
  ctDestroy(self);
}

static void* make(const Scene* scene) {
  return ourTreeOf(scene, 0, 0, NULL);
}

/* Asks again with more room if there are more than fit. */
static bool find(ctChainTree* tree, const double* positions, double cutoff, bool sorted, PairList* pairs) {
  if (ctSetPositions(tree, positions) != ctSuccess) {
    return false;
  }
  pairs->count = 0;
  for (;;) {
    size_t count;
    if (ctGetNeighborPairs(tree, cutoff, sorted, (size_t)pairs->capacity, pairs->first, pairs->second,
                           sorted ? pairs->distances : NULL, &count, NULL) != ctSuccess) {
      return false;
    }
    if (count <= (size_t)pairs->capacity) {
      pairs->count = (int)count;
      return true;
    }
    if (!pairListReserve(pairs, (int)count)) {
      return false;
    }
  }
}

static bool findUnsorted(void* self, const double* positions, double cutoff, PairList* pairs) {
  return find(self, positions, cutoff, false, pairs);
}

static bool findSorted(void* self, const double* positions, double cutoff, PairList* pairs) {
  return find(self, positions, cutoff, true, pairs);
}

const PairFinder pairFinderOurs = {.name = "ours",
                                   .idea = "the engine of this project",
                                   .order = pairsInAnyOrder,
                                   .make = make,
                                   .destroy = destroy,
                                   .find = findUnsorted};

const PairFinder pairFinderOursSorted = {.name = "ours-sorted",
                                         .idea = "the engine of this project, pairs in order",
                                         .order = pairsSorted,
                                         .make = make,
                                         .destroy = destroy,
                                         .find = findSorted};
