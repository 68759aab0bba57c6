/* Queries of the state: clashes, neighbour pairs, probe, energy; and the limits taken from it. */
#include <stdlib.h>
#include <string.h>

#include "definition.h"
#include "scene.h"

/* ---- Clashes ---- */

/* A query, and what it does with each clash. */
typedef struct Clashes {
  ctChainTree* tree;
  const Sweep* sweep;
  bool (*found)(struct Clashes* clashes, int slotA, int slotB, double overlap);
  void* context;
} Clashes;

static bool testCandidate(void* context, int slotA, int slotB, double squaredDistance) {
  Clashes* clashes = context;
  ctChainTree* tree = clashes->tree;
  const double sum = radiusSum(tree, slotA, slotB);
  const double tolerance = pairTolerance(tree, slotA, slotB);
  double overlap = sum - sqrt(squaredDistance);
  if (fabs(overlap - tolerance) <= clashes->sweep->snapshot.tieBand) {
    overlap = sum - canonicalDistance(tree, slotA, slotB);
  }
  return overlap <= tolerance || clashes->found(clashes, slotA, slotB, overlap);
}

/* False if there is no memory. */
static bool sweepClashes(Clashes* clashes, ctCounts* counts) {
  clashes->sweep = ctSceneSweep(clashes->tree);
  if (clashes->sweep == NULL) {
    return false;
  }
  ctSweepClashes(&clashes->tree->ownSweep, clashes->tree->overlapTolerance, testCandidate, clashes, counts);
  return true;
}

typedef struct Caller {
  ctPairFunction* function;
  void* context;
} Caller;

static bool tellCaller(Clashes* clashes, int slotA, int slotB, double overlap) {
  const Caller* caller = clashes->context;
  int pair[2];
  particlesOf(clashes->tree, slotA, slotB, pair);
  return caller->function(caller->context, pair[0], pair[1], overlap);
}

ctStatus ctForEachClash(ctChainTree* tree, ctPairFunction* function, void* context, ctCounts* counts) {
  CT_REQUIRE(tree, function);
  Caller caller = {function, context};
  Clashes clashes = {.tree = tree, .found = tellCaller, .context = &caller};
  return sweepClashes(&clashes, counts) ? ctSuccess : ctFailOutOfMemory(tree);
}

static bool keepFirst(Clashes* clashes, int slotA, int slotB, double overlap) {
  (void)overlap;
  particlesOf(clashes->tree, slotA, slotB, clashes->context);
  return false;
}

ctStatus ctHasClash(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts) {
  CT_REQUIRE(tree, clash);
  int first[2] = {CT_NULL, CT_NULL};
  Clashes clashes = {.tree = tree, .found = keepFirst, .context = first};
  if (!sweepClashes(&clashes, counts)) {
    return ctFailOutOfMemory(tree);
  }
  *clash = first[0] != CT_NULL;
  if (*clash && pair != NULL) {
    memcpy(pair, first, sizeof first);
  }
  return ctSuccess;
}

/* ---- Energy ---- */

typedef struct Energy {
  double k;
  double sum;
  double* forces;
} Energy;

static bool addEnergy(Clashes* clashes, int slotA, int slotB, double overlap) {
  Energy* energy = clashes->context;
  const ctChainTree* tree = clashes->tree;
  const double depth = overlap - pairTolerance(tree, slotA, slotB);
  energy->sum += 0.5 * energy->k * depth * depth;
  if (energy->forces == NULL) {
    return true;
  }
  const int particleA = tree->sequence.slotParticle[slotA];
  const int particleB = tree->sequence.slotParticle[slotB];
  const Snapshot* snapshot = &clashes->sweep->snapshot;
  double apart[3];
  subtract(snapshotPosition(snapshot, particleA), snapshotPosition(snapshot, particleB), apart);
  double distance = sqrt(dot(apart, apart));
  if (distance <= snapshot->tieBand) {
    /* Coincident but for rounding: the direction is a fixed one. */
    apart[0] = particleA < particleB ? 1 : -1;
    apart[1] = 0;
    apart[2] = 0;
    distance = 1;
  }
  for (size_t d = 0; d < 3; d++) {
    const double force = energy->k * depth * apart[d] / distance;
    energy->forces[3 * (size_t)particleA + d] += force;
    energy->forces[3 * (size_t)particleB + d] -= force;
  }
  return true;
}

