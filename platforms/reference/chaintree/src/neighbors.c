/* Pairs of particles within a cutoff. */
#include <string.h>

#include "scene.h"

typedef struct Cutoff {
  ctChainTree* tree;
  double distance;
  double tieBand;
} Cutoff;

static bool isNeighbor(void* context, int slotA, int slotB, double squaredDistance) {
  const Cutoff* cutoff = context;
  const double distance = sqrt(squaredDistance);
  const bool doubtful = fabs(distance - cutoff->distance) <= cutoff->tieBand;
  return (doubtful ? canonicalDistance(cutoff->tree, slotA, slotB) : distance) <= cutoff->distance;
}

/* Neighbours that are collected for a callback. */
enum { NEIGHBORS_AT_ONCE = 2 * PAIRS_AT_ONCE };

typedef struct Neighbors {
  const Sweep* sweep;
  double cutoff;
  ctPairFunction* function;
  void* context;
  bool continues;
  int lower[NEIGHBORS_AT_ONCE];
  int higher[NEIGHBORS_AT_ONCE];
} Neighbors;

static bool tellNeighbors(PairSink* sink) {
  Neighbors* neighbors = sink->context;
  double distances[NEIGHBORS_AT_ONCE];
  ctSweepDistances(neighbors->sweep, neighbors->cutoff, sink->count, sink->lower, sink->higher, distances);
  for (size_t i = 0; i < sink->count && neighbors->continues; i++) {
    neighbors->continues = neighbors->function(neighbors->context, sink->lower[i], sink->higher[i], distances[i]);
  }
  sink->count = 0;
  return neighbors->continues;
}

/* Puts all neighbours into a sink, which may hold some in the end. */
static ctStatus sweepNeighbors(ctChainTree* tree, double cutoff, PairSink* sink, ctCounts* counts) {
  if (!(cutoff > 0) || !isfinite(cutoff)) {
    return ctFail(tree, ctInvalidArgument, "the cutoff is %g nm; it must be finite and positive", cutoff);
  }
  Sweep* sweep = ctSceneSweep(tree);
  if (sweep == NULL) {
    return ctFailOutOfMemory(tree);
  }
  Cutoff exact = {tree, cutoff, sweep->snapshot.tieBand};
  ctSweepNeighbors(sweep, cutoff, sink, isNeighbor, &exact, counts);
  return ctSuccess;
}

ctStatus ctForEachNeighborPair(ctChainTree* tree, double cutoff, ctPairFunction* function, void* context,
                               ctCounts* counts) {
  CT_REQUIRE(tree, function);
  Neighbors neighbors;
  neighbors.sweep = &tree->ownSweep;
  neighbors.cutoff = cutoff;
  neighbors.function = function;
  neighbors.context = context;
  neighbors.continues = true;
  PairSink sink = {neighbors.lower, neighbors.higher, 0, NEIGHBORS_AT_ONCE, false, tellNeighbors, &neighbors};
  const ctStatus status = sweepNeighbors(tree, cutoff, &sink, counts);
  if (status == ctSuccess && neighbors.continues) {
    tellNeighbors(&sink);
  }
  return status;
}

/* The caller's arrays. PAIRS_AT_ONCE pairs are written at a time. When the caller's arrays have less room, the last
 * arrays take the pairs, and as many as fit are copied. */
typedef struct NeighborArrays {
  int* lower;
  int* higher;
  size_t capacity;
  size_t count; /* of pairs that have left the sink */
  int lastLower[NEIGHBORS_AT_ONCE];
  int lastHigher[NEIGHBORS_AT_ONCE];
} NeighborArrays;

static bool moveNeighbors(PairSink* sink) {
  NeighborArrays* arrays = sink->context;
  if (sink->lower == arrays->lastLower && arrays->count < arrays->capacity) {
    const size_t room = arrays->capacity - arrays->count;
    const size_t size = (sink->count < room ? sink->count : room) * sizeof(int);
    memcpy(arrays->lower + arrays->count, arrays->lastLower, size);
    memcpy(arrays->higher + arrays->count, arrays->lastHigher, size);
  }
  arrays->count += sink->count;
  sink->lower = arrays->lastLower;
  sink->higher = arrays->lastHigher;
  sink->count = 0;
  sink->capacity = NEIGHBORS_AT_ONCE;
  return true;
}

ctStatus ctGetNeighborPairs(ctChainTree* tree, double cutoff, bool sorted, size_t capacity, int* particles1,
                            int* particles2, double* distances, size_t* count, ctCounts* counts) {
  CT_REQUIRE(tree, count);
  if (capacity > 0) {
    CT_REQUIRE(tree, particles1);
    CT_REQUIRE(tree, particles2);
  }
  NeighborArrays arrays;
  arrays.lower = particles1;
  arrays.higher = particles2;
  arrays.capacity = capacity;
  arrays.count = 0;
  PairSink sink = {particles1, particles2, 0, capacity, sorted, moveNeighbors, &arrays};
  const ctStatus status = sweepNeighbors(tree, cutoff, &sink, counts);
  if (status != ctSuccess) {
    return status;
  }
  moveNeighbors(&sink);
  const bool fit = arrays.count <= capacity;
  if (sorted && fit && !ctSortPairs(arrays.count, particles1, particles2, tree->sequence.particleCount)) {
    return ctFailOutOfMemory(tree);
  }
  if (distances != NULL) {
    ctSweepDistances(&tree->ownSweep, cutoff, fit ? arrays.count : capacity, particles1, particles2, distances);
  }
  *count = arrays.count;
  return ctSuccess;
}
