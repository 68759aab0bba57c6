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

static ctStatus createNonbonded(AllPairs* pairs, const ctEnergyDefinition* d, const int* slotOf, char* errorText,
                                size_t errorSize) {
  pairs->hasNonbonded = true;
  const ctStatus status = ctNonbondedCreate(&pairs->nonbonded, pairs->leaves.tree, d->scene->particleCount,
                                            d->nonbonded, slotOf, errorText, errorSize);
  if (status == ctSuccess &&
      !ctPairSumsCreate(&pairs->sums, &pairs->leaves, d->nonbonded->cutoff, ctNonbondedEnergies, &pairs->nonbonded)) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  return status;
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
  ctStatus status = ctSuccess;
  if (d->born != NULL) {
    status = createStandIn(pairs, d, slotOf, errorText, errorSize);
  } else if (d->nonbonded != NULL) {
    status = createNonbonded(pairs, d, slotOf, errorText, errorSize);
  }
  return status != ctSuccess ? status
                             : ctPairSetsCreate(&pairs->sets, &pairs->leaves, particleCount, d->pairSetCount,
                                                d->pairSets, slotOf, errorText, errorSize);
}

void ctAllPairsFree(AllPairs* pairs) {
  ctPairSetsFree(&pairs->sets);
  ctPairSumsFree(&pairs->sums);
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
  } else if (status == ctSuccess && pairs->hasNonbonded) {
    status = ctPairSumsRefresh(&pairs->sums, count, near);
  }
  return status == ctSuccess ? ctPairSetsRefresh(&pairs->sets, count, near) : status;
}

double ctAllPairsEnergy(const AllPairs* pairs) {
  if (pairs->hasStandIn) {
    return ctStandInEnergy(&pairs->standIn);
  }
  return pairs->hasNonbonded ? ctLeafSumsTotal(&pairs->sums.sums) : 0;
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

ctStatus ctAllPairsNearChange(AllPairs* pairs, double* change, ctCounts* counts) {
  double ofSums = 0;
  double ofSets = 0;
  double ofStandIn = 0;
  ctStatus status = ctTrialLeavesOpen(&pairs->leaves, counts);
  if (status == ctSuccess && pairs->hasStandIn) {
    status = ctStandInNearChange(&pairs->standIn, &ofStandIn);
  } else if (status == ctSuccess && pairs->hasNonbonded) {
    status = ctPairSumsNearChange(&pairs->sums, &ofSums);
  }
  if (status == ctSuccess) {
    status = ctPairSetsNearChange(&pairs->sets, &ofSets);
  }
  pairs->nearChange = ofSums + ofSets;
  *change = pairs->nearChange + ofStandIn;
  return status;
}

ctStatus ctAllPairsOtherChange(AllPairs* pairs, double* change) {
  double ofPairs = 0;
  double ofSets = 0;
  ctStatus status = ctSuccess;
  if (pairs->hasStandIn) {
    status = ctStandInOtherChange(&pairs->standIn, &ofPairs);
  } else if (pairs->hasNonbonded) {
    status = ctPairSumsOtherChange(&pairs->sums, &ofPairs);
  }
  if (status == ctSuccess) {
    status = ctPairSetsOtherChange(&pairs->sets, &ofSets);
  }
  *change = ofPairs + ofSets;
  return status;
}

double ctAllPairsNearChangeBack(const AllPairs* pairs) {
  return (pairs->hasStandIn ? pairs->standIn.nearChangeBack : 0) - pairs->nearChange;
}

bool ctAllPairsAccept(AllPairs* pairs) {
  ctTrialLeavesAccept(&pairs->leaves);
  return (!pairs->hasStandIn || ctStandInAccept(&pairs->standIn)) &&
         (!pairs->hasNonbonded || ctPairSumsAccept(&pairs->sums)) && ctPairSetsAccept(&pairs->sets);
}

/* ---- Copies ---- */

bool ctAllPairsKeep(AllPairs* pairs) {
  return (!pairs->hasStandIn || ctStandInKeep(&pairs->standIn)) &&
         (!pairs->hasNonbonded || ctPairSumsKeep(&pairs->sums)) && ctPairSetsKeep(&pairs->sets);
}

bool ctAllPairsTakeBack(AllPairs* pairs) {
  if (pairs->hasNonbonded) {
    ctPairSumsTakeBack(&pairs->sums);
  }
  ctPairSetsTakeBack(&pairs->sets);
  ctTrialLeavesForget(&pairs->leaves);
  return pairs->leaves.statePositions != NULL && (!pairs->hasStandIn || ctStandInTakeBack(&pairs->standIn));
}
