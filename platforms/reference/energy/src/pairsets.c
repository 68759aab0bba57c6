#include "pairsets.h"

#include <stdio.h>
#include <stdlib.h>

static ctStatus addSet(PairSets* sets, TrialLeaves* leaves, int particleCount, const ctPairSet* description,
                       const int* slotOf, char* errorText, size_t errorSize) {
  const int i = sets->count;
  PairSet* set = &sets->sets[i];
  const ctStatus status =
      ctPairSetCreate(set, leaves->tree, particleCount, description, i, slotOf, errorText, errorSize);
  if (status != ctSuccess) {
    return status;
  }
  if (!ctPairSumsCreate(&sets->sums[i], leaves, set->cutoff, ctPairSetEnergies, set)) {
    ctPairSumsFree(&sets->sums[i]);
    ctPairSetFree(set);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  sets->count++;
  return ctSuccess;
}

ctStatus ctPairSetsCreate(PairSets* sets, TrialLeaves* leaves, int particleCount, int count,
                          const ctPairSet* descriptions, const int* slotOf, char* errorText, size_t errorSize) {
  *sets = (PairSets){0};
  sets->sets = calloc((size_t)count + 1, sizeof *sets->sets);
  sets->sums = calloc((size_t)count + 1, sizeof *sets->sums);
  ctStatus status = ctSuccess;
  if (sets->sets == NULL || sets->sums == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    status = ctOutOfMemory;
  }
  for (int i = 0; i < count && status == ctSuccess; i++) {
    status = addSet(sets, leaves, particleCount, &descriptions[i], slotOf, errorText, errorSize);
  }
  if (status != ctSuccess) {
    ctPairSetsFree(sets);
  }
  return status;
}

void ctPairSetsFree(PairSets* sets) {
  for (int i = 0; i < sets->count; i++) {
    ctPairSumsFree(&sets->sums[i]);
    ctPairSetFree(&sets->sets[i]);
  }
  free(sets->sets);
  free(sets->sums);
  *sets = (PairSets){0};
}

ctStatus ctPairSetsRefresh(PairSets* sets, size_t count, const ctLeafPair* near) {
  ctStatus status = ctSuccess;
  for (int i = 0; i < sets->count && status == ctSuccess; i++) {
    status = ctPairSumsRefresh(&sets->sums[i], count, near);
  }
  return status;
}

typedef ctStatus ChangeFunction(PairSums* sums, double* change);

static ctStatus sumChanges(PairSets* sets, ChangeFunction* changeOfSet, double* change) {
  ctStatus status = ctSuccess;
  *change = 0;
  for (int i = 0; i < sets->count && status == ctSuccess; i++) {
    double ofSet = 0;
    status = changeOfSet(&sets->sums[i], &ofSet);
    *change += ofSet;
  }
  return status;
}

ctStatus ctPairSetsNearChange(PairSets* sets, double* change) {
  return sumChanges(sets, ctPairSumsNearChange, change);
}

ctStatus ctPairSetsOtherChange(PairSets* sets, double* change) {
  return sumChanges(sets, ctPairSumsOtherChange, change);
}

bool ctPairSetsAccept(PairSets* sets) {
  bool isKept = true;
  for (int i = 0; i < sets->count; i++) {
    isKept = ctPairSumsAccept(&sets->sums[i]) && isKept;
  }
  return isKept;
}

bool ctPairSetsKeep(PairSets* sets) {
  bool isKept = true;
  for (int i = 0; i < sets->count && isKept; i++) {
    isKept = ctPairSumsKeep(&sets->sums[i]);
  }
  return isKept;
}

void ctPairSetsTakeBack(PairSets* sets) {
  for (int i = 0; i < sets->count; i++) {
    ctPairSumsTakeBack(&sets->sums[i]);
  }
}
