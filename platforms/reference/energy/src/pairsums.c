#include "pairsums.h"

#include <stdlib.h>

#include "trialview.h"

bool ctPairSumsCreate(PairSums* pairs, TrialLeaves* leaves, double cutoff, LeafPairFunction* function,
                      const void* model) {
  *pairs = (PairSums){.leaves = leaves, .function = function, .model = model, .cutoff = cutoff};
  return ctLeafSumsCreate(&pairs->sums, leaves->leafCount) && ctLeafSumsCreate(&pairs->keptSums, leaves->leafCount);
}

void ctPairSumsFree(PairSums* pairs) {
  ctLeafSumsFree(&pairs->sums);
  ctLeafSumsFree(&pairs->keptSums);
  free(pairs->staged);
  pairs->staged = NULL;
}

ctStatus ctPairSumsRefresh(PairSums* pairs, size_t count, const ctLeafPair* near) {
  pairs->stagedCount = 0;
  ctLeafSumsClear(&pairs->sums);
  for (size_t i = 0; i < count; i++) {
    const int a = near[i].a;
    const int b = near[i].b;
    if (ctIsWithin(near[i].squaredGap, pairs->cutoff)) {
      const LeafFrame* frameA = ctStateFrame(pairs->leaves, a);
      const double sum = pairs->function(pairs->model, a, frameA, b, ctStateFrame(pairs->leaves, b));
      if (!ctLeafSumsAdd(&pairs->sums, a, b, sum)) {
        return ctOutOfMemory;
      }
    }
  }
  return ctSuccess;
}

/* Computes the sums of those changed pairs that are near, or of the others, and by how much these change. */
static ctStatus stage(PairSums* pairs, bool near, double* change) {
  TrialLeaves* leaves = pairs->leaves;
  const size_t most = (size_t)leaves->changedCount;
  *change = 0;
  if (!ctReserveEntries((void**)&pairs->staged, &pairs->stagedCapacity, most, sizeof *pairs->staged)) {
    return ctOutOfMemory;
  }
  for (int i = 0; i < leaves->changedCount; i++) {
    const ChangedPair* pair = &leaves->changed[i];
    if (pair->isNear == near && ctIsWithin(pair->squaredGap, pairs->cutoff)) {
      const LeafFrame* a = ctTrialFrame(leaves, pair->a);
      const LeafFrame* b = ctTrialFrame(leaves, pair->b);
      const double sum = pairs->function(pairs->model, pair->a, a, pair->b, b);
      const int kept = ctLeafSumsFind(&pairs->sums, pair->a, pair->b);
      pairs->staged[pairs->stagedCount++] = (StagedSum){pair->a, pair->b, kept, sum};
      *change += changeOf(kept != ABSENT ? pairs->sums.rows[pair->a].sums[kept] : 0, sum);
    }
  }
  return ctSuccess;
}

ctStatus ctPairSumsNearChange(PairSums* pairs, double* change) {
  pairs->stagedCount = 0;
  return stage(pairs, true, change);
}

ctStatus ctPairSumsOtherChange(PairSums* pairs, double* change) {
  return stage(pairs, false, change);
}

bool ctPairSumsAccept(PairSums* pairs) {
  bool isKept = true;
  /* Those that are there first: adding to a row moves them. */
  for (int i = 0; i < pairs->stagedCount; i++) {
    const StagedSum* staged = &pairs->staged[i];
    if (staged->kept != ABSENT) {
      pairs->sums.rows[staged->a].sums[staged->kept] = staged->sum;
    }
  }
  for (int i = 0; i < pairs->stagedCount; i++) {
    const StagedSum* staged = &pairs->staged[i];
    if (staged->kept == ABSENT) {
      isKept = isKept && ctLeafSumsAdd(&pairs->sums, staged->a, staged->b, staged->sum);
    }
  }
  pairs->stagedCount = 0;
  return isKept;
}

bool ctPairSumsKeep(PairSums* pairs) {
  return ctLeafSumsCopy(&pairs->sums, &pairs->keptSums);
}

void ctPairSumsTakeBack(PairSums* pairs) {
  pairs->stagedCount = 0;
  ctLeafSumsCopy(&pairs->keptSums, &pairs->sums);
}
