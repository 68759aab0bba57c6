#include "pairsets.h"

#include <stdio.h>
#include <stdlib.h>

/* ---- Life ---- */

static bool createSums(PairSets* sets, int i, TrialLeaves* leaves, const ctDefinition* scene) {
  PairSet* set = &sets->sets[i];
  sets->areOnGrid[i] = ctPairSetFitsGrid(set);
  if (!sets->areOnGrid[i]) {
    return ctPairSumsCreate(&sets->sums[i], leaves, set->cutoff, ctPairSetEnergies, set);
  }
  if (!sets->hasGrids && !ctTrialGridsCreate(&sets->grids, leaves, scene)) {
    return false;
  }
  sets->hasGrids = true;
  return ctGridSumsCreate(&sets->gridSums[i], &sets->grids, set);
}

static void freeSums(PairSets* sets, int i) {
  if (sets->areOnGrid[i]) {
    ctGridSumsFree(&sets->gridSums[i]);
  } else {
    ctPairSumsFree(&sets->sums[i]);
  }
}

static ctStatus addSet(PairSets* sets, TrialLeaves* leaves, const ctDefinition* scene, const ctPairSet* description,
                       const int* slotOf, char* errorText, size_t errorSize) {
  const int i = sets->count;
  PairSet* set = &sets->sets[i];
  const ctStatus status =
      ctPairSetCreate(set, leaves->tree, scene->particleCount, description, i, slotOf, errorText, errorSize);
  if (status != ctSuccess) {
    return status;
  }
  if (!createSums(sets, i, leaves, scene)) {
    freeSums(sets, i);
    ctPairSetFree(set);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  sets->count++;
  return ctSuccess;
}

ctStatus ctPairSetsCreate(PairSets* sets, TrialLeaves* leaves, const ctDefinition* scene, int count,
                          const ctPairSet* descriptions, const int* slotOf, char* errorText, size_t errorSize) {
  *sets = (PairSets){0};
  if (count < 0) {
    snprintf(errorText, errorSize, "there are %d pair sets", count);
    return ctInvalidArgument;
  }
  sets->sets = calloc((size_t)count + 1, sizeof *sets->sets);
  sets->areOnGrid = calloc((size_t)count + 1, sizeof *sets->areOnGrid);
  sets->gridSums = calloc((size_t)count + 1, sizeof *sets->gridSums);
  sets->sums = calloc((size_t)count + 1, sizeof *sets->sums);
  ctStatus status = ctSuccess;
  if (sets->sets == NULL || sets->areOnGrid == NULL || sets->gridSums == NULL || sets->sums == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    status = ctOutOfMemory;
  }
  for (int i = 0; i < count && status == ctSuccess; i++) {
    status = addSet(sets, leaves, scene, &descriptions[i], slotOf, errorText, errorSize);
  }
  if (status != ctSuccess) {
    ctPairSetsFree(sets);
  }
  return status;
}

void ctPairSetsFree(PairSets* sets) {
  for (int i = 0; i < sets->count; i++) {
    freeSums(sets, i);
    ctPairSetFree(&sets->sets[i]);
  }
  ctTrialGridsFree(&sets->grids);
  free(sets->sets);
  free(sets->areOnGrid);
  free(sets->gridSums);
  free(sets->sums);
  *sets = (PairSets){0};
}

/* ---- The state ---- */

ctStatus ctPairSetsRefresh(PairSets* sets, size_t count, const ctLeafPair* near) {
  ctStatus status = ctSuccess;
  if (sets->hasGrids) {
    ctTrialGridsForget(&sets->grids);
  }
  for (int i = 0; i < sets->count && status == ctSuccess; i++) {
    status = sets->areOnGrid[i] ? ctGridSumsRefresh(&sets->gridSums[i], count, near)
                                : ctPairSumsRefresh(&sets->sums[i], count, near);
  }
  return status;
}

double ctPairSetsEnergy(const PairSets* sets, int number) {
  return sets->areOnGrid[number] ? ctSectionSumsTotal(&sets->gridSums[number].sums)
                                 : ctLeafSumsTotal(&sets->sums[number].sums);
}

/* ---- Trials ---- */

ctStatus ctPairSetsNearChange(PairSets* sets, double* change) {
  ctStatus status = ctSuccess;
  *change = 0;
  if (sets->hasGrids) {
    ctTrialGridsOpen(&sets->grids);
  }
  for (int i = 0; i < sets->count && status == ctSuccess; i++) {
    double ofSet = 0;
    status = sets->areOnGrid[i] ? ctGridSumsNearChange(&sets->gridSums[i], &ofSet)
                                : ctPairSumsNearChange(&sets->sums[i], &ofSet);
    *change += ofSet;
  }
  return status;
}

ctStatus ctPairSetsOtherChange(PairSets* sets, double* change) {
  ctStatus status = ctSuccess;
  *change = 0;
  for (int i = 0; i < sets->count && status == ctSuccess; i++) {
    double ofSet = 0;
    status = sets->areOnGrid[i] ? ctGridSumsOtherChange(&sets->gridSums[i], &ofSet)
                                : ctPairSumsOtherChange(&sets->sums[i], &ofSet);
    *change += ofSet;
  }
  return status;
}

bool ctPairSetsAccept(PairSets* sets) {
  bool isKept = true;
  if (sets->hasGrids) {
    ctTrialGridsAccept(&sets->grids);
  }
  for (int i = 0; i < sets->count; i++) {
    isKept = (sets->areOnGrid[i] ? ctGridSumsAccept(&sets->gridSums[i]) : ctPairSumsAccept(&sets->sums[i])) && isKept;
  }
  return isKept;
}

/* ---- Copies ---- */

bool ctPairSetsKeep(PairSets* sets) {
  bool isKept = true;
  for (int i = 0; i < sets->count && isKept; i++) {
    isKept = sets->areOnGrid[i] ? ctGridSumsKeep(&sets->gridSums[i]) : ctPairSumsKeep(&sets->sums[i]);
  }
  return isKept;
}

void ctPairSetsTakeBack(PairSets* sets) {
  if (sets->hasGrids) {
    ctTrialGridsForget(&sets->grids);
  }
  for (int i = 0; i < sets->count; i++) {
    if (sets->areOnGrid[i]) {
      ctGridSumsTakeBack(&sets->gridSums[i]);
    } else {
      ctPairSumsTakeBack(&sets->sums[i]);
    }
  }
}
