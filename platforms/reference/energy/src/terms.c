#include "terms.h"

#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dependence.h"
#include "heldterms.h"
#include "molecules.h"

struct Terms {
  int setCount;
  TermSet* sets;
  int termCount; /* of all sets, one after the other */
  double* values;
  double* savedValues; /* NULL: none were saved */
  int* setOf;
  uint8_t* repeats;    /* terms that share the dihedral of the term before */
  int* moleculeOfSlot; /* see ctFindMolecules */
  Dependence dependence;
  HeldTerms held;

  /* Long terms of nearest images: a turn of all of their particles changes them, too. */
  bool isPeriodic;
  PeriodicBox box;
  bool* isLong; /* per term */
  bool* savedIsLong;
  int longCount;
  int* longTerms; /* ascending */

  /* The open trial. */
  uint32_t trial;
  uint32_t* termTrials; /* of each term: the last trial of several links or of displaced particles that computed it */
  int changedCount;
  int* changedTerms; /* in the order in which they were computed */
  double* newValues;
  bool* newIsLong;

  /* Scratch. */
  double (*positions)[3]; /* of a term */
  int* slots;             /* whose positions these are, or CT_NULL - 1 less these if without shifts; CT_NULL: none's */
  int width;              /* the most particles of a term */
  double* results;        /* of an expression */
};

/* ---- Life ---- */

static bool describeSets(Terms* terms, int setCount, const ctTermSet* given, const int* slotOf) {
  terms->sets = calloc((size_t)setCount + 1, sizeof *terms->sets);
  if (terms->sets == NULL) {
    return false;
  }
  for (; terms->setCount < setCount; terms->setCount++) {
    TermSet* set = &terms->sets[terms->setCount];
    if (!ctTermSetCreate(&given[terms->setCount], terms->termCount, slotOf, set)) {
      ctTermSetFree(set);
      return false;
    }
    terms->termCount += set->count;
  }
  return true;
}

static bool allocateScratch(Terms* terms) {
  size_t changeable = 0;
  size_t operations = 0;
  for (int s = 0; s < terms->setCount; s++) {
    const TermSet* set = &terms->sets[s];
    changeable += (size_t)(set->isPeriodic ? set->count : set->changeableCount);
    terms->width = set->width > terms->width ? set->width : terms->width;
    operations =
        (size_t)set->expression.operationCount > operations ? (size_t)set->expression.operationCount : operations;
  }
  terms->termTrials = calloc((size_t)terms->termCount + 1, sizeof *terms->termTrials);
  terms->changedTerms = malloc((changeable + 1) * sizeof *terms->changedTerms);
  terms->newValues = malloc((changeable + 1) * sizeof *terms->newValues);
  terms->newIsLong = malloc((changeable + 1) * sizeof *terms->newIsLong);
  terms->positions = malloc(((size_t)terms->width + 1) * sizeof *terms->positions);
  terms->slots = malloc(((size_t)terms->width + 1) * sizeof *terms->slots);
  terms->results = calloc(operations + 1, sizeof *terms->results);
  return terms->termTrials != NULL && terms->changedTerms != NULL && terms->newValues != NULL &&
         terms->newIsLong != NULL && terms->positions != NULL && terms->slots != NULL && terms->results != NULL;
}

static bool allocateTerms(Terms* terms) {
  const size_t count = (size_t)terms->termCount + 1;
  terms->values = calloc(count, sizeof *terms->values);
  terms->setOf = malloc(count * sizeof *terms->setOf);
  terms->repeats = calloc(count, sizeof *terms->repeats);
  terms->isLong = calloc(count, sizeof *terms->isLong);
  terms->savedIsLong = calloc(count, sizeof *terms->savedIsLong);
  terms->longTerms = malloc(count * sizeof *terms->longTerms);
  if (terms->values == NULL || terms->setOf == NULL || terms->repeats == NULL || terms->isLong == NULL ||
      terms->savedIsLong == NULL || terms->longTerms == NULL) {
    return false;
  }
  for (int s = 0; s < terms->setCount; s++) {
    const TermSet* set = &terms->sets[s];
    for (int term = 0; term < set->count; term++) {
      terms->setOf[set->firstTerm + term] = s;
      terms->repeats[set->firstTerm + term] = ctTermSetRepeats(set, term);
    }
  }
  return true;
}

