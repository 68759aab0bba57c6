/* Life of an energy, and the order in which a trial's parts are computed. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "allpairs.h"
#include "terms.h"
#include "valueenergies.h"

/* Not the change count of any state. */
enum { NO_STATE = -1 };

struct ctEnergy {
  ctChainTree* tree;
  Terms* terms;
  bool hasPairs; /* of any kind */
  AllPairs pairs;
  ValueEnergies values;
  int64_t state;     /* the scene's change count of the state that values belong to, or NO_STATE */
  double shift;      /* the scene's total shift when values were last refreshed, nm */
  int64_t trial;     /* the last one that was asked about */
  int64_t commits;   /* the scene's commit count before it */
  int computedParts; /* of it */
  bool hasSaved;     /* of all values, see ctSaveEnergy */
  bool savedIsOfState;
  double savedLag;
  char errorText[200];
};

static ctStatus fail(ctEnergy* energy, ctStatus status, const char* format, ...) __attribute__((format(printf, 3, 4)));

static ctStatus fail(ctEnergy* energy, ctStatus status, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(energy->errorText, sizeof energy->errorText, format, arguments);
  va_end(arguments);
  return status;
}

/* Fails because the energy or an argument of this name is NULL. */
static ctStatus failMissing(ctEnergy* energy, const char* argument) {
  return energy == NULL ? ctInvalidArgument : fail(energy, ctInvalidArgument, "%s is NULL", argument);
}

static ctStatus failOutOfMemory(ctEnergy* energy) {
  return fail(energy, ctOutOfMemory, "out of memory");
}

