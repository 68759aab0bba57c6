#include "pairset.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"
#include "switching.h"

/* ---- Life ---- */

static void setRange(PairSet* set, const ctPairSet* d) {
  set->cutoff = d->cutoff;
  set->range.hasCutoff = isfinite(d->cutoff);
  set->range.hasSwitch = set->range.hasCutoff && d->switchingDistance < d->cutoff;
  set->switchingDistance = set->range.hasSwitch ? d->switchingDistance : INFINITY;
  set->range.squaredCutoff = squareOfCutoff(d->cutoff);
  if (set->range.hasSwitch) {
    set->range.switchingDistance = (float)d->switchingDistance;
    set->range.inverseSwitchWidth = (float)(1 / (d->cutoff - d->switchingDistance));
  }
}

static bool copyParameters(PairSet* set, const ctPairSet* d, int particleCount, int leafCount, const int* slotOf) {
  const size_t each = (size_t)d->parametersPerParticle;
  const size_t leaves = (size_t)leafCount + 1;
  set->parameters = calloc(leaves * CT_LEAF_WIDTH * each + 1, sizeof *set->parameters);
  set->occupied = calloc(leaves, sizeof *set->occupied);
  if (set->parameters == NULL || set->occupied == NULL) {
    return false;
  }
  for (int i = 0; i < particleCount; i++) {
    if (slotOf[i] != CT_NULL) {
      set->occupied[slotOf[i] / CT_LEAF_WIDTH] |= 1u << slotOf[i] % CT_LEAF_WIDTH;
      if (each > 0) {
        memcpy(set->parameters + (size_t)slotOf[i] * each, d->parameters + (size_t)i * each, each * sizeof(double));
      }
    }
  }
  return true;
}

/* Exclusions of particles that stand in no leaf say nothing. */
static bool createMask(PairSet* set, const ctPairSet* d, int leafCount, const int* slotOf) {
  int(*kept)[2] = malloc(((size_t)d->exclusionCount + 1) * sizeof *kept);
  int count = 0;
  for (int i = 0; kept != NULL && i < d->exclusionCount; i++) {
    const int* pair = d->exclusions[i];
    if (slotOf[pair[0]] != CT_NULL && slotOf[pair[1]] != CT_NULL) {
      kept[count][0] = pair[0];
      kept[count++][1] = pair[1];
    }
  }
  const bool isMade = kept != NULL && ctPairMaskCreate(&set->mask, leafCount, count, (const int(*)[2])kept, slotOf);
  free(kept);
  return isMade;
}