ctStatus ctComputeEnergy(ctChainTree* tree, double k, double* energy, double* forces, ctCounts* counts) {
  CT_REQUIRE(tree, energy);
  if (!isfinite(k)) {
    return ctFail(tree, ctInvalidArgument, "the force constant is %g; it must be finite", k);
  }
  Energy sum = {k, 0, forces};
  Clashes clashes = {.tree = tree, .found = addEnergy, .context = &sum};
  if (!sweepClashes(&clashes, counts)) {
    return ctFailOutOfMemory(tree);
  }
  *energy = sum.sum;
  return ctSuccess;
}

/* ---- Neighbours ---- */

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
  Caller caller;
  bool continues;
  int lower[NEIGHBORS_AT_ONCE];
  int higher[NEIGHBORS_AT_ONCE];
} Neighbors;

static bool tellNeighbors(PairSink* sink) {
  Neighbors* neighbors = sink->context;
  double distances[NEIGHBORS_AT_ONCE];
  ctSweepDistances(neighbors->sweep, neighbors->cutoff, sink->count, sink->lower, sink->higher, distances);
  for (size_t i = 0; i < sink->count && neighbors->continues; i++) {
    neighbors->continues =
        neighbors->caller.function(neighbors->caller.context, sink->lower[i], sink->higher[i], distances[i]);
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
  neighbors.caller = (Caller){function, context};
  neighbors.continues = true;
  PairSink sink = {neighbors.lower, neighbors.higher, 0, NEIGHBORS_AT_ONCE, false, tellNeighbors, &neighbors};
  const ctStatus status = sweepNeighbors(tree, cutoff, &sink, counts);
  if (status == ctSuccess && neighbors.continues) {
    tellNeighbors(&sink);
  }
  return status;
}

/* The caller's arrays. PAIRS_AT_ONCE pairs are written at a time: when the caller's arrays have no room for this many,
 * the last arrays take them, and what fits is copied. */
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

/* ---- Probe ---- */

typedef struct Probe {
  ctChainTree* tree;
  double radius;
  ctParticleFunction* function;
  void* context;
} Probe;

static bool matchProbe(void* context, int slot, double squaredDistance) {
  const Probe* probe = context;
  const Sequence* s = &probe->tree->sequence;
  const double overlap = slotRadius(s, slot) + probe->radius - sqrt(squaredDistance);
  return overlap <= probe->tree->overlapTolerance || probe->function(probe->context, s->slotParticle[slot], overlap);
}

ctStatus ctForEachClashWith(ctChainTree* tree, const double position[3], double radius, ctParticleFunction* function,
                            void* context, ctCounts* counts) {
  CT_REQUIRE(tree, position);
  if (!areLengths(position)) {
    return ctFail(tree, ctInvalidArgument, "the position of the probe " CT_NO_LENGTH);
  }
  if (!(radius >= 0) || !isLength(radius)) {
    return ctFail(tree, ctInvalidArgument, "the radius of the probe is %g nm; it must be from 0 to 1e15 nm", radius);
  }
  CT_REQUIRE(tree, function);
  double point[3];
  subtract(position, tree->sequence.worldOrigin, point);
  Probe probe = {tree, radius, function, context};
  const View view = ctViewOfState(true, -tree->overlapTolerance);
  ctSceneTree(tree);
  ctTraverseProbe(&tree->traversal, &view, point, radius, matchProbe, &probe, counts);
  return ctSuccess;
}

/* ---- Limits of single pairs ---- */

ctStatus ctSetLimits(ctChainTree* tree, int count, const int (*pairs)[2], const double* limits) {
  CT_REQUIRE(tree, tree);
  if (count < 0 || count > CT_MOST_COUNT) {
    return ctFail(tree, ctInvalidArgument, "there cannot be %d limits", count);
  }
  if (count > 0) {
    CT_REQUIRE(tree, pairs);
    CT_REQUIRE(tree, limits);
  }
  const Sequence* s = &tree->sequence;
  Limits fresh = {0};
  bool hasMemory = true;
  for (int i = 0; i < count && hasMemory; i++) {
    const int a = pairs[i][0];
    const int b = pairs[i][1];
    if (a < 0 || a >= s->particleCount || b < 0 || b >= s->particleCount || a == b || isnan(limits[i])) {
      ctLimitsFree(&fresh);
      return ctFail(tree, ctInvalidArgument, "limit %d is %g nm for particles %d and %d; there are %d particles", i,
                    limits[i], a, b, s->particleCount);
    }
    const int slotA = modelledSlot(s, a);
    const int slotB = modelledSlot(s, b);
    if (slotA != CT_NULL && slotB != CT_NULL && limits[i] > pairTolerance(tree, slotA, slotB)) {
      hasMemory = ctLimitsAppend(&fresh, a, b, limits[i]);
    }
  }
  if (!hasMemory || !ctLimitsSort(&fresh)) {
    ctLimitsFree(&fresh);
    return ctFailOutOfMemory(tree);
  }
  ctLimitsFree(&tree->limits);
  tree->limits = fresh;
  ctTestersForget(tree);
  ctMergedForget(tree);
  return ctSuccess;
}

typedef struct Raise {
  Limits raised;
  bool failed;
} Raise;

static bool raiseLimit(Clashes* clashes, int slotA, int slotB, double overlap) {
  (void)overlap; /* limits are of canonical distances, like verdicts */
  Raise* raise = clashes->context;
  ctChainTree* tree = clashes->tree;
  const double canonical = radiusSum(tree, slotA, slotB) - canonicalDistance(tree, slotA, slotB);
  int pair[2];
  particlesOf(tree, slotA, slotB, pair);
  if (canonical > ctLimitsFind(&tree->limits, pair[0], pair[1], 0)) {
    raise->failed = !ctLimitsAppend(&raise->raised, pair[0], pair[1], canonical + CT_SIGMA);
  }
  return !raise->failed;
}

ctStatus ctRaiseLimits(ctChainTree* tree, int* raised, ctCounts* counts) {
  CT_REQUIRE(tree, raised);
  Raise raise = {0};
  Clashes clashes = {.tree = tree, .found = raiseLimit, .context = &raise};
  raise.failed = !sweepClashes(&clashes, counts) || raise.failed;
  const int count = raise.raised.count;
  /* Adds the old limits; of two of one pair the larger stays. */
  for (int i = 0; i < tree->limits.count && !raise.failed; i++) {
    const uint64_t key = tree->limits.keys[i];
    raise.failed = !ctLimitsAppend(&raise.raised, (int)(key >> 32), (int)(key & 0xffffffffu), tree->limits.values[i]);
  }
  if (raise.failed || !ctLimitsSort(&raise.raised)) {
    ctLimitsFree(&raise.raised);
    return ctFailOutOfMemory(tree);
  }
  ctLimitsFree(&tree->limits);
  tree->limits = raise.raised;
  ctMergedForget(tree);
  *raised = count;
  return ctSuccess;
}

typedef struct Excess {
  double most; /* the search ends beyond this */
  double found;
} Excess;

static bool measureExcess(Clashes* clashes, int slotA, int slotB, double overlap) {
  (void)overlap; /* as in raiseLimit */
  Excess* excess = clashes->context;
  ctChainTree* tree = clashes->tree;
  const double canonical = radiusSum(tree, slotA, slotB) - canonicalDistance(tree, slotA, slotB);
  int pair[2];
  particlesOf(tree, slotA, slotB, pair);
  const double limit = ctLimitsFind(&tree->limits, pair[0], pair[1], pairTolerance(tree, slotA, slotB));
  excess->found = larger(excess->found, canonical - limit);
  return excess->found <= excess->most;
}

double ctSceneExcess(ctChainTree* scene, double most, ctCounts* counts) {
  Excess excess = {most, 0};
  Clashes clashes = {.tree = scene, .found = measureExcess, .context = &excess};
  const bool isKnown = sweepClashes(&clashes, counts) && excess.found <= most;
  return isKnown ? excess.found : INFINITY;
}

int ctGetLimitCount(const ctChainTree* tree) {
  return tree != NULL ? tree->limits.count : 0;
}

void ctGetLimits(const ctChainTree* tree, int capacity, int (*pairs)[2], double* limits) {
  if (tree == NULL || pairs == NULL || limits == NULL) {
    return;
  }
  for (int i = 0; i < capacity && i < tree->limits.count; i++) {
    pairs[i][0] = (int)(tree->limits.keys[i] >> 32);
    pairs[i][1] = (int)(tree->limits.keys[i] & 0xffffffffu);
    limits[i] = tree->limits.values[i];
  }
}