/* Up to the last one with a particle. */
static int countSlots(const ctDefinition* scene, const int* slotOf) {
  int slotCount = 0;
  for (int i = 0; i < scene->particleCount; i++) {
    slotCount = slotOf[i] >= slotCount ? slotOf[i] + 1 : slotCount;
  }
  return slotCount;
}

/* Finds the molecule of each slot, and the sets whose values change if molecules are shifted by box vectors. */
static bool findMolecules(Terms* terms, const ctDefinition* scene, const ctTermSet* sets, const int* slotOf) {
  int* molecules = ctFindMolecules(scene);
  terms->moleculeOfSlot = calloc((size_t)countSlots(scene, slotOf) + 1, sizeof *terms->moleculeOfSlot);
  if (molecules == NULL || terms->moleculeOfSlot == NULL) {
    free(molecules);
    return false;
  }
  for (int i = 0; i < scene->particleCount; i++) {
    if (slotOf[i] != CT_NULL) {
      terms->moleculeOfSlot[slotOf[i]] = molecules[scene->particleLinks[i]];
    }
  }
  for (int s = 0; s < terms->setCount; s++) {
    terms->sets[s].isUnshifted = !ctTermSetFitsBox(scene, &sets[s], molecules);
  }
  free(molecules);
  return true;
}

static ctStatus checkSets(const ctDefinition* scene, int setCount, const ctTermSet* sets, const int* slotOf,
                          char* errorText, size_t errorSize) {
  int termCount = 0;
  if (setCount < 0 || setCount > CT_MOST_COUNT || (setCount > 0 && sets == NULL)) {
    snprintf(errorText, errorSize, "there are %d term sets%s", setCount, sets == NULL ? ", which are NULL" : "");
    return ctInvalidArgument;
  }
  for (int s = 0; s < setCount; s++) {
    if (!ctTermSetIsValid(scene, &sets[s], s, slotOf, errorText, errorSize)) {
      return ctInvalidArgument;
    }
    if (sets[s].count > INT_MAX - 1 - termCount) {
      snprintf(errorText, errorSize, "term set %d has %d terms; with those before it these are too many", s,
               sets[s].count);
      return ctInvalidArgument;
    }
    termCount += sets[s].count;
  }
  return ctSuccess;
}