ctStatus ctPairSetCreate(PairSet* set, const ctChainTree* tree, int particleCount, const ctPairSet* description,
                         int number, const int* slotOf, char* errorText, size_t errorSize) {
  const int leafCount = ctGetLeafCount(tree);
  *set = (PairSet){.wide = ctFindWide(ctGetInstructionSet(tree)), .hasGroups = description->groupCount > 0};
  if (!ctPairSetIsValid(description, number, particleCount, slotOf, errorText, errorSize)) {
    return ctInvalidArgument;
  }
  setRange(set, description);
  if (!ctTapeCreate(&set->tape, description, description->parametersPerParticle, particleCount, leafCount, slotOf) ||
      !copyParameters(set, description, particleCount, leafCount, slotOf) ||
      !createMask(set, description, leafCount, slotOf) ||
      (set->hasGroups &&
       !ctPairGroupsCreate(&set->groups, leafCount, description->groupCount, description->groups, slotOf))) {
    ctPairSetFree(set);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  return ctSuccess;
}

void ctPairSetFree(PairSet* set) {
  ctTapeFree(&set->tape);
  free(set->parameters);
  free(set->occupied);
  ctPairMaskFree(&set->mask);
  ctPairGroupsFree(&set->groups);
  *set = (PairSet){0};
}

/* ---- Energies ---- */

/* The energy of a pair of particles in double. */
static double exactPair(const PairSet* set, double squared, int slotA, int slotB) {
  const double distance = sqrt(squared);
  const size_t each = (size_t)set->tape.expression.parametersPerParticle;
  const double energy = ctPairExpressionEvaluate(
      &set->tape.expression, distance, set->parameters + (size_t)slotA * each, set->parameters + (size_t)slotB * each);
  if (!(distance > set->switchingDistance)) {
    return energy;
  }
  const double t = (distance - set->switchingDistance) / (set->cutoff - set->switchingDistance);
  return energy * switchFactor(t);
}

/* The energy of two leaves in double, where single precision does not suffice. */
static double exactEnergy(const PairSet* set, const TapePair* pair, int a, int b) {
  const LeafFrame* frameA = pair->frames[0];
  const LeafFrame* frameB = pair->frames[1];
  double sum = 0;
  for (unsigned rows = pair->occupied[0]; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    unsigned others = pair->occupied[1] & (pair->allowed != NULL ? (unsigned)pair->allowed[k] : ~0u);
    for (; others != 0; others &= others - 1) {
      const int l = __builtin_ctz(others);
      const double x = frameB->centre[0] - frameA->centre[0] + (double)frameB->x[l] - (double)frameA->x[k];
      const double y = frameB->centre[1] - frameA->centre[1] + (double)frameB->y[l] - (double)frameA->y[k];
      const double z = frameB->centre[2] - frameA->centre[2] + (double)frameB->z[l] - (double)frameA->z[k];
      const double squared = x * x + y * y + z * z;
      if (squared < set->cutoff * set->cutoff) {
        const double energy = exactPair(set, squared, a * CT_LEAF_WIDTH + k, b * CT_LEAF_WIDTH + l);
        sum += pair->times != NULL ? pair->times[k][l] * energy : energy;
      }
    }
  }
  return sum;
}

/* Which particles of two leaves count, and how often. */
typedef struct OpenedPair {
  TapePair pair;
  uint16_t allowed[CT_LEAF_WIDTH];
  int times[CT_LEAF_WIDTH][CT_LEAF_WIDTH];
} OpenedPair;

/* False if no pair of particles counts. */
static bool openPair(const PairSet* set, const FramedPair* framed, OpenedPair* opened) {
  const size_t width = (size_t)set->tape.columnCount * CT_LEAF_WIDTH;
  const int a = framed->a;
  const int b = framed->b;
  TapePair* pair = &opened->pair;
  uint16_t* allowed = opened->allowed;
  *pair = (TapePair){.frames = {framed->frames[0], framed->frames[1]},
                     .columns = {set->tape.columns + (size_t)a * width, set->tape.columns + (size_t)b * width},
                     .occupied = {set->occupied[a], set->occupied[b]}};
  if (set->hasGroups) {
    const GroupedPairs found = ctFindGroupedPairs(&set->groups, a, b, allowed, opened->times);
    if (found == NO_PAIR_COUNTS) {
      return false;
    }
    pair->allowed = allowed;
    pair->times = found == PAIRS_COUNT_OFTEN ? opened->times : NULL;
  }
  const uint16_t* excluded = framed->isImage ? pairMaskOfImage(&set->mask, a, b) : pairMaskOf(&set->mask, a, b);
  for (int k = 0; excluded != NULL && k < CT_LEAF_WIDTH; k++) {
    allowed[k] = (uint16_t)((set->hasGroups ? allowed[k] : ~0u) & ~(unsigned)excluded[k]);
    pair->allowed = allowed;
  }
  return true;
}

void ctPairSetEnergies(const void* model, int count, const FramedPair* pairs, double* energies) {
  const PairSet* set = model;
  const Tape* tape = &set->tape;
  OpenedPair opened;
  for (int i = 0; i < count; i++) {
    energies[i] = 0;
    if (openPair(set, &pairs[i], &opened)) {
      if (tape->isExact) {
        energies[i] = NAN;
        continue;
      }
      set->wide->addToBatch(tape, &opened.pair, &set->range, i, energies);
    }
  }
  set->wide->finishBatch(tape, &set->range, energies);
  for (int i = 0; i < count; i++) {
    if (!isfinite(energies[i]) && openPair(set, &pairs[i], &opened)) {
      energies[i] = exactEnergy(set, &opened.pair, pairs[i].a, pairs[i].b);
    }
  }
}
