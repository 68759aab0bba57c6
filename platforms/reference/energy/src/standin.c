#include "standin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "imageframe.h"

/* ---- Life ---- */

static void setModel(StandInModel* model, const ctEnergyDefinition* d) {
  model->hasKappa = d->born->kappa != 0;
  model->isRescaled = d->born->isRescaled;
  model->squaredCutoff = (float)(d->standIn->pairCutoff * d->standIn->pairCutoff);
  model->squaredBornCutoff = (float)(d->standIn->bornCutoff * d->standIn->bornCutoff);
  model->perDielectrics[0] = (float)(1 / d->born->soluteDielectric);
  model->perDielectrics[1] = (float)(1 / d->born->solventDielectric);
  model->kappa = (float)d->born->kappa;
  model->kappaOfTwo = (float)(d->born->kappa * 1.44269504088896341);
  ctStandInFitShift(model, d);
}

static float squaredReach(float squaredCutoff, float displacement) {
  const float reach = sqrtf(squaredCutoff) + displacement;
  return (displacement > 0 ? reach * reach : squaredCutoff) * ROUNDING_OF_BOXES;
}

StandInReach ctStandInReach(const StandInModel* model, float displacement) {
  return (StandInReach){squaredReach(model->squaredCutoff, displacement),
                        squaredReach(model->squaredBornCutoff, displacement),
                        squaredReach(model->squaredOverlap, displacement)};
}

double ctStandInGridFactor(double charge) {
  const double factor = pow(fabs(charge) / STANDIN_GRID_CHARGE, STANDIN_GRID_POWER);
  return fmin(factor, STANDIN_WIDEST_GRID); /* infinite without a charge */
}

static void setConstants(StandIn* standIn, const ctBorn* d, double gridWidth) {
  for (int leaf = 0; leaf < standIn->leaves->leafCount; leaf++) {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      standIn->constants[leaf].offsetRadius[k] = 1;
      standIn->constants[leaf].perOffsetRadius[k] = 1;
      standIn->constants[leaf].perRadius[k] = 1;
      standIn->constants[leaf].gridWidth[k] = 1;
      standIn->constants[leaf].perGridWidth[k] = 1;
    }
  }
  for (int i = 0; i < standIn->particleCount; i++) {
    StandInConstants* c = &standIn->constants[standIn->slots[i] / CT_LEAF_WIDTH];
    const int k = standIn->slots[i] % CT_LEAF_WIDTH;
    c->offsetRadius[k] = (float)d->offsetRadii[i];
    c->perOffsetRadius[k] = (float)(1 / d->offsetRadii[i]);
    c->perRadius[k] = (float)(1 / d->radii[i]);
    if (d->isRescaled) {
      c->alpha[k] = (float)d->alphas[i];
      c->beta[k] = (float)d->betas[i];
      c->gamma[k] = (float)d->gammas[i];
    }
    c->squaredCharge[k] = (float)(0.5 * d->coulomb * d->charges[i] * d->charges[i]);
    c->gridWidth[k] = (float)(gridWidth * ctStandInGridFactor(d->charges[i]));
    c->perGridWidth[k] = 1 / c->gridWidth[k];
    c->surface[k] = (float)(d->surfaceEnergy * pow(d->radii[i] + d->probeRadius, 2) * pow(d->radii[i], 6));
  }
}

/* Inverse powers of less would be too large for floats. */
#define LEAST_CUTOFF 1e-3

static bool isCutoff(double cutoff) {
  return cutoff >= LEAST_CUTOFF && cutoff <= CT_MOST_LENGTH;
}

/* Writes what is wrong with a description; false if nothing is. */
static bool isWrong(const ctStandIn* d, char* errorText, size_t errorSize) {
  if (!isCutoff(d->bornCutoff) || !isCutoff(d->pairCutoff)) {
    return snprintf(errorText, errorSize,
                    "the cutoffs of the stand-in are %g and %g nm, but have to be above 0: from 1e-3 to 1e15",
                    d->bornCutoff, d->pairCutoff) > 0;
  }
  if (!(d->gridWidth >= 1e-4 && d->gridWidth <= 1)) {
    return snprintf(errorText, errorSize, "the grid width of the stand-in is %g, but has to be from 1e-4 to 1",
                    d->gridWidth) > 0;
  }
  return false;
}

