/* Limits of single pairs. */
#include <string.h>

#include "clashes.h"
#include "merged.h"

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
  raise.failed = !ctFindClashes(&clashes, counts) || raise.failed;
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
  int pair[2]; /* that has it */
} Excess;

static bool measureExcess(Clashes* clashes, int slotA, int slotB, double overlap) {
  (void)overlap; /* as in raiseLimit */
  Excess* excess = clashes->context;
  ctChainTree* tree = clashes->tree;
  const double canonical = radiusSum(tree, slotA, slotB) - canonicalDistance(tree, slotA, slotB);
  int pair[2];
  particlesOf(tree, slotA, slotB, pair);
  const double limit = ctLimitsFind(&tree->limits, pair[0], pair[1], pairTolerance(tree, slotA, slotB));
  if (canonical - limit > excess->found) {
    excess->found = canonical - limit;
    memcpy(excess->pair, pair, sizeof pair);
  }
  return excess->found <= excess->most;
}

double ctSceneExcess(ctChainTree* scene, double most, ctCounts* counts) {
  Excess excess = {most, 0, {CT_NULL, CT_NULL}};
  Clashes clashes = {.tree = scene, .found = measureExcess, .context = &excess};
  const bool isKnown = ctFindClashes(&clashes, counts) && excess.found <= most;
  return isKnown ? excess.found : INFINITY;
}

ctStatus ctTestState(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts) {
  CT_REQUIRE(tree, clash);
  Excess excess = {0, 0, {CT_NULL, CT_NULL}};
  Clashes clashes = {.tree = tree, .found = measureExcess, .context = &excess};
  if (!ctFindClashes(&clashes, counts)) {
    return ctFailOutOfMemory(tree);
  }
  *clash = excess.found > 0;
  if (*clash && pair != NULL) {
    memcpy(pair, excess.pair, sizeof excess.pair);
  }
  return ctSuccess;
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
