/* Pairs whose distance a trial changes. */
#include <stdlib.h>

#include "scene.h"

typedef struct Collection {
  ctChainTree* tree;
  bool failed;
} Collection;

static bool collect(void* context, int slotA, int slotB, double squaredDistance) {
  (void)squaredDistance;
  Collection* collection = context;
  ctChainTree* tree = collection->tree;
  collection->failed = !ctSlotPairsAdd(&tree->ties, slotA < slotB ? slotA : slotB, slotA < slotB ? slotB : slotA, 0);
  return !collection->failed;
}

static int compareSlotPairs(const void* a, const void* b) {
  const SlotPair* x = a;
  const SlotPair* y = b;
  const int first = (x->slotA > y->slotA) - (x->slotA < y->slotA);
  return first != 0 ? first : (x->slotB > y->slotB) - (x->slotB < y->slotB);
}

static void dropRepeats(SlotPairs* list) {
  if (list->count == 0) {
    return;
  }
  qsort(list->pairs, (size_t)list->count, sizeof(SlotPair), compareSlotPairs);
  int kept = 1;
  for (int i = 1; i < list->count; i++) {
    if (compareSlotPairs(&list->pairs[kept - 1], &list->pairs[i]) != 0) {
      list->pairs[kept++] = list->pairs[i];
    }
  }
  list->count = kept;
}

ctStatus ctForEachChangedPair(ctChainTree* tree, double cutoff, ctChangedPairFunction* function, void* context,
                              ctCounts* counts) {
  CT_REQUIRE(tree, function);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (!(cutoff > 0) || !isfinite(cutoff)) {
    return ctFail(tree, ctInvalidArgument, "the cutoff is %g nm; it must be finite and positive", cutoff);
  }
  /* Collects candidates before and in the trial, then computes both canonical distances of each. */
  Collection collection = {tree, false};
  ctSceneTree(tree);
  tree->ties.count = 0;
  for (int moved = 0; moved < 2 && !collection.failed; moved++) {
    const View view = ctTrialView(tree->trial, moved == 1, false, cutoff);
    int few[2];
    if (!tree->isTesterOff[FEW_MOVERS] && ctViewMovesFew(&tree->traversal, &view, &few[0], &few[1])) {
      ctTraverseFew(&tree->traversal, &view, few[0], few[1], collect, NULL, &collection, counts);
    } else {
      ctTraverse(&tree->traversal, &view, collect, &collection, counts);
    }
  }
  if (collection.failed) {
    return ctFailOutOfMemory(tree);
  }
  SlotPairs* pairs = &tree->ties;
  dropRepeats(pairs);
  for (int i = 0; i < pairs->count; i++) {
    pairs->pairs[i].value = canonicalDistance(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB);
  }
  const bool areLeavesKept = ctSceneEnterTrial(tree);
  bool continues = true;
  for (int i = 0; i < pairs->count && continues; i++) {
    const double before = pairs->pairs[i].value;
    const double after = canonicalDistance(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB);
    if (before <= cutoff || after <= cutoff) {
      int pair[2];
      particlesOf(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB, pair);
      continues = function(context, pair[0], pair[1], before, after);
    }
  }
  ctSceneLeaveTrial(tree, areLeavesKept);
  return ctSuccess;
}
