#include "allpairs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- Life ---- */

/* How far apart particles can be that a trial has to look at, nm. */
static double greatestCutoff(const ctEnergyDefinition* d) {
  double cutoff = 0;
  if (d->born != NULL) {
    cutoff = fmax(d->standIn->bornCutoff, d->standIn->pairCutoff);
  } else if (d->nonbonded != NULL) {
    cutoff = d->nonbonded->cutoff;
  }
  for (int i = 0; i < d->pairSetCount; i++) {
    cutoff = fmax(cutoff, d->pairSets[i].cutoff);
  }
  return cutoff;
}

static ctStatus addSums(AllPairs* pairs, double cutoff, LeafPairFunction* function, const void* model, char* errorText,
                        size_t errorSize) {
  if (!ctPairSumsCreate(&pairs->sums[pairs->sumCount++], &pairs->leaves, cutoff, function, model)) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  return ctSuccess;
}

static ctStatus createSets(AllPairs* pairs, const ctEnergyDefinition* d, const int* slotOf, char* errorText,
                           size_t errorSize) {
  pairs->sets = calloc((size_t)d->pairSetCount + 1, sizeof *pairs->sets);
  pairs->sums = calloc((size_t)d->pairSetCount + 1, sizeof *pairs->sums);
  if (pairs->sets == NULL || pairs->sums == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  ctStatus status = ctSuccess;
  for (int i = 0; i < d->pairSetCount && status == ctSuccess; i++) {
    PairSet* set = &pairs->sets[i];
    status = ctPairSetCreate(set, pairs->leaves.tree, d->scene->particleCount, &d->pairSets[i], i, slotOf, errorText,
                             errorSize);
    if (status == ctSuccess) {
      pairs->setCount++;
      status = addSums(pairs, set->cutoff, ctPairSetEnergies, set, errorText, errorSize);
    }
  }
  return status;
}

static ctStatus createNonbonded(AllPairs* pairs, const ctEnergyDefinition* d, const int* slotOf, char* errorText,
                                size_t errorSize) {
  const ctStatus status = ctNonbondedCreate(&pairs->nonbonded, pairs->leaves.tree, d->scene->particleCount,
                                            d->nonbonded, slotOf, errorText, errorSize);
  return status != ctSuccess
             ? status
             : addSums(pairs, d->nonbonded->cutoff, ctNonbondedEnergies, &pairs->nonbonded, errorText, errorSize);
}

static ctStatus createStandIn(AllPairs* pairs, const ctEnergyDefinition* d, const int* slotOf, char* errorText,
                              size_t errorSize) {
  const int particleCount = d->scene->particleCount;
  pairs->hasStandIn = true;
  const ctStatus status =
      ctStandInCreate(&pairs->standIn, &pairs->leaves, particleCount, d, slotOf, errorText, errorSize);
  return status != ctSuccess ? status
                             : ctWholeEnergyCreate(&pairs->whole, pairs->leaves.tree, particleCount, d->nonbonded,
                                                   d->born, slotOf, errorText, errorSize);
}

ctStatus ctAllPairsCreate(AllPairs* pairs, ctChainTree* tree, const ctEnergyDefinition* d, const int* slotOf,
                          char* errorText, size_t errorSize) {
  const int particleCount = d->scene->particleCount;
  if (d->pairSetCount < 0 || d->pairSetCount > CT_MOST_COUNT || (d->pairSetCount > 0 && d->pairSets == NULL)) {
    snprintf(errorText, errorSize, "there are %d pair sets%s", d->pairSetCount,
             d->pairSets == NULL ? ", which are NULL" : "");
    return ctInvalidArgument;
  }
  if (!ctTrialLeavesCreate(&pairs->leaves, tree, greatestCutoff(d), particleCount, slotOf)) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  const ctStatus status = createSets(pairs, d, slotOf, errorText, errorSize);
  if (status != ctSuccess || d->nonbonded == NULL) {
    return status;
  }
  return d->born != NULL ? createStandIn(pairs, d, slotOf, errorText, errorSize)
                         : createNonbonded(pairs, d, slotOf, errorText, errorSize);
}

void ctAllPairsFree(AllPairs* pairs) {
  for (int i = 0; i < pairs->sumCount; i++) {
    ctPairSumsFree(&pairs->sums[i]);
  }
  for (int i = 0; i < pairs->setCount; i++) {
    ctPairSetFree(&pairs->sets[i]);
  }
  free(pairs->sums);
  free(pairs->sets);
  ctNonbondedFree(&pairs->nonbonded);
  ctStandInFree(&pairs->standIn);
  ctWholeEnergyFree(&pairs->whole);
  ctTrialLeavesFree(&pairs->leaves);
}

/* ---- The state ---- */

ctStatus ctAllPairsRefresh(AllPairs* pairs, ctCounts* counts) {
  size_t count;
  const ctLeafPair* near;
  ctStatus status = ctTrialLeavesRefresh(&pairs->leaves, &count, &near, counts);
  if (status == ctSuccess && pairs->hasStandIn) {
    status = ctStandInRefresh(&pairs->standIn, count, near);
  }
  for (int i = 0; i < pairs->sumCount && status == ctSuccess; i++) {
    status = ctPairSumsRefresh(&pairs->sums[i], count, near);
  }
  return status;
}

double ctAllPairsSetEnergy(const AllPairs* pairs, int set) {
  return ctLeafSumsTotal(&pairs->sums[set].sums);
}

double ctAllPairsEnergy(const AllPairs* pairs) {
  if (pairs->hasStandIn) {
    return ctStandInEnergy(&pairs->standIn);
  }
  return pairs->sumCount > pairs->setCount ? ctAllPairsSetEnergy(pairs, pairs->setCount) : 0;
}

ctStatus ctAllPairsRenewFar(AllPairs* pairs) {
  const int particleCount = pairs->whole.particleCount;
  const size_t size = ((size_t)particleCount + 1) * sizeof(double);
  double* far = malloc(size);
  double* near = malloc(size);
  const bool isDone = far != NULL && near != NULL && ctWholeEnergyBornSums(&pairs->whole, far) == ctSuccess;
  if (isDone) {
    ctStandInGetNear(&pairs->standIn, near);
    for (int i = 0; i < particleCount; i++) {
      near[i] = far[i] - near[i];
    }
    ctStandInGetFar(&pairs->standIn, far);
    for (int i = 0; i < particleCount; i++) {
      far[i] = isFarPart(near[i]) ? near[i] : far[i];
    }
    ctStandInSetFar(&pairs->standIn, far);
  }
  free(far);
  free(near);
  return isDone ? ctSuccess : ctOutOfMemory;
}

/* ---- Trials ---- */

ctStatus ctAllPairsChange(AllPairs* pairs, bool near, double* change, ctCounts* counts) {
  double ofStandIn = 0;
  double ofSums = 0;
  ctStatus status = near ? ctTrialLeavesOpen(&pairs->leaves, counts) : ctSuccess;
  if (status == ctSuccess && pairs->hasStandIn) {
    status =
        near ? ctStandInNearChange(&pairs->standIn, &ofStandIn) : ctStandInOtherChange(&pairs->standIn, &ofStandIn);
  }
  for (int i = 0; i < pairs->sumCount && status == ctSuccess; i++) {
    double ofPairs = 0;
    status = ctPairSumsChange(&pairs->sums[i], near, &ofPairs);
    ofSums += ofPairs;
  }
  if (near) {
    pairs->nearChange = ofSums;
  }
  *change = ofSums + ofStandIn;
  return status;
}

double ctAllPairsNearChangeBack(const AllPairs* pairs) {
  return (pairs->hasStandIn ? pairs->standIn.nearChangeBack : 0) - pairs->nearChange;
}

bool ctAllPairsAccept(AllPairs* pairs) {
  ctTrialLeavesAccept(&pairs->leaves);
  bool isDone = !pairs->hasStandIn || ctStandInAccept(&pairs->standIn);
  for (int i = 0; i < pairs->sumCount; i++) {
    isDone = ctPairSumsAccept(&pairs->sums[i]) && isDone;
  }
  return isDone;
}

/* ---- Copies ---- */

bool ctAllPairsSave(AllPairs* pairs) {
  bool isDone = !pairs->hasStandIn || ctStandInSave(&pairs->standIn);
  for (int i = 0; i < pairs->sumCount && isDone; i++) {
    isDone = ctPairSumsSave(&pairs->sums[i]);
  }
  return isDone;
}

bool ctAllPairsRestore(AllPairs* pairs) {
  for (int i = 0; i < pairs->sumCount; i++) {
    ctPairSumsRestore(&pairs->sums[i]);
  }
  ctTrialLeavesOutdate(&pairs->leaves);
  return pairs->leaves.statePositions != NULL && (!pairs->hasStandIn || ctStandInRestore(&pairs->standIn));
}
