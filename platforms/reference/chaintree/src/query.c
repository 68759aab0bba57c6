/* Queries of the state: clashes, neighbour pairs, probe, minimum distance, energy; and the limits taken from it. */
#include <stdlib.h>
#include <string.h>

#include "position.h"
#include "scene.h"

/* ---- Pairs that match ---- */

/* What a query wants to know of each clash or neighbour pair. */
typedef struct Match {
  ctChainTree* tree;
  double cutoff; /* of neighbour pairs */
  bool (*found)(struct Match* match, int slotA, int slotB, double value);
  void* context;
  ctPairFunction* function;
} Match;

/* value: the overlap. */
static bool matchClash(void* context, int slotA, int slotB, double squaredDistance) {
  Match* match = context;
  ctChainTree* tree = match->tree;
  const double sum = radiusSum(tree, slotA, slotB);
  const double tolerance = pairTolerance(tree, slotA, slotB);
  double overlap = sum - sqrt(squaredDistance);
  if (fabs(overlap - tolerance) <= tree->traversal.band) {
    overlap = sum - canonicalDistance(tree, slotA, slotB);
  }
  if (overlap <= tolerance) {
    return true;
  }
  return match->found(match, slotA, slotB, overlap);
}

/* value: the distance. */
static bool matchNeighbor(void* context, int slotA, int slotB, double squaredDistance) {
  Match* match = context;
  ctChainTree* tree = match->tree;
  double distance = sqrt(squaredDistance);
  if (fabs(distance - match->cutoff) <= tree->traversal.band) {
    distance = canonicalDistance(tree, slotA, slotB);
  }
  if (distance > match->cutoff) {
    return true;
  }
  return match->found(match, slotA, slotB, distance);
}

static void traverseClashes(Match* match, ctCounts* counts) {
  const View view = ctViewOfState(true, -match->tree->overlapTolerance);
  ctSceneTree(match->tree);
  ctTraverse(&match->tree->traversal, &view, matchClash, match, counts);
}

static bool tellCaller(Match* match, int slotA, int slotB, double value) {
  int pair[2];
  particlesOf(match->tree, slotA, slotB, pair);
  return match->function(match->context, pair[0], pair[1], value);
}

ctStatus ctForEachClash(ctChainTree* tree, ctPairFunction* function, void* context, ctCounts* counts) {
  Match match = {tree, 0, tellCaller, context, function};
  traverseClashes(&match, counts);
  return ctSuccess;
}

ctStatus ctForEachNeighborPair(ctChainTree* tree, double cutoff, ctPairFunction* function, void* context,
                               ctCounts* counts) {
  if (!(cutoff > 0) || !isfinite(cutoff)) {
    return ctFail(tree, ctInvalidArgument, "the cutoff is %g nm; it must be finite and positive", cutoff);
  }
  Match match = {tree, cutoff, tellCaller, context, function};
  const View view = ctViewOfState(false, cutoff);
  ctSceneTree(tree);
  ctTraverse(&tree->traversal, &view, matchNeighbor, &match, counts);
  return ctSuccess;
}

static bool keepFirst(Match* match, int slotA, int slotB, double value) {
  (void)value;
  particlesOf(match->tree, slotA, slotB, match->context);
  return false;
}

