/* Pairs of particles within a cutoff. */
#include <string.h>

#include "scene.h"

typedef struct Cutoff {
  ctChainTree* tree;
  double distance;
  double tieBand;
  PairSink* sink; /* for pairs in images */
} Cutoff;

/* False for one of two images at the same distance, half the box's width, so that each pair is listed once. */
static bool isNearestImage(ctChainTree* tree, int slotA, int slotB) {
  if (!tree->sequence.box.isPeriodic) {
    return true;
  }
  const int* particle = tree->sequence.slotParticle;
  const Image* image = tree->traversal.image;
  const bool isAFirst = particle[slotA] < particle[slotB];
  const Image nearest = ctSceneNearestImage(tree, isAFirst ? slotA : slotB, isAFirst ? slotB : slotA);
  for (int k = 0; k < 3; k++) {
    if (nearest.n[k] != (image == NULL ? 0 : isAFirst ? image->n[k] : -image->n[k])) {
      return false;
    }
  }
  return true;
}

static bool isNeighbor(void* context, int slotA, int slotB, double squaredDistance) {
  const Cutoff* cutoff = context;
  const double distance = sqrt(squaredDistance);
  const bool doubtful = fabs(distance - cutoff->distance) <= cutoff->tieBand;
  return (doubtful ? canonicalDistance(cutoff->tree, slotA, slotB) : distance) <= cutoff->distance &&
         (!doubtful || isNearestImage(cutoff->tree, slotA, slotB));
}

/* Neighbours that are collected for a callback. */
enum { NEIGHBORS_AT_ONCE = 2 * PAIRS_AT_ONCE };

typedef struct Neighbors {
  const ctChainTree* tree;
  double cutoff;
  ctPairFunction* function;
  void* context;
  bool continues;
  int lower[NEIGHBORS_AT_ONCE];
  int higher[NEIGHBORS_AT_ONCE];
} Neighbors;

/* The distances of neighbours in their nearest images, none above the cutoff. */
static void computeDistances(const ctChainTree* tree, double cutoff, size_t count, const int* lower, const int* higher,
                             double* distances) {
  if (!tree->sequence.box.isPeriodic) {
    ctSweepDistances(&tree->ownSweep, cutoff, count, lower, higher, distances);
    return;
  }
  const Snapshot* snapshot = &tree->ownSweep.snapshot;
  for (size_t i = 0; i < count; i++) {
    const double* x = snapshotPosition(snapshot, lower[i]);
    const double* y = snapshotPosition(snapshot, higher[i]);
    double apart[3];
    subtract(x, y, apart);
    const Image image = ctNearestImage(&tree->sequence.box, apart);
    distances[i] = lesser(sqrt(squaredImageDistance(x, y, &image)), cutoff);
  }
}

static bool tellNeighbors(PairSink* sink) {
  Neighbors* neighbors = sink->context;
  double distances[NEIGHBORS_AT_ONCE];
  computeDistances(neighbors->tree, neighbors->cutoff, sink->count, sink->lower, sink->higher, distances);
  for (size_t i = 0; i < sink->count && neighbors->continues; i++) {
    neighbors->continues = neighbors->function(neighbors->context, sink->lower[i], sink->higher[i], distances[i]);
  }
  sink->count = 0;
  sink->isClosed = !neighbors->continues;
  return neighbors->continues;
}

/* Puts a pair that is near in an image into the sink. */
static bool addImage(void* context, int slotA, int slotB, double squaredDistance) {
  Cutoff* cutoff = context;
  PairSink* sink = cutoff->sink;
  if (!isNeighbor(cutoff, slotA, slotB, squaredDistance)) {
    return true;
  }
  if (sink->capacity - sink->count < PAIRS_AT_ONCE && !sink->makeRoom(sink)) {
    return false;
  }
  int pair[2];
  particlesOf(cutoff->tree, slotA, slotB, pair);
  sink->lower[sink->count] = pair[0];
  sink->higher[sink->count++] = pair[1];
  return true;
}

/* Puts all neighbours into a sink, which may hold some in the end. */
static ctStatus sweepNeighbors(ctChainTree* tree, double cutoff, PairSink* sink, ctCounts* counts) {
  const ctStatus status = ctCheckCutoff(tree, cutoff);
  if (status != ctSuccess) {
    return status;
  }
  Sweep* sweep = ctSceneSweep(tree);
  if (sweep == NULL) {
    return ctFailOutOfMemory(tree);
  }
  Cutoff exact = {tree, cutoff, sweep->snapshot.tieBand, sink};
  ctSweepNeighbors(sweep, cutoff, sink, isNeighbor, &exact, counts);
  if (!sink->isClosed) {
    ctSceneSearchImages(tree, cutoff, addImage, &exact, counts);
  }
  return ctSuccess;
}

ctStatus ctForEachNeighborPair(ctChainTree* tree, double cutoff, ctPairFunction* function, void* context,
                               ctCounts* counts) {
  CT_REQUIRE(tree, function);
  Neighbors neighbors;
  neighbors.tree = tree;
  neighbors.cutoff = cutoff;
  neighbors.function = function;
  neighbors.context = context;
  neighbors.continues = true;
  PairSink sink = {neighbors.lower, neighbors.higher, 0, NEIGHBORS_AT_ONCE, false, tellNeighbors, &neighbors, false};
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
  PairSink sink = {particles1, particles2, 0, capacity, sorted, moveNeighbors, &arrays, false};
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
    computeDistances(tree, cutoff, fit ? arrays.count : capacity, particles1, particles2, distances);
  }
  *count = arrays.count;
  return ctSuccess;
}