static bool allocate(StandIn* standIn, const int* slotOf) {
  const size_t leaves = (size_t)standIn->leaves->leafCount + 1;
  const size_t particles = (size_t)standIn->particleCount;
  standIn->slots = malloc((particles + 1) * sizeof *standIn->slots);
  if (standIn->slots != NULL && particles > 0) {
    memcpy(standIn->slots, slotOf, particles * sizeof *slotOf);
  }
  standIn->constants = calloc(leaves, sizeof *standIn->constants);
  standIn->leafSums = calloc(leaves, sizeof *standIn->leafSums);
  standIn->shifts = calloc(leaves, sizeof *standIn->shifts);
  standIn->present = calloc(2 * leaves, sizeof *standIn->present);
  standIn->presentShift = standIn->present != NULL ? standIn->present + leaves : NULL;
  standIn->trial = calloc(leaves, sizeof *standIn->trial);
  standIn->touched = calloc(leaves, sizeof *standIn->touched);
  return standIn->slots != NULL && standIn->constants != NULL && standIn->leafSums != NULL && standIn->shifts != NULL &&
         standIn->present != NULL && standIn->trial != NULL && standIn->touched != NULL &&
         ctNeighborsCreate(&standIn->neighbors, standIn->leaves->leafCount);
}

ctStatus ctStandInCreate(StandIn* standIn, TrialLeaves* leaves, int particleCount, const ctEnergyDefinition* d,
                         const int* slotOf, char* errorText, size_t errorSize) {
  *standIn = (StandIn){.leaves = leaves, .particleCount = particleCount};
  if (isWrong(d->standIn, errorText, errorSize)) {
    return ctInvalidArgument;
  }
  ctStatus status =
      ctNonbondedCreate(&standIn->nonbonded, leaves->tree, particleCount, d->nonbonded, slotOf, errorText, errorSize);
  if (status == ctSuccess) {
    status = ctBornCreate(&standIn->born, leaves->leafCount, particleCount, d->born, slotOf, errorText, errorSize);
  }
  if (status == ctSuccess && !allocate(standIn, slotOf)) {
    snprintf(errorText, errorSize, "out of memory");
    status = ctOutOfMemory;
  }
  if (status != ctSuccess) {
    ctStandInFree(standIn);
    return status;
  }
  standIn->bornCutoff = d->standIn->bornCutoff;
  standIn->pairCutoff = d->standIn->pairCutoff;
  setModel(&standIn->model, d);
  standIn->model.squaredOverlap = standIn->born.model.squaredNear;
  standIn->reach = ctStandInReach(&standIn->model, 0);
  setConstants(standIn, d->born, d->standIn->gridWidth);
  return ctSuccess;
}

void ctStandInFree(StandIn* standIn) {
  ctNonbondedFree(&standIn->nonbonded);
  ctBornFree(&standIn->born);
  ctNeighborsFree(&standIn->neighbors);
  ctNeighborsFree(&standIn->savedNeighbors);
  free(standIn->savedSums);
  free(standIn->savedShifts);
  free(standIn->savedPresent);
  free(standIn->slots);
  free(standIn->constants);
  free(standIn->leafSums);
  free(standIn->shifts);
  free(standIn->present);
  free(standIn->trial);
  free(standIn->touched);
  freeLines(standIn->staged);
  *standIn = (StandIn){0};
}

/* ---- Pairs and radii ---- */

void ctStandInComputeBorn(const StandIn* standIn, int a, const LeafFrame* frameA, int b, const LeafFrame* frameB,
                          const NearRows* rows, PairRecord* record) {
  const Born* born = &standIn->born;
  const BornSide sideA = {frameA, &born->columns[a], born->columns[a].occupied, a};
  const BornSide sideB = {frameB, &born->columns[b], born->columns[b].occupied, b};
  record->hasBorn = hasBorn(rows);
  record->moves = 0;
  if (record->hasBorn) {
    standIn->leaves->wide->standInBorn(&born->model, &standIn->model, &sideA, &sideB, rows, record->born[0],
                                       record->born[1]);
  }
}

void ctStandInMoveBorn(const StandIn* standIn, int a, int b, const PairFrames frames[2], const NearRows* movers,
                       PairRecord* record) {
  const Born* born = &standIn->born;
  BornSide sideA[2];
  BornSide sideB[2];
  for (int version = 0; version < 2; version++) {
    sideA[version] = (BornSide){frames[version].a, &born->columns[a], born->columns[a].occupied, a};
    sideB[version] = (BornSide){frames[version].b, &born->columns[b], born->columns[b].occupied, b};
  }
  standIn->leaves->wide->standInBornMove(&born->model, &standIn->model, sideA, sideB, movers, record->born[0],
                                         record->born[1]);
}

