#include "pairsums.h"

#include <stdlib.h>

#include "imageframe.h"
#include "trialview.h"

bool ctPairSumsCreate(PairSums* pairs, TrialLeaves* leaves, double cutoff, LeafPairFunction* function,
                      const void* model) {
  *pairs = (PairSums){.leaves = leaves, .function = function, .model = model, .cutoff = cutoff};
  return ctLeafSumsCreate(&pairs->sums, leaves->leafCount) && ctLeafSumsCreate(&pairs->savedSums, leaves->leafCount);
}

void ctPairSumsFree(PairSums* pairs) {
  ctLeafSumsFree(&pairs->sums);
  ctLeafSumsFree(&pairs->savedSums);
  free(pairs->staged);
  pairs->staged = NULL;
}

/* Pairs of leaves in one call of the function. */
enum { MOST_AT_A_TIME = 32 };

/* Pairs of leaves for one call of the function. */
typedef struct PairBatch {
  int count;
  FramedPair framed[MOST_AT_A_TIME];
  LeafKey keys[MOST_AT_A_TIME];
  LeafFrame shifted[MOST_AT_A_TIME]; /* of pairs with images */
} PairBatch;

static void addToPairBatch(PairBatch* batch, const TrialLeaves* leaves, const ctLeafPair* pair, const LeafFrame* frameA,
                           const LeafFrame* frameB) {
  const int i = batch->count++;
  const bool isImage = isShifted(pair->image);
  if (isImage) {
    shiftFrame(frameA, leaves->box, pair->image, &batch->shifted[i]);
  }
  batch->framed[i] = (FramedPair){pair->a, pair->b, isImage, {isImage ? &batch->shifted[i] : frameA, frameB}};
  batch->keys[i] = leafKeyOf(pair->b, pair->image);
}

ctStatus ctPairSumsRefresh(PairSums* pairs, size_t count, const ctLeafPair* near) {
  PairBatch batch;
  double sums[MOST_AT_A_TIME];
  pairs->stagedCount = 0;
  ctLeafSumsClear(&pairs->sums);
  for (size_t i = 0; i < count;) {
    batch.count = 0;
    for (; i < count && batch.count < MOST_AT_A_TIME; i++) {
      if (ctIsWithin(near[i].squaredGap, pairs->cutoff)) {
        const LeafFrame* frameA = ctStateFrame(pairs->leaves, near[i].a);
        addToPairBatch(&batch, pairs->leaves, &near[i], frameA, ctStateFrame(pairs->leaves, near[i].b));
      }
    }
    pairs->function(pairs->model, batch.count, batch.framed, sums);
    for (int k = 0; k < batch.count; k++) {
      if (!ctLeafSumsAdd(&pairs->sums, batch.framed[k].a, batch.keys[k], sums[k])) {
        return ctOutOfMemory;
      }
    }
  }
  return ctSuccess;
}

/* Stages the sums of these pairs, and adds by how much they change. Sums of the state are fetched while new ones are
 * computed. */
static void stageFew(PairSums* pairs, const PairBatch* batch, double* change) {
  double sums[MOST_AT_A_TIME];
  StagedSum* staged = pairs->staged + pairs->stagedCount;
  const FramedPair* framed = batch->framed;
  for (int i = 0; i < batch->count; i++) {
    const int place = ctLeafSumsFind(&pairs->sums, framed[i].a, framed[i].b, batch->keys[i]);
    staged[i] = (StagedSum){framed[i].a, place, batch->keys[i], 0};
    if (place != ABSENT) {
      __builtin_prefetch(&pairs->sums.rows[framed[i].a].sums[place]);
    }
  }
  pairs->function(pairs->model, batch->count, framed, sums);
  for (int i = 0; i < batch->count; i++) {
    staged[i].sum = sums[i];
    *change += changeOf(staged[i].place != ABSENT ? pairs->sums.rows[staged[i].a].sums[staged[i].place] : 0, sums[i]);
  }
  pairs->stagedCount += batch->count;
}

ctStatus ctPairSumsChange(PairSums* pairs, bool near, double* change) {
  TrialLeaves* leaves = pairs->leaves;
  PairBatch batch;
  const size_t most = (size_t)leaves->changedCount;
  *change = 0;
  batch.count = 0;
  pairs->stagedCount = near ? 0 : pairs->stagedCount;
  if (!ctReserveEntries((void**)&pairs->staged, &pairs->stagedCapacity, most, sizeof *pairs->staged)) {
    return ctOutOfMemory;
  }
  int count;
  const ctLeafPair* changed = ctChangedPairs(leaves, near, &count);
  for (int i = 0; i < count; i++) {
    const ctLeafPair* pair = &changed[i];
    if (ctIsWithin(pair->squaredGap, pairs->cutoff)) {
      __builtin_prefetch(pairs->sums.rows[pair->a].keys); /* to be searched soon */
      const LeafFrame* frameA = ctTrialFrame(leaves, pair->a);
      addToPairBatch(&batch, leaves, pair, frameA, ctTrialFrame(leaves, pair->b));
      if (batch.count == MOST_AT_A_TIME) {
        stageFew(pairs, &batch, change);
        batch.count = 0;
      }
    }
  }
  stageFew(pairs, &batch, change);
  return ctSuccess;
}

bool ctPairSumsAccept(PairSums* pairs) {
  bool isDone = true;
  /* Sums that exist come first: adding to a row moves them. */
  for (int i = 0; i < pairs->stagedCount; i++) {
    const StagedSum* staged = &pairs->staged[i];
    if (staged->place != ABSENT) {
      pairs->sums.rows[staged->a].sums[staged->place] = staged->sum;
    }
  }
  for (int i = 0; i < pairs->stagedCount; i++) {
    const StagedSum* staged = &pairs->staged[i];
    if (staged->place == ABSENT) {
      isDone = isDone && ctLeafSumsAdd(&pairs->sums, staged->a, staged->key, staged->sum);
    }
  }
  pairs->stagedCount = 0;
  return isDone;
}

bool ctPairSumsSave(PairSums* pairs) {
  return ctLeafSumsCopy(&pairs->sums, &pairs->savedSums);
}

void ctPairSumsRestore(PairSums* pairs) {
  pairs->stagedCount = 0;
  ctLeafSumsCopy(&pairs->savedSums, &pairs->sums);
}