/* Fails as a call on the scene has, or for lack of memory. */
static ctStatus failAsScene(ctEnergy* energy, ctStatus status) {
  return status == ctOutOfMemory ? failOutOfMemory(energy) : fail(energy, status, "%s", ctGetErrorText(energy->tree));
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

static ctStatus build(ctEnergy* energy, const ctEnergyDefinition* d, char* errorText, size_t errorSize) {
  if (d->born != NULL && (d->nonbonded == NULL || d->standIn == NULL)) {
    snprintf(errorText, errorSize, "a Born energy needs a nonbonded energy and a stand-in");
    return ctInvalidArgument;
  }
  if (d->born != NULL && d->nonbonded->ewaldAlpha != 0) {
    snprintf(errorText, errorSize, "a Born energy needs Coulomb energies without Ewald summation");
    return ctInvalidArgument;
  }
  if (!ctHasStructure(energy->tree, d->scene)) {
    snprintf(errorText, errorSize, "the scene was not made from the definition that the energy names");
    return ctInvalidArgument;
  }
  int* slotOf = findSlots(energy->tree, d->scene->particleCount);
  if (slotOf == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  ctStatus status = ctTermsCreate(d->scene, d->termSetCount, d->termSets, slotOf, &energy->terms, errorText, errorSize);
  if (status == ctSuccess && (d->nonbonded != NULL || d->pairSetCount != 0)) {
    energy->hasPairs = true;
    status = ctAllPairsCreate(&energy->pairs, energy->tree, d, slotOf, errorText, errorSize);
  }
  free(slotOf);
  return status != ctSuccess ? status
                             : ctValueEnergiesCreate(&energy->values, energy->tree, d->scene->particleCount,
                                                     d->valueEnergyCount, d->valueEnergies, errorText, errorSize);
}

ctStatus ctCreateEnergy(ctChainTree* tree, const ctEnergyDefinition* definition, ctEnergy** energy, char* errorText,
                        size_t errorSize) {
  char ignored[1];
  if (errorText == NULL || errorSize == 0) {
    errorText = ignored;
    errorSize = sizeof ignored;
  }
  errorText[0] = '\0';
  if (energy != NULL) {
    *energy = NULL;
  }
  if (tree == NULL || definition == NULL || energy == NULL) {
    snprintf(errorText, errorSize, "%s is NULL", tree == NULL ? "tree" : definition == NULL ? "definition" : "energy");
    return ctInvalidArgument;
  }
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
    ctAllPairsFree(&energy->pairs);
    ctValueEnergiesFree(&energy->values);
    free(energy);
  }
}

const char* ctGetEnergyErrorText(const ctEnergy* energy) {
  return energy != NULL ? energy->errorText : "";
}

static bool isTermSet(const ctEnergy* energy, int termSet) {
  return energy != NULL && termSet >= 0 && termSet < ctTermsSetCount(energy->terms);
}

int ctCountChangeableTerms(const ctEnergy* energy, int termSet) {
  return isTermSet(energy, termSet) ? ctTermsCountChangeable(energy->terms, termSet) : 0;
}

/* ---- The state ---- */

static bool hasStandIn(const ctEnergy* energy) {
  return energy != NULL && energy->hasPairs && energy->pairs.hasStandIn;
}

/* The greatest displacement, since values were last refreshed, of particles that counted as unmoved. */
static double lag(const ctEnergy* energy) {
  return ctGetTotalShift(energy->tree) - energy->shift;
}

/* Fails if a cutoff is more than half the width of the periodic box. */
static ctStatus checkCutoff(ctEnergy* energy, const double box[3][3], const char* name, int number, double cutoff) {
  const double half = fmin(box[0][0], fmin(box[1][1], box[2][2])) / 2;
  return cutoff <= half ? ctSuccess
                        : fail(energy, ctInvalidArgument,
                               "the cutoff of %s %d is %g nm; it must be at most half the periodic box's width, %g nm",
                               name, number, cutoff, half);
}

/* Fails if the scene is periodic and some part of the energy that is computed as a whole has a longer cutoff. */
static ctStatus checkBox(ctEnergy* energy) {
  double box[3][3];
  if (!ctGetBox(energy->tree, box)) {
    return ctSuccess;
  }
  ctStatus status = ctSuccess;
  for (int i = 0; i < energy->values.count && status == ctSuccess; i++) {
    status = checkCutoff(energy, (const double(*)[3])box, "value energy", i, energy->values.energies[i].cutoff);
  }
  const WholeEnergy* whole = &energy->pairs.whole;
  const double cutoffs[] = {sqrt(whole->nonbonded.potential.exact[0]), sqrt(whole->born.model.exactCutoff)};
  for (int i = 0; i < 2 && status == ctSuccess && hasStandIn(energy); i++) {
    status = checkCutoff(energy, (const double(*)[3])box, "energy", i, cutoffs[i]);
  }
  return status;
}

ctStatus ctRefreshEnergy(ctEnergy* energy, ctCounts* counts) {
  if (energy == NULL) {
    return ctInvalidArgument;
  }
  ctRenew(energy->tree);
  const ctLeafPositions* leaves = ctGetLeaves(energy->tree);
  energy->computedParts = 0;
  energy->state = NO_STATE;
  const ctStatus inBox = checkBox(energy);
  if (inBox != ctSuccess) {
    return inBox;
  }
  const ctStatus status = leaves == NULL     ? ctOutOfMemory
                          : energy->hasPairs ? ctAllPairsRefresh(&energy->pairs, counts)
                                             : ctSuccess;
  if (status != ctSuccess) {
    return failAsScene(energy, status);
  }
  ctTermsRefresh(energy->terms, energy->tree, leaves);
  energy->shift = ctGetTotalShift(energy->tree);
  energy->state = ctGetChangeCount(energy->tree);
  return ctSuccess;
}

bool ctIsEnergyOfState(const ctEnergy* energy) {
  return energy != NULL && energy->state == ctGetChangeCount(energy->tree);
}

double ctGetPairEnergy(const ctEnergy* energy) {
  if (energy == NULL) {
    return NAN;
  }
  return energy->hasPairs ? ctAllPairsEnergy(&energy->pairs) : 0;
}

double ctGetPairSetEnergy(const ctEnergy* energy, int pairSet) {
  const bool isThere = energy != NULL && pairSet >= 0 && pairSet < energy->pairs.setCount;
  return isThere ? ctAllPairsSetEnergy(&energy->pairs, pairSet) : NAN;
}

double ctGetTermEnergy(const ctEnergy* energy, int termSet) {
  return isTermSet(energy, termSet) ? ctTermsSum(energy->terms, termSet) : NAN;
}

/* ---- Trials ---- */

static ctStatus changeTerms(ctEnergy* energy, double* change) {
  TrialView view = {.tree = energy->tree};
  view.state = ctGetLeaves(energy->tree);
  view.pieceCount = ctGetTrialPieces(energy->tree, &view.pieces, &view.motions);
  view.linkCount = ctGetTrialLinks(energy->tree, &view.links);
  if (view.state == NULL) {
    return ctOutOfMemory;
  }
  *change = ctTermsChange(energy->terms, &view);
  return ctSuccess;
}

ctStatus ctComputeEnergyChange(ctEnergy* energy, ctEnergyPart part, double* change, ctCounts* counts) {
  if (energy == NULL || change == NULL) {
    return failMissing(energy, "change");
  }
  if (!ctHasTrial(energy->tree)) {
    return fail(energy, ctNoTrial, "there is no open trial");
  }
  if (!ctIsEnergyOfState(energy)) {
    return fail(energy, ctInvalidArgument, "the state has changed since the energy was refreshed");
  }
  const int64_t trial = ctGetTrialCount(energy->tree);
  if (part == ctTermsPart || energy->trial != trial) {
    energy->trial = trial;
    energy->commits = ctGetAcceptedCount(energy->tree);
    energy->computedParts = 0;
  }
  if ((int)part != energy->computedParts || (int)part > (int)ctOtherPairsPart) {
    return fail(energy, ctInvalidArgument, "the parts of a change have to be computed in their order");
  }
  *change = 0;
  ctStatus status = ctSuccess;
  if (part == ctTermsPart) {
    status = changeTerms(energy, change);
  } else if (energy->hasPairs) {
    status = ctAllPairsChange(&energy->pairs, part == ctNearPairsPart, change, counts);
  }
  if (status != ctSuccess) {
    energy->computedParts = 0;
    return failAsScene(energy, status);
  }
  energy->computedParts = (int)part + 1;
  return ctSuccess;
}

ctStatus ctAcceptEnergyChange(ctEnergy* energy) {
  if (energy == NULL) {
    return ctInvalidArgument;
  }
  if (energy->computedParts != CT_ENERGY_PARTS || energy->trial != ctGetTrialCount(energy->tree) ||
      energy->commits + 1 != ctGetAcceptedCount(energy->tree) || energy->state + 1 != ctGetChangeCount(energy->tree)) {
    return fail(energy, ctInvalidArgument, "not all parts of the last trial's change were computed and then accepted");
  }
  energy->computedParts = 0;
  energy->state = NO_STATE;
  ctTermsAccept(energy->terms);
  if (energy->hasPairs && !ctAllPairsAccept(&energy->pairs)) {
    return failOutOfMemory(energy);
  }
  energy->state = ctGetChangeCount(energy->tree);
  return lag(energy) <= CT_MOST_LAG ? ctSuccess : ctRefreshEnergy(energy, NULL);
}

/* ---- Energies of values ---- */

ctStatus ctComputeValueEnergies(ctEnergy* energy, bool inTrial, double* energies) {
  if (energy == NULL || (energies == NULL && energy->values.count > 0)) {
    return failMissing(energy, "energies");
  }
  const ctStatus inBox = checkBox(energy);
  if (inBox != ctSuccess) {
    return inBox;
  }
  const ctStatus status = ctValueEnergiesCompute(&energy->values, energy->tree, inTrial, energies);
  return status == ctSuccess ? ctSuccess : fail(energy, status, "there is no open trial");
}

/* ---- Two levels ---- */

double ctGetNearChangeBack(const ctEnergy* energy) {
  if (energy == NULL) {
    return NAN;
  }
  return energy->hasPairs ? ctAllPairsNearChangeBack(&energy->pairs) : 0;
}

ctStatus ctComputeWholeEnergy(ctEnergy* energy, double* nonbonded, double* born, ctCounts* counts) {
  (void)counts;
  if (energy == NULL || nonbonded == NULL || born == NULL) {
    return failMissing(energy, nonbonded == NULL ? "nonbonded" : "born");
  }
  *nonbonded = ctGetPairEnergy(energy);
  *born = 0;
  if (hasStandIn(energy) && ctWholeEnergyCompute(&energy->pairs.whole, nonbonded, born) != ctSuccess) {
    return failOutOfMemory(energy);
  }
  return ctSuccess;
}

ctStatus ctRenewStandIn(ctEnergy* energy, ctCounts* counts) {
  const ctStatus status = ctRefreshEnergy(energy, counts);
  if (status != ctSuccess || !hasStandIn(energy)) {
    return status;
  }
  if (ctAllPairsRenewFar(&energy->pairs) != ctSuccess) {
    return failOutOfMemory(energy);
  }
  energy->savedIsOfState = false;
  return ctRefreshEnergy(energy, counts);
}

void ctGetStandIn(const ctEnergy* energy, double* constants) {
  if (hasStandIn(energy) && constants != NULL) {
    ctStandInGetFar(&energy->pairs.standIn, constants);
  }
}

ctStatus ctSetStandIn(ctEnergy* energy, const double* constants) {
  if (energy == NULL) {
    return ctInvalidArgument;
  }
  if (!hasStandIn(energy)) {
    return ctSuccess;
  }
  const int count = energy->pairs.standIn.particleCount;
  if (constants == NULL && count > 0) {
    return failMissing(energy, "constants");
  }
  for (int i = 0; i < count; i++) {
    if (!isFarPart(constants[i])) {
      return fail(energy, ctInvalidArgument, "the constant of particle %d is %g, which is no finite float", i,
                  constants[i]);
    }
  }
  ctStandInSetFar(&energy->pairs.standIn, constants);
  energy->state = NO_STATE;
  energy->savedIsOfState = false;
  return ctSuccess;
}

ctStatus ctSaveEnergy(ctEnergy* energy) {
  if (energy == NULL) {
    return ctInvalidArgument;
  }
  energy->hasSaved = false;
  if (!ctTermsSave(energy->terms) || (energy->hasPairs && !ctAllPairsSave(&energy->pairs))) {
    return failOutOfMemory(energy);
  }
  energy->hasSaved = true;
  energy->savedIsOfState = ctIsEnergyOfState(energy);
  energy->savedLag = lag(energy);
  return ctSuccess;
}

ctStatus ctRestoreEnergy(ctEnergy* energy) {
  if (energy == NULL) {
    return ctInvalidArgument;
  }
  if (!energy->hasSaved) {
    return fail(energy, ctInvalidArgument, "there is no copy of the energy");
  }
  energy->computedParts = 0;
  energy->state = NO_STATE;
  ctTermsRestore(energy->terms);
  if (energy->hasPairs && !ctAllPairsRestore(&energy->pairs)) {
    return failOutOfMemory(energy);
  }
  energy->shift = ctGetTotalShift(energy->tree) - energy->savedLag;
  if (energy->savedIsOfState) {
    energy->state = ctGetChangeCount(energy->tree);
  }
  return ctSuccess;
}
