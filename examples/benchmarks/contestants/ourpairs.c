/* Pairs within a cutoff by the engine of this project. */
#include <string.h>

#include "ourtree.h"
#include "pairfinder.h"

typedef struct OurPairs {
  int particleCount;
  ctChainTree* tree;
  PairList found; /* of pairs that are still to be sorted */
  int* begins;
} OurPairs;

static void destroy(void* self) {
  OurPairs* ours = self;
  if (ours != NULL) {
    ctDestroy(ours->tree);
    pairListFree(&ours->found);
    free(ours->begins);
    free(ours);
  }
}

static void* make(const Scene* scene) {
  OurPairs* ours = calloc(1, sizeof *ours);
  if (ours == NULL) {
    return NULL;
  }
  ours->particleCount = scene->particleCount;
  ours->tree = ourTreeOf(scene, 0, 0, NULL);
  ours->begins = calloc((size_t)scene->particleCount + 2, sizeof(int));
  if (ours->tree == NULL || ours->begins == NULL) {
    destroy(ours);
    return NULL;
  }
  return ours;
}

static bool addPair(void* context, int particle1, int particle2, double value) {
  PairList* list = context;
  if (!pairListReserve(list, 1)) {
    return false;
  }
  list->first[list->count] = particle1;
  list->second[list->count] = particle2;
  list->distances[list->count++] = value;
  return true;
}

static bool list(OurPairs* ours, const double* positions, double cutoff, PairList* pairs) {
  pairs->count = 0;
  return ctSetPositions(ours->tree, positions) == ctSuccess &&
         ctForEachNeighborPair(ours->tree, cutoff, addPair, pairs, NULL) == ctSuccess;
}

static bool findUnsorted(void* self, const double* positions, double cutoff, PairList* pairs) {
  return list(self, positions, cutoff, pairs);
}

/* By counting, which keeps the order of pairs whose keys are equal. */
static void sortBy(const int* keys, int keyCount, int* begins, const PairList* from, PairList* to) {
  memset(begins, 0, ((size_t)keyCount + 2) * sizeof(int));
  for (int k = 0; k < from->count; k++) {
    begins[keys[k] + 1]++;
  }
  for (int i = 0; i < keyCount; i++) {
    begins[i + 1] += begins[i];
  }
  for (int k = 0; k < from->count; k++) {
    const int place = begins[keys[k]]++;
    to->first[place] = from->first[k];
    to->second[place] = from->second[k];
    to->distances[place] = from->distances[k];
  }
  to->count = from->count;
}

static bool findSorted(void* self, const double* positions, double cutoff, PairList* pairs) {
  OurPairs* ours = self;
  pairs->count = 0;
  ours->found.count = 0;
  if (!list(ours, positions, cutoff, pairs) || !pairListReserve(&ours->found, pairs->count)) {
    return false;
  }
  sortBy(pairs->second, ours->particleCount, ours->begins, pairs, &ours->found);
  sortBy(ours->found.first, ours->particleCount, ours->begins, &ours->found, pairs);
  return true;
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