/* Sets a leaf in a pair with another. Written in place: a copy would wait for the stores. */
static void setSide(const StandIn* standIn, const PlacedLeaf* placed, const PlacedLeaf* other, StandInSide* side) {
  const PairMask* mask = &standIn->nonbonded.mask;
  const int leaf = placed->leaf;
  const bool isSelf = placed->frame == other->frame; /* and not an image */
  side->frame = placed->frame;
  side->columns = &standIn->nonbonded.columns[leaf];
  side->charge = standIn->born.columns[leaf].charge;
  side->radii = placed->radii;
  side->shift = placed->shift;
  side->excluded = isSelf ? pairMaskOf(mask, leaf, leaf) : pairMaskOfImage(mask, leaf, other->leaf);
}

/* Sets a leaf that differs from another version of it by its place or its radii. */
static void setVersion(const StandInSide* version, const LeafFrame* frame, const StandInRadii* radii,
                       const StandInShift* shift, StandInSide* side) {
  side->frame = frame;
  side->columns = version->columns;
  side->charge = version->charge;
  side->radii = radii;
  side->shift = shift;
  side->excluded = version->excluded;
}

void ctStandInComputePairs(const StandIn* standIn, const PlacedLeaf* a, const PlacedLeaf* b, const NearRows* rows,
                           PairRecord* record) {
  record->energy = 0;
  record->hasPairs = hasPairs(rows);
  if (record->hasPairs) {
    StandInSide sideA;
    StandInSide sideB;
    setSide(standIn, a, b, &sideA);
    setSide(standIn, b, a, &sideB);
    memset(record->gradient, 0, sizeof record->gradient);
    record->energy = standIn->leaves->wide->standInPairs(&standIn->model, &sideA, &sideB, rows, record->gradient[0],
                                                         record->gradient[1]);
  }
}

void ctStandInMovePairs(const StandIn* standIn, int a, int b, const PairFrames frames[2], const NearRows* movers,
                        PairRecord* record) {
  const PlacedLeaf placedA = ctStandInPlace(standIn, a, frames->a);
  const PlacedLeaf placedB = ctStandInPlace(standIn, b, frames->b);
  StandInSide sideA[2];
  StandInSide sideB[2];
  setSide(standIn, &placedA, &placedB, sideA);
  setSide(standIn, &placedB, &placedA, sideB);
  if (a == b) { /* pairs in either order count, once */
    sideA->excluded = sideB->excluded = standIn->nonbonded.mask.ofOwnImage[a];
  }
  setVersion(sideA, frames[1].a, placedA.radii, placedA.shift, &sideA[1]);
  setVersion(sideB, frames[1].b, placedB.radii, placedB.shift, &sideB[1]);
  record->energy += standIn->leaves->wide->standInMove(&standIn->model, sideA, sideB, movers, record->gradient[0],
                                                       record->gradient[1]);
}

/* With this many particles, all pairs of two leaves cost less than their pairs twice. */
enum { MOST_EXCHANGED = 4 };

void ctStandInExchangePairs(const StandIn* standIn, const PlacedLeaf* a, unsigned slotsOfA, const PlacedLeaf* b,
                            unsigned slotsOfB, PairRecord* record) {
  if (!record->hasPairs) {
    return;
  }
  NearRows rows;
  if (a->leaf == b->leaf || __builtin_popcount(slotsOfA) + __builtin_popcount(slotsOfB) > MOST_EXCHANGED) {
    standIn->leaves->wide->nearRows(&standIn->model, a->frame, b->frame, &rows);
    ctStandInComputePairs(standIn, a, b, &rows, record);
    return;
  }
  standIn->leaves->wide->nearSome(&standIn->reach, a->frame, b->frame, slotsOfA, slotsOfB, &rows);
  StandInSide sideA[2];
  StandInSide sideB[2];
  setSide(standIn, a, b, sideA);
  setSide(standIn, b, a, sideB);
  setVersion(sideA, a->frame, &stateLeaf(standIn, a->leaf)->radii, stateShift(standIn, a->leaf), &sideA[1]);
  setVersion(sideB, b->frame, &stateLeaf(standIn, b->leaf)->radii, stateShift(standIn, b->leaf), &sideB[1]);
  record->energy += standIn->leaves->wide->standInExchange(&standIn->model, sideA, sideB, &rows, slotsOfA, slotsOfB,
                                                           record->gradient[0], record->gradient[1]);
}

