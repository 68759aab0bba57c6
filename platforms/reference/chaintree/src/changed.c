/* Pairs whose distance a trial changes. */
#include "scene.h"
#include "wide.h"

ctStatus ctForEachChangedPair(ctChainTree* tree, double cutoff, ctChangedPairFunction* function, void* context,
                              ctCounts* counts) {
  CT_REQUIRE(tree, function);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (!(cutoff > 0) || !isfinite(cutoff)) {
    return ctFail(tree, ctInvalidArgument, "the cutoff is %g nm; it must be finite and positive", cutoff);
  }
  /* Collects candidates, then computes both canonical distances of each. */
  LeafTask task;
  const ctStatus status = ctLeavesBegin(tree, true, cutoff, &task);
  if (status != ctSuccess) {
    return status;
  }
  SlotPairs* pairs = &tree->ties;
  task.slotPairs = pairs;
  pairs->count = 0;
  tree->ownTree.wide->listChangedSlots(&task);
  if (task.failed) {
    return ctFailOutOfMemory(tree);
  }
  addTests(counts, task.tests, task.particleTests);
  if (pairs->count == 0) {
    return ctSuccess;
  }
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
