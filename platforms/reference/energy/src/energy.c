/* Life of an energy, and the order in which a trial's parts are computed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nonbonded.h"
#include "pairsets.h"
#include "standin.h"
#include "terms.h"
#include "wholeenergy.h"

/* Not the change count of any state. */
enum { NO_STATE = -1 };

struct ctEnergy {
  ctChainTree* tree;
  Terms* terms;
  bool hasLeaves; /* there are pairs of any kind, and what follows */
  TrialLeaves leaves;
  bool hasNonbonded;
  Nonbonded nonbonded;
  PairSums pairs; /* of nonbonded */
  bool hasStandIn;
  StandIn standIn;   /* instead of nonbonded */
  WholeEnergy whole; /* with a stand-in */
  PairSets pairSets;
  int64_t state;     /* the scene's change count of the state that values belong to, or NO_STATE */
  int64_t trial;     /* the last one that was asked about */
  int computedParts; /* of it */
  double nearChange; /* its change of near pairs, but for those of the stand-in */
  bool hasCopy;      /* of all values, see ctKeepEnergy; they were those of the state, or of none */
  bool copyIsOfState;
  char errorText[200];
};

static ctStatus fail(ctEnergy* energy, ctStatus status, const char* text) {
  snprintf(energy->errorText, sizeof energy->errorText, "%s", text);
  return status;
}

static ctStatus failOutOfMemory(ctEnergy* energy) {
  return fail(energy, ctOutOfMemory, "out of memory");
}

/* ---- Life ---- */

/* The slot of each particle, or CT_NULL; NULL if there is no memory. */
static int* findSlots(const ctChainTree* tree, int particleCount) {
  const size_t slots = (size_t)ctGetLeafCount(tree) * CT_LEAF_WIDTH;
  int* particles = malloc((slots + 1) * sizeof(int));
  int* slotOf = malloc(((size_t)particleCount + 1) * sizeof(int));
  if (particles == NULL || slotOf == NULL) {
    free(particles);
    free(slotOf);
    return NULL;
  }
  for (int i = 0; i < particleCount; i++) {
    slotOf[i] = CT_NULL;
  }
  ctGetLeafParticles(tree, particles);
  for (size_t slot = 0; slot < slots; slot++) {
    if (particles[slot] != CT_NULL) {
      slotOf[particles[slot]] = (int)slot;
    }
  }
  free(particles);
  return slotOf;
}

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

static ctStatus buildNonbonded(ctEnergy* energy, const ctEnergyDefinition* d, const int* slotOf, char* errorText,
                               size_t errorSize) {
  energy->hasNonbonded = true;
  const ctStatus status = ctNonbondedCreate(&energy->nonbonded, energy->tree, d->scene->particleCount, d->nonbonded,
                                            slotOf, errorText, errorSize);
  if (status == ctSuccess &&
      !ctPairSumsCreate(&energy->pairs, &energy->leaves, d->nonbonded->cutoff, ctNonbondedEnergy, &energy->nonbonded)) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  return status;
}

static ctStatus buildPairs(ctEnergy* energy, const ctEnergyDefinition* d, const int* slotOf, char* errorText,
                           size_t errorSize) {
  const int particleCount = d->scene->particleCount;
  if (!ctTrialLeavesCreate(&energy->leaves, energy->tree, greatestCutoff(d), particleCount, slotOf)) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  energy->hasLeaves = true;
  ctStatus status = ctSuccess;
  if (d->born != NULL) {
    energy->hasStandIn = true;
    status = ctStandInCreate(&energy->standIn, &energy->leaves, particleCount, d, slotOf, errorText, errorSize);
    if (status == ctSuccess) {
      status = ctWholeEnergyCreate(&energy->whole, energy->tree, particleCount, d->nonbonded, d->born, slotOf,
                                   errorText, errorSize);
    }
  } else if (d->nonbonded != NULL) {
    status = buildNonbonded(energy, d, slotOf, errorText, errorSize);
  }
  if (status == ctSuccess) {
    status = ctPairSetsCreate(&energy->pairSets, &energy->leaves, particleCount, d->pairSetCount, d->pairSets, slotOf,
                              errorText, errorSize);
  }
  return status;
}