void ctStandInComputeRadii(const StandIn* standIn, int number, StandInLeaf* leaf) {
  standIn->leaves->wide->standInRadii(&standIn->model, &standIn->constants[number], leaf->born, &leaf->radii);
}

/* ---- The state ---- */

PlacedLeaf ctStandInPlace(const StandIn* standIn, int leaf, const LeafFrame* frame) {
  return (PlacedLeaf){leaf, frame, &stateLeaf(standIn, leaf)->radii, stateShift(standIn, leaf)};
}

static void addAll(double* sums, const float* parts) {
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] += (double)parts[k];
  }
}

void ctStandInFindFrames(const StandIn* standIn, int a, int b, const int image[3], bool inTrial, PairFrames* frames) {
  TrialLeaves* leaves = standIn->leaves;
  frames->a = inTrial ? ctTrialFrame(leaves, a) : ctStateFrame(leaves, a);
  frames->b = inTrial ? ctTrialFrame(leaves, b) : ctStateFrame(leaves, b);
  if (leaves->isPeriodic && isShifted(image)) {
    shiftFrame(frames->a, (const double(*)[3])leaves->box, image, &frames->shifted);
    frames->a = &frames->shifted;
  }
}

/* Finds the frames of two leaves in the state, and which of their particles are near. */
static NearRows rowsInState(const StandIn* standIn, int a, int b, const int image[3], PairFrames* frames) {
  NearRows rows;
  ctStandInFindFrames(standIn, a, b, image, false, frames);
  standIn->leaves->wide->nearRows(&standIn->model, frames->a, frames->b, &rows);
  return rows;
}

/* Makes pairs of leaves neighbours, with the Born sums that they contribute. */
static ctStatus findNeighbors(StandIn* standIn, size_t count, const ctLeafPair* near) {
  for (size_t i = 0; i < count; i++) {
    const int a = near[i].a;
    const int b = near[i].b;
    PairFrames frames;
    const NearRows rows = rowsInState(standIn, a, b, near[i].image, &frames);
    if (!hasPairs(&rows) && !hasBorn(&rows)) {
      continue;
    }
    const int pair = ctNeighborsReserve(&standIn->neighbors, near[i].image);
    if (pair == CT_NULL || !ctNeighborsAdd(&standIn->neighbors, a, b, pair)) {
      return ctOutOfMemory;
    }
    PairRecord* record = &standIn->neighbors.records[pair];
    ctStandInComputeBorn(standIn, a, frames.a, b, frames.b, &rows, record);
    addAll(stateLeaf(standIn, a)->born, bornOf(record, 0));
    addAll(stateLeaf(standIn, b)->born, bornOf(record, 1));
  }
  return ctSuccess;
}

ctStatus ctStandInRefresh(StandIn* standIn, size_t count, const ctLeafPair* near) {
  const Wide* wide = standIn->leaves->wide;
  rejectTrial(standIn);
  ctNeighborsClear(&standIn->neighbors, standIn->leaves->isPeriodic);
  memset(standIn->leafSums, 0, (size_t)standIn->leaves->leafCount * sizeof *standIn->leafSums);
  if (findNeighbors(standIn, count, near) != ctSuccess) {
    return ctOutOfMemory;
  }
  for (int leaf = 0; leaf < standIn->leaves->leafCount; leaf++) {
    ctStandInComputeRadii(standIn, leaf, stateLeaf(standIn, leaf));
    wide->standInShift(&standIn->model, standIn->born.columns[leaf].charge, &stateLeaf(standIn, leaf)->radii,
                       stateShift(standIn, leaf));
  }
  for (int a = 0; a < standIn->leaves->leafCount; a++) {
    const NeighborRow* row = &standIn->neighbors.rows[a];
    for (int i = 0; i < row->count; i++) {
      const int b = row->leaves[i];
      if (b >= a) {
        PairRecord* record = &standIn->neighbors.records[row->pairs[i]];
        PairFrames frames;
        const NearRows rows = rowsInState(standIn, a, b, record->image, &frames);
        const PlacedLeaf placedA = ctStandInPlace(standIn, a, frames.a);
        const PlacedLeaf placedB = ctStandInPlace(standIn, b, frames.b);
        ctStandInComputePairs(standIn, &placedA, &placedB, &rows, record);
        addAll(stateLeaf(standIn, a)->gradient, gradientOf(record, 0));
        addAll(stateLeaf(standIn, b)->gradient, gradientOf(record, 1));
      }
    }
  }
  for (int leaf = 0; leaf < standIn->leaves->leafCount; leaf++) {
    StandInLeaf* state = stateLeaf(standIn, leaf);
    state->energy = wide->standInLeafEnergy(&state->radii, state->gradient);
  }
  return ctSuccess;
}

