#include "clashes.h"

#include <string.h>

static bool testCandidate(void* context, int slotA, int slotB, double squaredDistance) {
  Clashes* clashes = context;
  ctChainTree* tree = clashes->tree;
  const double sum = radiusSum(tree, slotA, slotB);
  const double tolerance = pairTolerance(tree, slotA, slotB);
  double overlap = sum - sqrt(squaredDistance);
  const Traversal* traversal = &tree->traversal;
  const double tieBand = traversal->image != NULL ? traversal->tieBand : clashes->sweep->snapshot.tieBand;
  if (fabs(overlap - tolerance) <= tieBand) {
    overlap = sum - canonicalDistance(tree, slotA, slotB);
  }
  clashes->isOver = overlap > tolerance && !clashes->found(clashes, slotA, slotB, overlap);
  return !clashes->isOver;
}

bool ctFindClashes(Clashes* clashes, ctCounts* counts) {
  clashes->sweep = ctSceneSweep(clashes->tree);
  if (clashes->sweep == NULL) {
    return false;
  }
  const double tolerance = clashes->tree->overlapTolerance;
  ctSweepClashes(&clashes->tree->ownSweep, tolerance, testCandidate, clashes, counts);
  if (!clashes->isOver) {
    ctSceneSearchImages(clashes->tree, -tolerance, testCandidate, clashes, counts);
  }
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
  return ctFindClashes(&clashes, counts) ? ctSuccess : ctFailOutOfMemory(tree);
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
  if (!ctFindClashes(&clashes, counts)) {
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
  const Image* image = tree->traversal.image;
  for (int d = 0; d < 3 && image != NULL; d++) {
    apart[d] += image->shift[d];
  }
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
  if (!ctFindClashes(&clashes, counts)) {
    return ctFailOutOfMemory(tree);
  }
  *energy = sum.sum;
  return ctSuccess;
}