static ctStatus build(ctEnergy* energy, const ctEnergyDefinition* d, char* errorText, size_t errorSize) {
  if (d->born != NULL && (d->nonbonded == NULL || d->standIn == NULL)) {
    snprintf(errorText, errorSize, "a Born energy needs a nonbonded energy and a stand-in");
    return ctInvalidArgument;
  }
  int* slotOf = findSlots(energy->tree, d->scene->particleCount);
  if (slotOf == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  ctStatus status = ctTermsCreate(d->scene, d->termSetCount, d->termSets, slotOf, &energy->terms, errorText, errorSize);
  if (status == ctSuccess && (d->nonbonded != NULL || d->pairSetCount != 0)) {
    status = buildPairs(energy, d, slotOf, errorText, errorSize);
  }
  free(slotOf);
  return status;
}

ctStatus ctCreateEnergy(ctChainTree* tree, const ctEnergyDefinition* definition, ctEnergy** energy, char* errorText,
                        size_t errorSize) {
  char ignored[1];
  *energy = NULL;
  if (errorText == NULL || errorSize == 0) {
    errorText = ignored;
    errorSize = sizeof ignored;
  }
  errorText[0] = '\0';
  ctEnergy* made = calloc(1, sizeof *made);
  if (made == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  made->tree = tree;
  made->state = NO_STATE;
  const ctStatus status = build(made, definition, errorText, errorSize);
  if (status != ctSuccess) {
    ctDestroyEnergy(made);
    return status;
  }
  *energy = made;
  return ctSuccess;
}

void ctDestroyEnergy(ctEnergy* energy) {
  if (energy != NULL) {
    ctTermsDestroy(energy->terms);
    ctPairSetsFree(&energy->pairSets);
    ctPairSumsFree(&energy->pairs);
    ctNonbondedFree(&energy->nonbonded);
    ctStandInFree(&energy->standIn);
    ctWholeEnergyFree(&energy->whole);
    ctTrialLeavesFree(&energy->leaves);
    free(energy);
  }
}

const char* ctGetEnergyErrorText(const ctEnergy* energy) {
  return energy->errorText;
}

int ctCountChangeableTerms(const ctEnergy* energy, int termSet) {
  return ctTermsCountChangeable(energy->terms, termSet);
}

/* ---- The state ---- */

static ctStatus refreshPairs(ctEnergy* energy, ctCounts* counts) {
  size_t count;
  const ctLeafPair* near;
  ctStatus status = ctTrialLeavesRefresh(&energy->leaves, &count, &near, counts);
  if (status == ctSuccess && energy->hasStandIn) {
    status = ctStandInRefresh(&energy->standIn, count, near);
  } else if (status == ctSuccess && energy->hasNonbonded) {
    status = ctPairSumsRefresh(&energy->pairs, count, near);
  }
  return status == ctSuccess ? ctPairSetsRefresh(&energy->pairSets, count, near) : status;
}

ctStatus ctRefreshEnergy(ctEnergy* energy, ctCounts* counts) {
  const ctLeafPositions* leaves = ctGetLeaves(energy->tree);
  energy->computedParts = 0;
  energy->state = NO_STATE;
  if (leaves == NULL || (energy->hasLeaves && refreshPairs(energy, counts) != ctSuccess)) {
    return failOutOfMemory(energy);
  }
  ctTermsRefresh(energy->terms, leaves);
  energy->state = ctGetChangeCount(energy->tree);
  return ctSuccess;
}

bool ctIsEnergyOfState(const ctEnergy* energy) {
  return energy->state == ctGetChangeCount(energy->tree);
}

double ctGetPairEnergy(const ctEnergy* energy) {
  if (energy->hasStandIn) {
    return ctStandInEnergy(&energy->standIn);
  }
  return energy->hasNonbonded ? ctLeafSumsTotal(&energy->pairs.sums) : 0;
}

double ctGetPairSetEnergy(const ctEnergy* energy, int pairSet) {
  return ctLeafSumsTotal(&energy->pairSets.sums[pairSet].sums);
}

double ctGetTermEnergy(const ctEnergy* energy, int termSet) {
  return ctTermsSum(energy->terms, termSet);
}

/* ---- Trials ---- */

static ctStatus changeTerms(ctEnergy* energy, double* change) {
  TrialView view;
  view.state = ctGetLeaves(energy->tree);
  view.pieceCount = ctGetTrialPieces(energy->tree, &view.pieces, &view.motions);
  view.linkCount = ctGetTrialLinks(energy->tree, &view.links);
  if (view.state == NULL) {
    return ctOutOfMemory;
  }
  *change = ctTermsChange(energy->terms, &view);
  return ctSuccess;
}

static ctStatus changeNearPairs(ctEnergy* energy, double* change, ctCounts* counts) {
  double ofPairs = 0;
  double ofSets = 0;
  double ofStandIn = 0;
  ctStatus status = ctTrialLeavesOpen(&energy->leaves, counts);
  if (status == ctSuccess && energy->hasStandIn) {
    status = ctStandInNearChange(&energy->standIn, &ofStandIn);
  } else if (status == ctSuccess && energy->hasNonbonded) {
    status = ctPairSumsNearChange(&energy->pairs, &ofPairs);
  }
  if (status == ctSuccess) {
    status = ctPairSetsNearChange(&energy->pairSets, &ofSets);
  }
  energy->nearChange = ofPairs + ofSets;
  *change = energy->nearChange + ofStandIn;
  return status;
}

static ctStatus changeOtherPairs(ctEnergy* energy, double* change) {
  double ofPairs = 0;
  double ofSets = 0;
  ctStatus status = ctSuccess;
  if (energy->hasStandIn) {
    status = ctStandInOtherChange(&energy->standIn, &ofPairs);
  } else if (energy->hasNonbonded) {
    status = ctPairSumsOtherChange(&energy->pairs, &ofPairs);
  }
  if (status == ctSuccess) {
    status = ctPairSetsOtherChange(&energy->pairSets, &ofSets);
  }
  *change = ofPairs + ofSets;
  return status;
}

ctStatus ctComputeEnergyChange(ctEnergy* energy, ctEnergyPart part, double* change, ctCounts* counts) {
  if (!ctHasTrial(energy->tree)) {
    return fail(energy, ctNoTrial, "there is no open trial");
  }
  if (!ctIsEnergyOfState(energy)) {
    return fail(energy, ctInvalidArgument, "the state has changed since the energy was refreshed");
  }
  const int64_t trial = ctGetTrialCount(energy->tree);
  if (part == ctTermsPart || energy->trial != trial) {
    energy->trial = trial;
    energy->computedParts = 0;
  }
  if ((int)part != energy->computedParts || part > ctOtherPairsPart) {
    return fail(energy, ctInvalidArgument, "the parts of a change have to be computed in their order");
  }
  *change = 0;
  ctStatus status = ctSuccess;
  if (part == ctTermsPart) {
    status = changeTerms(energy, change);
  } else if (energy->hasLeaves && part == ctNearPairsPart) {
    status = changeNearPairs(energy, change, counts);
  } else if (energy->hasLeaves) {
    status = changeOtherPairs(energy, change);
  }
  if (status != ctSuccess) {
    energy->computedParts = 0;
    return failOutOfMemory(energy);
  }
  energy->computedParts = (int)part + 1;
  return ctSuccess;
}

ctStatus ctAcceptEnergyChange(ctEnergy* energy) {
  if (energy->computedParts != CT_ENERGY_PARTS || energy->trial != ctGetTrialCount(energy->tree) ||
      energy->state + 1 != ctGetChangeCount(energy->tree)) {
    return fail(energy, ctInvalidArgument, "not all parts of the last trial's change were computed and then committed");
  }
  energy->computedParts = 0;
  energy->state = NO_STATE;
  ctTermsAccept(energy->terms);
  if (energy->hasLeaves) {
    ctTrialLeavesAccept(&energy->leaves);
    if ((energy->hasStandIn && !ctStandInAccept(&energy->standIn)) ||
        (energy->hasNonbonded && !ctPairSumsAccept(&energy->pairs)) || !ctPairSetsAccept(&energy->pairSets)) {
      return failOutOfMemory(energy);
    }
  }
  energy->state = ctGetChangeCount(energy->tree);
  return ctSuccess;
}

/* ---- Two levels ---- */

double ctGetNearChangeBack(const ctEnergy* energy) {
  return (energy->hasStandIn ? energy->standIn.nearChangeBack : 0) - energy->nearChange;
}

ctStatus ctComputeWholeEnergy(ctEnergy* energy, double* nonbonded, double* born, ctCounts* counts) {
  (void)counts;
  *nonbonded = ctGetPairEnergy(energy);
  *born = 0;
  if (energy->hasStandIn && ctWholeEnergyCompute(&energy->whole, nonbonded, born) != ctSuccess) {
    return failOutOfMemory(energy);
  }
  return ctSuccess;
}

ctStatus ctRenewStandIn(ctEnergy* energy, ctCounts* counts) {
  const ctStatus status = ctRefreshEnergy(energy, counts);
  if (status != ctSuccess || !energy->hasStandIn) {
    return status;
  }
  const size_t count = (size_t)energy->whole.particleCount + 1;
  double* far = malloc(count * sizeof *far);
  double* near = malloc(count * sizeof *near);
  const bool isDone = far != NULL && near != NULL && ctWholeEnergyBornSums(&energy->whole, far) == ctSuccess;
  if (isDone) {
    ctStandInGetNear(&energy->standIn, near);
    for (int i = 0; i < energy->whole.particleCount; i++) {
      far[i] -= near[i];
    }
    ctStandInSetFar(&energy->standIn, far);
  }
  free(far);
  free(near);
  return isDone ? ctRefreshEnergy(energy, counts) : failOutOfMemory(energy);
}

void ctGetStandIn(const ctEnergy* energy, double* constants) {
  if (energy->hasStandIn) {
    ctStandInGetFar(&energy->standIn, constants);
  }
}

void ctSetStandIn(ctEnergy* energy, const double* constants) {
  if (energy->hasStandIn) {
    ctStandInSetFar(&energy->standIn, constants);
    energy->state = NO_STATE;
  }
}

static bool keepPairs(ctEnergy* energy) {
  return (!energy->hasStandIn || ctStandInKeep(&energy->standIn)) &&
         (!energy->hasNonbonded || ctPairSumsKeep(&energy->pairs)) && ctPairSetsKeep(&energy->pairSets);
}

static bool takeBackPairs(ctEnergy* energy) {
  if (energy->hasNonbonded) {
    ctPairSumsTakeBack(&energy->pairs);
  }
  ctPairSetsTakeBack(&energy->pairSets);
  ctTrialLeavesForget(&energy->leaves);
  return energy->leaves.statePositions != NULL && (!energy->hasStandIn || ctStandInTakeBack(&energy->standIn));
}

ctStatus ctKeepEnergy(ctEnergy* energy) {
  energy->hasCopy = false;
  if (!ctTermsKeep(energy->terms) || (energy->hasLeaves && !keepPairs(energy))) {
    return failOutOfMemory(energy);
  }
  energy->hasCopy = true;
  energy->copyIsOfState = ctIsEnergyOfState(energy);
  return ctSuccess;
}

ctStatus ctTakeBackEnergy(ctEnergy* energy) {
  if (!energy->hasCopy) {
    return fail(energy, ctInvalidArgument, "there is no copy of the energy");
  }
  energy->computedParts = 0;
  energy->state = NO_STATE;
  ctTermsTakeBack(energy->terms);
  if (energy->hasLeaves && !takeBackPairs(energy)) {
    return failOutOfMemory(energy);
  }
  if (energy->copyIsOfState) {
    energy->state = ctGetChangeCount(energy->tree);
  }
  return ctSuccess;
}