void ctStandInGetFar(const StandIn* standIn, double* far) {
  for (int i = 0; i < standIn->particleCount; i++) {
    far[i] = standIn->constants[standIn->slots[i] / CT_LEAF_WIDTH].far[standIn->slots[i] % CT_LEAF_WIDTH];
  }
}

void ctStandInSetFar(StandIn* standIn, const double* far) {
  for (int i = 0; i < standIn->particleCount; i++) {
    standIn->constants[standIn->slots[i] / CT_LEAF_WIDTH].far[standIn->slots[i] % CT_LEAF_WIDTH] = far[i];
  }
}

void ctStandInGetNear(const StandIn* standIn, double* near) {
  for (int i = 0; i < standIn->particleCount; i++) {
    near[i] = stateLeaf(standIn, standIn->slots[i] / CT_LEAF_WIDTH)->born[standIn->slots[i] % CT_LEAF_WIDTH];
  }
}

double ctStandInEnergy(const StandIn* standIn) {
  double total = 0;
  for (int a = 0; a < standIn->leaves->leafCount; a++) {
    const NeighborRow* row = &standIn->neighbors.rows[a];
    double ofRow = stateLeaf(standIn, a)->energy;
    for (int i = 0; i < row->count; i++) {
      ofRow += row->leaves[i] >= a ? standIn->neighbors.records[row->pairs[i]].energy : 0;
    }
    total += ofRow;
  }
  return total;
}

/* ---- Copies ---- */

bool ctStandInSave(StandIn* standIn) {
  const size_t leaves = (size_t)standIn->leaves->leafCount;
  standIn->hasSaved = false;
  if (standIn->savedPresent == NULL) {
    standIn->savedSums = malloc((leaves + 1) * sizeof *standIn->savedSums);
    standIn->savedShifts = malloc((leaves + 1) * sizeof *standIn->savedShifts);
    standIn->savedPresent = malloc(2 * (leaves + 1));
    if (standIn->savedSums == NULL || standIn->savedShifts == NULL || standIn->savedPresent == NULL ||
        !ctNeighborsCreate(&standIn->savedNeighbors, (int)leaves)) {
      free(standIn->savedSums);
      free(standIn->savedShifts);
      free(standIn->savedPresent);
      standIn->savedSums = NULL;
      standIn->savedShifts = NULL;
      standIn->savedPresent = NULL;
      return false;
    }
  }
  if (!ctNeighborsCopy(&standIn->savedNeighbors, &standIn->neighbors)) {
    return false;
  }
  memcpy(standIn->savedSums, standIn->leafSums, leaves * sizeof *standIn->leafSums);
  memcpy(standIn->savedShifts, standIn->shifts, leaves * sizeof *standIn->shifts);
  memcpy(standIn->savedPresent, standIn->present, 2 * (leaves + 1));
  /* Indices of new pairs belong to the trial, which the copy does not include. */
  for (int i = 0; i < standIn->movedCount; i++) {
    if (standIn->staged[i].isNew) {
      ctNeighborsRelease(&standIn->savedNeighbors, standIn->staged[i].pair);
    }
  }
  standIn->hasSaved = true;
  return true;
}

bool ctStandInRestore(StandIn* standIn) {
  const size_t leaves = (size_t)standIn->leaves->leafCount;
  if (!standIn->hasSaved || !ctNeighborsCopy(&standIn->neighbors, &standIn->savedNeighbors)) {
    return false;
  }
  memcpy(standIn->leafSums, standIn->savedSums, leaves * sizeof *standIn->leafSums);
  memcpy(standIn->shifts, standIn->savedShifts, leaves * sizeof *standIn->shifts);
  memcpy(standIn->present, standIn->savedPresent, 2 * (leaves + 1));
  rejectTrial(standIn);
  return true;
}
