/* Pairs within a cutoff by the engine of this project. */
#include "ourtree.h"
#include "pairfinder.h"

static void destroy(void* self) {
  ctDestroy(self);
}

static void* make(const Scene* scene) {
  return ourTreeOf(scene, 0);
}

/* Asks again with more room if there are more pairs than fit. */
static void find(void* self, const double* positions, double cutoff, PairList* pairs) {
  ctChainTree* tree = self;
  size_t count = 0;
  ourCheck(ctSetPositions(tree, positions));
  pairs->count = 0;
  do {
    pairListReserve(pairs, (int)count);
    ourCheck(ctGetNeighborPairs(tree, cutoff, false, (size_t)pairs->capacity, pairs->first, pairs->second, NULL, &count,
                                NULL));
  } while (count > (size_t)pairs->capacity);
  pairs->count = (int)count;
}

const PairFinder pairFinderOurs = {
    .name = "ours", .idea = "the engine of this project", .make = make, .destroy = destroy, .find = find};