ctStatus ctHasClash(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts) {
  int first[2] = {CT_NULL, CT_NULL};
  Match match = {tree, 0, keepFirst, first, NULL};
  traverseClashes(&match, counts);
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

static bool addEnergy(Match* match, int slotA, int slotB, double overlap) {
  Energy* energy = match->context;
  ctChainTree* tree = match->tree;
  const double depth = overlap - pairTolerance(tree, slotA, slotB);
  energy->sum += 0.5 * energy->k * depth * depth;
  if (energy->forces == NULL) {
    return true;
  }
  const int particleA = tree->sequence.slotParticle[slotA];
  const int particleB = tree->sequence.slotParticle[slotB];
  double apart[3];
  double a[3];
  double b[3];
  ctTraversalPosition(&tree->traversal, slotA, a);
  ctTraversalPosition(&tree->traversal, slotB, b);
  subtract(a, b, apart);
  double distance = sqrt(dot(apart, apart));
  if (distance <= tree->traversal.band) {
    /* Coincident but for rounding: any direction would do, so it is a fixed one. */
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
  if (!isfinite(k)) {
    return ctFail(tree, ctInvalidArgument, "the force constant is %g; it must be finite", k);
  }
  Energy sum = {k, 0, forces};
  Match match = {tree, 0, addEnergy, &sum, NULL};
  traverseClashes(&match, counts);
  *energy = sum.sum;
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
  const double overlap = s->slotRadius[slot] + probe->radius - sqrt(squaredDistance);
  return overlap <= probe->tree->overlapTolerance || probe->function(probe->context, s->slotParticle[slot], overlap);
}

ctStatus ctForEachClashWith(ctChainTree* tree, const double position[3], double radius, ctParticleFunction* function,
                            void* context, ctCounts* counts) {
  if (!isfinite(position[0]) || !isfinite(position[1]) || !isfinite(position[2])) {
    return ctFail(tree, ctInvalidArgument, "the position of the probe is not finite");
  }
  if (!(radius >= 0) || !isfinite(radius)) {
    return ctFail(tree, ctInvalidArgument, "the radius of the probe is %g nm; it must be finite and not negative",
                  radius);
  }
  double point[3];
  subtract(position, tree->sequence.worldOrigin, point);
  Probe probe = {tree, radius, function, context};
  const View view = ctViewOfState(true, -tree->overlapTolerance);
  ctSceneTree(tree);
  ctTraverseProbe(&tree->traversal, &view, point, radius, matchProbe, &probe, counts);
  return ctSuccess;
}

/* ---- Minimum distance ---- */

static ctStatus checkParticles(ctChainTree* tree, int count, const int* particles) {
  for (int i = 0; i < count; i++) {
    if (particles[i] < 0 || particles[i] >= tree->sequence.particleCount) {
      return ctFail(tree, ctInvalidArgument, "there is no particle %d; there are %d particles", particles[i],
                    tree->sequence.particleCount);
    }
  }
  return ctSuccess;
}

ctStatus ctGetMinimumDistance(ctChainTree* tree, int count1, const int* particles1, int count2, const int* particles2,
                              double* distance, int pair[2]) {
  ctStatus status = checkParticles(tree, count1, particles1);
  status = status == ctSuccess ? checkParticles(tree, count2, particles2) : status;
  if (status != ctSuccess) {
    return status;
  }
  double* positions = malloc((size_t)(count2 > 0 ? count2 : 1) * sizeof(double[3]));
  if (positions == NULL) {
    return ctFailOutOfMemory(tree);
  }
  PositionReader reader = ctPositionReader(&tree->sequence, ctSceneTree(tree));
  for (int j = 0; j < count2; j++) {
    ctReadPosition(&reader, particles2[j], positions + 3 * (size_t)j);
  }
  double least = INFINITY;
  for (int i = 0; i < count1; i++) {
    double position[3];
    ctReadPosition(&reader, particles1[i], position);
    for (int j = 0; j < count2; j++) {
      const double squared = squaredDistance(position, positions + 3 * (size_t)j);
      if (squared < least && particles1[i] != particles2[j]) {
        least = squared;
        pair[0] = particles1[i];
        pair[1] = particles2[j];
      }
    }
  }
  free(positions);
  if (least == INFINITY) {
    return ctFail(tree, ctInvalidArgument, "the sets of %d and %d particles hold no pair of different particles",
                  count1, count2);
  }
  *distance = sqrt(least);
  return ctSuccess;
}

/* ---- Limits of single pairs ---- */

ctStatus ctSetLimits(ctChainTree* tree, int count, const int (*pairs)[2], const double* limits) {
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
    const int slotA = s->particleSlot[a];
    const int slotB = s->particleSlot[b];
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
  ctClearanceForget(&tree->clearance);
  return ctSuccess;
}

typedef struct Raise {
  Limits raised;
  bool failed;
} Raise;

static bool raiseLimit(Match* match, int slotA, int slotB, double overlap) {
  (void)overlap; /* a limit is of the canonical distance, like the trials that it judges */
  Raise* raise = match->context;
  const double canonical = radiusSum(match->tree, slotA, slotB) - canonicalDistance(match->tree, slotA, slotB);
  int pair[2];
  particlesOf(match->tree, slotA, slotB, pair);
  if (canonical > ctLimitsFind(&match->tree->limits, pair[0], pair[1], 0)) {
    raise->failed = !ctLimitsAppend(&raise->raised, pair[0], pair[1], canonical + CT_SIGMA);
  }
  return !raise->failed;
}

ctStatus ctRaiseLimits(ctChainTree* tree, int* raised, ctCounts* counts) {
  Raise raise = {0};
  Match match = {tree, 0, raiseLimit, &raise, NULL};
  traverseClashes(&match, counts);
  const int count = raise.raised.count;
  /* The old ones join the new; of a pair's two the larger stays. */
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
  *raised = count;
  return ctSuccess;
}

int ctGetLimitCount(const ctChainTree* tree) {
  return tree->limits.count;
}

void ctGetLimits(const ctChainTree* tree, int capacity, int (*pairs)[2], double* limits) {
  for (int i = 0; i < capacity && i < tree->limits.count; i++) {
    pairs[i][0] = (int)(tree->limits.keys[i] >> 32);
    pairs[i][1] = (int)(tree->limits.keys[i] & 0xffffffffu);
    limits[i] = tree->limits.values[i];
  }
}
