/* Pairs whose distance a trial changes. In a periodic box the distance is that of the nearest images. */
#include <stdlib.h>

#include "scene.h"
#include "wide.h"

/* ---- Images ---- */

typedef struct Collection {
  SlotPairs* pairs;
  bool failed;
} Collection;

static bool collect(void* context, int slotA, int slotB, double squaredDistance) {
  (void)squaredDistance;
  Collection* collection = context;
  const SlotPair pair = {.slotA = slotA, .slotB = slotB};
  collection->failed = !ctSlotPairsAdd(collection->pairs, &pair);
  return !collection->failed;
}

static int compareSlotPairs(const void* a, const void* b) {
  const SlotPair* x = a;
  const SlotPair* y = b;
  const int first = (x->slotA > y->slotA) - (x->slotA < y->slotA);
  return first != 0 ? first : (x->slotB > y->slotB) - (x->slotB < y->slotB);
}

/* Adds the pairs that are near in images, before the trial or in it. False if there is no memory. */
static bool addImages(ctChainTree* tree, double cutoff, ctCounts* counts) {
  Traversal* traversal = &tree->traversal;
  SlotPairs* pairs = &tree->ties;
  Collection collection = {pairs, false};
  ctSceneTree(tree);
  for (int moved = 0; moved < 2 && !collection.failed; moved++) {
    View view = ctTrialView(tree->trial, cutoff); /* more than enough: from surface to surface */
    view.motions = moved == 1 ? view.motions : NULL;
    ctTraverseImages(traversal, &view, &tree->sequence.box, false, collect, &collection, counts);
  }
  for (int i = 0; i < pairs->count; i++) {
    const SlotPair pair = pairs->pairs[i];
    pairs->pairs[i].slotA = pair.slotA < pair.slotB ? pair.slotA : pair.slotB;
    pairs->pairs[i].slotB = pair.slotA < pair.slotB ? pair.slotB : pair.slotA;
  }
  if (pairs->count > 0) {
    qsort(pairs->pairs, (size_t)pairs->count, sizeof(SlotPair), compareSlotPairs);
    int kept = 1;
    for (int i = 1; i < pairs->count; i++) {
      if (compareSlotPairs(&pairs->pairs[kept - 1], &pairs->pairs[i]) != 0) {
        pairs->pairs[kept++] = pairs->pairs[i];
      }
    }
    pairs->count = kept;
  }
  return !collection.failed;
}

/* The canonical distance of the nearest images. */
static double nearestDistance(ctChainTree* tree, int slotA, int slotB) {
  if (!tree->sequence.box.isPeriodic) {
    return canonicalDistance(tree, slotA, slotB);
  }
  const Image image = ctSceneNearestImage(tree, slotA, slotB);
  tree->traversal.image = isImage(&image) ? &image : NULL;
  const double distance = canonicalDistance(tree, slotA, slotB);
  tree->traversal.image = NULL;
  return distance;
}

/* ---- The query ---- */

ctStatus ctForEachChangedPair(ctChainTree* tree, double cutoff, ctChangedPairFunction* function, void* context,
                              ctCounts* counts) {
  CT_REQUIRE(tree, function);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  ctStatus status = ctCheckCutoff(tree, cutoff);
  if (status != ctSuccess) {
    return status;
  }
  /* Collects candidates, then computes both canonical distances of each. */
  LeafTask task;
  status = ctLeavesBegin(tree, true, cutoff, &task);
  if (status != ctSuccess) {
    return status;
  }
  SlotPairs* pairs = &tree->ties;
  task.slotPairs = pairs;
  pairs->count = 0;
  tree->ownTree.wide->listChangedSlots(&task);
  if (task.failed || (tree->sequence.box.isPeriodic && !addImages(tree, cutoff, counts))) {
    return ctFailOutOfMemory(tree);
  }
  addTests(counts, task.tests, task.particleTests);
  if (pairs->count == 0) {
    return ctSuccess;
  }
  for (int i = 0; i < pairs->count; i++) {
    pairs->pairs[i].value = nearestDistance(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB);
  }
  const bool areLeavesKept = ctSceneEnterTrial(tree);
  bool continues = true;
  for (int i = 0; i < pairs->count && continues; i++) {
    const double before = pairs->pairs[i].value;
    const double after = nearestDistance(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB);
    if (before <= cutoff || after <= cutoff) {
      int pair[2];
      particlesOf(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB, pair);
      continues = function(context, pair[0], pair[1], before, after);
    }
  }
  ctSceneLeaveTrial(tree, areLeavesKept);
  return ctSuccess;
}