ctStatus ctTermsCreate(const ctDefinition* scene, int setCount, const ctTermSet* sets, const int* slotOf, Terms** terms,
                       char* errorText, size_t errorSize) {
  *terms = NULL;
  const ctStatus status = checkSets(scene, setCount, sets, slotOf, errorText, errorSize);
  if (status != ctSuccess) {
    return status;
  }
  Terms* made = calloc(1, sizeof *made);
  if (made == NULL || !describeSets(made, setCount, sets, slotOf) || !allocateTerms(made) ||
      !findMolecules(made, scene, sets, slotOf) ||
      !ctDependenceCreate(scene, setCount, sets, made->sets, &made->dependence) ||
      (scene->isFlexible && !ctHeldTermsCreate(countSlots(scene, slotOf), setCount, made->sets, &made->held)) ||
      !allocateScratch(made)) {
    ctTermsDestroy(made);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  *terms = made;
  return ctSuccess;
}

void ctTermsDestroy(Terms* terms) {
  if (terms == NULL) {
    return;
  }
  for (int s = 0; s < terms->setCount; s++) {
    ctTermSetFree(&terms->sets[s]);
  }
  free(terms->sets);
  free(terms->values);
  free(terms->savedValues);
  free(terms->setOf);
  free(terms->repeats);
  free(terms->moleculeOfSlot);
  free(terms->isLong);
  free(terms->savedIsLong);
  free(terms->longTerms);
  ctDependenceFree(&terms->dependence);
  ctHeldTermsFree(&terms->held);
  free(terms->termTrials);
  free(terms->changedTerms);
  free(terms->newValues);
  free(terms->newIsLong);
  free(terms->positions);
  free(terms->slots);
  free(terms->results);
  free(terms);
}

/* ---- Values ---- */

/* Terms that are evaluated one after another. */
typedef struct Evaluation {
  Terms* terms;
  const TrialView* view; /* without pieces: the state */
  const int* bodies;     /* of each slot, in a trial that displaces particles; else NULL */
  Term term;             /* the last one */
  int molecule;          /* the last one whose shift was asked for; 0: none was */
  double shift[3];
} Evaluation;

static Evaluation beginEvaluation(Terms* terms, const TrialView* view) {
  for (int p = 0; p < terms->width; p++) {
    terms->slots[p] = CT_NULL;
  }
  return (Evaluation){.terms = terms,
                      .view = view,
                      .term = {.x = (const double(*)[3])terms->positions,
                               .box = terms->isPeriodic ? &terms->box : NULL,
                               .results = terms->results}};
}

/* Takes the shift of a slot's molecule from its position, which is that of callers then. */
static void removeShift(Evaluation* evaluation, int slot, double x[3]) {
  const int molecule = evaluation->terms->moleculeOfSlot[slot];
  if (molecule == 0) {
    return;
  }
  if (molecule != evaluation->molecule) {
    const TrialView* view = evaluation->view;
    ctGetMoleculeShift(view->tree, molecule - 1, view->pieceCount > 0, evaluation->shift);
    evaluation->molecule = molecule;
  }
  for (int d = 0; d < 3; d++) {
    x[d] -= evaluation->shift[d];
  }
}

/* Terms often share some particles with the one before. */
static void gatherPositions(Evaluation* evaluation, const int* slots, int width) {
  Terms* terms = evaluation->terms;
  const TrialView* view = evaluation->view;
  const bool isUnshifted = terms->isPeriodic && evaluation->term.set->isUnshifted;
  for (int p = 0; p < width; p++) {
    const int key = isUnshifted ? CT_NULL - 1 - slots[p] : slots[p];
    if (key == terms->slots[p]) {
      continue;
    }
    double x[3];
    statePosition(view, slots[p], x);
    if (view->pieceCount > 0) {
      moveByBody(view, evaluation->bodies != NULL ? evaluation->bodies[slots[p]] : trialBody(view, slots[p]), x);
    }
    if (isUnshifted) {
      removeShift(evaluation, slots[p], x);
    }
    memcpy(terms->positions[p], x, sizeof x);
    terms->slots[p] = key;
  }
}

/* Terms that share a dihedral have the same joints and slots, so they come one after the other. */
static double evaluateTerm(Evaluation* evaluation, int number) {
  Terms* terms = evaluation->terms;
  Term* term = &evaluation->term;
  term->set = &terms->sets[terms->setOf[number]];
  const size_t i = (size_t)(number - term->set->firstTerm);
  term->numbers = term->set->numbers + i * (size_t)term->set->stride;
  term->sharesDihedral = terms->repeats[number];
  if (!term->sharesDihedral) {
    gatherPositions(evaluation, term->set->slots + i * (size_t)term->set->width, term->set->width);
  }
  return ctTermEvaluate(term);
}

/* ---- The state ---- */

/* Lists the terms that are long. */
static void listLongTerms(Terms* terms) {
  terms->longCount = 0;
  for (int term = 0; term < terms->termCount && terms->isPeriodic; term++) {
    if (terms->isLong[term]) {
      terms->longTerms[terms->longCount++] = term;
    }
  }
}

void ctTermsRefresh(Terms* terms, const ctChainTree* tree, const ctLeafPositions* state) {
  const TrialView view = {.tree = tree, .state = state};
  double box[3][3];
  terms->isPeriodic = ctGetBox(tree, box);
  if (terms->isPeriodic) {
    terms->box = makePeriodicBox((const double(*)[3])box);
  }
  Evaluation evaluation = beginEvaluation(terms, &view);
  terms->changedCount = 0;
  for (int term = 0; term < terms->termCount; term++) {
    terms->values[term] = evaluateTerm(&evaluation, term);
    terms->isLong[term] = evaluation.term.isLong;
  }
  listLongTerms(terms);
}

int ctTermsSetCount(const Terms* terms) {
  return terms->setCount;
}

double ctTermsSum(const Terms* terms, int set) {
  const double* values = terms->values + terms->sets[set].firstTerm;
  double sum = 0;
  for (int i = 0; i < terms->sets[set].count; i++) {
    sum += values[i];
  }
  return sum;
}

int ctTermsCountChangeable(const Terms* terms, int set) {
  return terms->sets[set].isPeriodic ? terms->sets[set].count : terms->sets[set].changeableCount;
}

/* ---- Trials ---- */

typedef struct Change {
  Evaluation evaluation;
  double sum;
} Change;

static void changeTerm(Change* change, int term) {
  Terms* terms = change->evaluation.terms;
  const double value = evaluateTerm(&change->evaluation, term);
  terms->changedTerms[terms->changedCount] = term;
  terms->newIsLong[terms->changedCount] = change->evaluation.term.isLong;
  terms->newValues[terms->changedCount++] = value;
  change->sum += changeOf(terms->values[term], value);
}

/* Begins to stamp terms, so that none is computed twice. */
static void beginStamps(Terms* terms) {
  if (++terms->trial == 0) {
    memset(terms->termTrials, 0, (size_t)terms->termCount * sizeof *terms->termTrials);
    terms->trial = 1;
  }
}

/* The terms that are listed with changed links. One in the lists of several is taken from the first. */
static void changeListedTerms(Change* change) {
  Terms* terms = change->evaluation.terms;
  const TrialView* view = change->evaluation.view;
  if (view->linkCount > 1) {
    beginStamps(terms);
  }
  for (int l = 0; l < view->linkCount; l++) {
    const size_t end = terms->dependence.begin[view->links[l] + 1];
    for (size_t i = terms->dependence.begin[view->links[l]]; i < end; i++) {
      const int term = terms->dependence.terms[i];
      if (view->linkCount > 1) {
        if (terms->termTrials[term] == terms->trial) {
          continue;
        }
        terms->termTrials[term] = terms->trial;
      }
      changeTerm(change, term);
    }
  }
}

static int pieceEnd(const TrialView* view, int piece) {
  return piece + 1 < view->pieceCount ? view->pieces[piece + 1].slotBegin : INT_MAX;
}

/* The first of `count` wide terms whose first slot is not below a slot. */
static int firstFrom(const WideTerm* wide, int count, int slot) {
  int begin = 0;
  while (begin < count) {
    const int middle = begin + (count - begin) / 2;
    if (wide[middle].firstSlot < slot) {
      begin = middle + 1;
    } else {
      count = middle;
    }
  }
  return begin;
}

/* Terms of one particle change where it moves. */
static void changeSingles(Change* change) {
  const Dependence* d = &change->evaluation.terms->dependence;
  const TrialView* view = change->evaluation.view;
  for (int piece = 0; piece < view->pieceCount && d->singleCount > 0; piece++) {
    if (view->pieces[piece].body == 0) {
      continue;
    }
    const int end = pieceEnd(view, piece);
    for (int i = firstFrom(d->singles, d->singleCount, view->pieces[piece].slotBegin);
         i < d->singleCount && d->singles[i].firstSlot < end; i++) {
      changeTerm(change, d->singles[i].term);
    }
  }
}

/* True if particles of a term move relative to each other or, if it is anchored, to the world. */
static bool isParted(const TrialView* view, const TermSet* set, int i) {
  const int* slots = set->slots + (size_t)i * (size_t)set->width;
  const int body = set->isAnchored ? 0 : trialBody(view, slots[0]);
  for (int p = 0; p < set->width; p++) {
    if (trialBody(view, slots[p]) != body) {
      return true;
    }
  }
  return false;
}

/* Most of the others lie in one piece. */
static void changeAcross(Change* change) {
  const Terms* terms = change->evaluation.terms;
  const Dependence* d = &terms->dependence;
  const TrialView* view = change->evaluation.view;
  int piece = 0;
  for (int i = 0; i < d->acrossCount; i++) {
    const WideTerm* wide = &d->across[i];
    while (pieceEnd(view, piece) <= wide->firstSlot) {
      piece++;
    }
    const bool isInOnePiece = wide->lastSlot < pieceEnd(view, piece);
    const TermSet* set = &terms->sets[terms->setOf[wide->term]];
    if (isInOnePiece ? view->pieces[piece].body != 0 && set->isAnchored
                     : isParted(view, set, wide->term - set->firstTerm)) {
      changeTerm(change, wide->term);
    }
  }
}

/* Long terms, not computed yet, of particles that move. */
static void changeLongTerms(Change* change) {
  Terms* terms = change->evaluation.terms;
  const TrialView* view = change->evaluation.view;
  if (terms->longCount == 0) {
    return;
  }
  beginStamps(terms);
  for (int i = 0; i < terms->changedCount; i++) {
    terms->termTrials[terms->changedTerms[i]] = terms->trial;
  }
  for (int i = 0; i < terms->longCount; i++) {
    const int term = terms->longTerms[i];
    const TermSet* set = &terms->sets[terms->setOf[term]];
    const int* slots = set->slots + (size_t)(term - set->firstTerm) * (size_t)set->width;
    bool moves = false;
    for (int p = 0; p < set->width; p++) {
      moves = moves || trialBody(view, slots[p]) != 0;
    }
    if (moves && terms->termTrials[term] != terms->trial) {
      changeTerm(change, term);
    }
  }
}

/* Sets the bodies of displaced slots, or takes them back. */
static void setBodies(const TrialView* view, bool inTrial, const HeldTerms* held) {
  for (int piece = 0; piece < view->pieceCount; piece++) {
    const int end = pieceEnd(view, piece) < held->slotCount ? pieceEnd(view, piece) : held->slotCount;
    for (int slot = view->pieces[piece].slotBegin; slot < end && view->pieces[piece].body != 0; slot++) {
      held->bodies[slot] = inTrial ? view->pieces[piece].body : 0;
    }
  }
}

/* The terms that hold the particle of a slot, unless they were computed already. */
static void changeTermsOfSlot(Change* change, int slot) {
  Terms* terms = change->evaluation.terms;
  const HeldTerms* held = &terms->held;
  for (size_t i = held->begin[slot]; i < held->begin[slot + 1]; i++) {
    const int term = held->terms[i];
    if (terms->termTrials[term] != terms->trial) {
      terms->termTrials[term] = terms->trial;
      changeTerm(change, term);
    }
  }
}

/* All terms that hold a displaced particle. */
static void changeHeldTerms(Change* change) {
  Terms* terms = change->evaluation.terms;
  const HeldTerms* held = &terms->held;
  const TrialView* view = change->evaluation.view;
  beginStamps(terms);
  setBodies(view, true, held);
  change->evaluation.bodies = held->bodies;
  for (int piece = 0; piece < view->pieceCount; piece++) {
    const int end = pieceEnd(view, piece) < held->slotCount ? pieceEnd(view, piece) : held->slotCount;
    for (int slot = view->pieces[piece].slotBegin; slot < end && view->pieces[piece].body != 0; slot++) {
      changeTermsOfSlot(change, slot);
    }
  }
  setBodies(view, false, held);
}

double ctTermsChange(Terms* terms, const TrialView* view) {
  Change change = {.evaluation = beginEvaluation(terms, view)};
  terms->changedCount = 0;
  if (view->pieceCount > 0 && view->linkCount == 0 && terms->held.begin != NULL) {
    changeHeldTerms(&change);
  } else if (view->pieceCount > 0) {
    changeListedTerms(&change);
    changeSingles(&change);
    changeAcross(&change);
    changeLongTerms(&change);
  }
  return change.sum;
}

void ctTermsAccept(Terms* terms) {
  bool isOutdated = false;
  for (int i = 0; i < terms->changedCount; i++) {
    const int term = terms->changedTerms[i];
    terms->values[term] = terms->newValues[i];
    isOutdated = isOutdated || terms->isLong[term] != terms->newIsLong[i];
    terms->isLong[term] = terms->newIsLong[i];
  }
  terms->changedCount = 0;
  if (isOutdated) {
    listLongTerms(terms);
  }
}

/* ---- Copies ---- */

bool ctTermsSave(Terms* terms) {
  const size_t size = ((size_t)terms->termCount + 1) * sizeof *terms->savedValues;
  if (terms->savedValues == NULL) {
    terms->savedValues = malloc(size);
  }
  if (terms->savedValues == NULL) {
    return false;
  }
  memcpy(terms->savedValues, terms->values, size);
  memcpy(terms->savedIsLong, terms->isLong, (size_t)terms->termCount * sizeof *terms->isLong);
  return true;
}

void ctTermsRestore(Terms* terms) {
  terms->changedCount = 0;
  memcpy(terms->values, terms->savedValues, (size_t)terms->termCount * sizeof *terms->values);
  memcpy(terms->isLong, terms->savedIsLong, (size_t)terms->termCount * sizeof *terms->isLong);
  listLongTerms(terms);
}
