#include "pairset.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pairsetchecks.h"
#include "switching.h"

/* ---- Life ---- */

static void setRange(PairSet* set, const ctPairSet* d) {
  set->cutoff = d->cutoff;
  set->range.hasCutoff = isfinite(d->cutoff);
  set->range.hasSwitch = set->range.hasCutoff && d->switchingDistance < d->cutoff;
  set->switchingDistance = set->range.hasSwitch ? d->switchingDistance : INFINITY;
  set->range.squaredCutoff = set->range.hasCutoff ? (float)(d->cutoff * d->cutoff) : NOWHERE * NOWHERE / 100;
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
  *set = (PairSet){.kernels = ctFindTapeKernels(ctGetInstructionSet(tree)), .hasGroups = description->groupCount > 0};
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

/* Coordinates of the particles of a leaf. */
typedef struct LeafCoordinates {
  double x[3][CT_LEAF_WIDTH];
} LeafCoordinates;

/* The energy of two leaves in double, where single precision does not suffice. */
static double exactEnergy(const PairSet* set, const TapePair* pair, int a, int b, const LeafCoordinates* ofA,
                          const LeafCoordinates* ofB) {
  double sum = 0;
  for (unsigned rows = pair->occupied[0]; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    unsigned others = pair->occupied[1] & (pair->allowed != NULL ? (unsigned)pair->allowed[k] : ~0u);
    for (; others != 0; others &= others - 1) {
      const int l = __builtin_ctz(others);
      double squared = 0;
      for (int d = 0; d < 3; d++) {
        const double along = ofB->x[d][l] - ofA->x[d][k];
        squared += along * along;
      }
      if (squared < set->cutoff * set->cutoff) {
        const double energy = exactPair(set, squared, a * CT_LEAF_WIDTH + k, b * CT_LEAF_WIDTH + l);
        sum += pair->times != NULL ? pair->times[k][l] * energy : energy;
      }
    }
  }
  return sum;
}

/* Those of a frame, from some point. */
static LeafCoordinates fromPoint(const LeafFrame* frame, const double point[3]) {
  LeafCoordinates coordinates;
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    coordinates.x[0][k] = frame->centre[0] - point[0] + (double)frame->x[k];
    coordinates.x[1][k] = frame->centre[1] - point[1] + (double)frame->y[k];
    coordinates.x[2][k] = frame->centre[2] - point[2] + (double)frame->z[k];
  }
  return coordinates;
}

/* Which particles of two leaves count, and how often. */
typedef struct OpenedPair {
  TapePair pair;
  uint16_t allowed[CT_LEAF_WIDTH];
  int times[CT_LEAF_WIDTH][CT_LEAF_WIDTH];
} OpenedPair;

/* False if no pair of particles counts. */
static bool openPair(const PairSet* set, int a, int b, OpenedPair* opened) {
  const size_t width = (size_t)set->tape.columnCount * CT_LEAF_WIDTH;
  TapePair* pair = &opened->pair;
  uint16_t* allowed = opened->allowed;
  *pair = (TapePair){.columns = {set->tape.columns + (size_t)a * width, set->tape.columns + (size_t)b * width},
                     .occupied = {set->occupied[a], set->occupied[b]}};
  if (set->hasGroups) {
    const GroupedPairs found = ctFindGroupedPairs(&set->groups, a, b, allowed, opened->times);
    if (found == NO_PAIR_COUNTS) {
      return false;
    }
    pair->allowed = allowed;
    pair->times = found == PAIRS_COUNT_OFTEN ? opened->times : NULL;
  }
  const uint16_t* excluded = pairMaskOf(&set->mask, a, b);
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
    if (openPair(set, pairs[i].a, pairs[i].b, &opened)) {
      opened.pair.frames[0] = pairs[i].frames[0];
      opened.pair.frames[1] = pairs[i].frames[1];
      if (tape->isExact) {
        energies[i] = NAN;
        continue;
      }
      set->kernels->add(tape, &opened.pair, &set->range, i);
      if (tape->batch->count > MOST_SIXTEENS - CT_LEAF_WIDTH) {
        set->kernels->finish(tape, &set->range, energies);
      }
    }
  }
  set->kernels->finish(tape, &set->range, energies);
  for (int i = 0; i < count; i++) {
    if (!isfinite(energies[i]) && openPair(set, pairs[i].a, pairs[i].b, &opened)) {
      const double* point = pairs[i].frames[0]->centre;
      const LeafCoordinates ofA = fromPoint(pairs[i].frames[0], point);
      const LeafCoordinates ofB = fromPoint(pairs[i].frames[1], point);
      energies[i] = exactEnergy(set, &opened.pair, pairs[i].a, pairs[i].b, &ofA, &ofB);
    }
  }
}

/* ---- On the grid ---- */

/* Of two leaves of which one at least is wide, which pairs may be within the cutoff: the grid does not tell. */
static void allowNear(const LeafGrid* a, const LeafGrid* b, OpenedPair* opened) {
  const ctLeafPositions* p = a->positions;
  const ctLeafPositions* q = b->positions;
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    unsigned near = 0;
    for (int l = 0; l < CT_LEAF_WIDTH; l++) {
      const bool isNear = fabs(q->x[l] - p->x[k]) < 2 * MOST_GRID_CUTOFF &&
                          fabs(q->y[l] - p->y[k]) < 2 * MOST_GRID_CUTOFF &&
                          fabs(q->z[l] - p->z[k]) < 2 * MOST_GRID_CUTOFF;
      near |= isNear ? 1u << l : 0;
    }
    opened->allowed[k] = (uint16_t)(near & (opened->pair.allowed != NULL ? opened->allowed[k] : ~0u));
  }
  opened->pair.allowed = opened->allowed;
}

void ctPairSetAddOnGrid(const PairSet* set, const LeafOnGrid* rowSide, const LeafOnGrid* columnSide, unsigned rows,
                        bool isSwapped, GridSum* sum) {
  const size_t width = (size_t)set->tape.columnCount * CT_LEAF_WIDTH;
  const int a = rowSide->leaf;
  const int b = columnSide->leaf;
  const bool isWide = rowSide->grid->isWide || columnSide->grid->isWide;
  OpenedPair opened;
  GridPair pair = {.grids = {rowSide->grid, columnSide->grid},
                   .columns = {set->tape.columns + (size_t)a * width, set->tape.columns + (size_t)b * width},
                   .sections = {rowSide->sections, columnSide->sections},
                   .rows = rows & set->occupied[a],
                   .occupied = set->occupied[b],
                   .isSwapped = isSwapped};
  if (isWide || set->hasGroups || pairMaskOf(&set->mask, a, b) != NULL) {
    pair.rows = openPair(set, a, b, &opened) ? pair.rows : 0;
    if (isWide) {
      allowNear(rowSide->grid, columnSide->grid, &opened);
    }
    pair.allowed = opened.pair.allowed;
    pair.times = opened.pair.times;
  }
  if (rows == 0xffff && !isWide) {
    pair.rows = set->kernels->rowsOnGrid(&pair, &set->range);
  }
  set->kernels->addOnGrid(&set->tape, &pair, &set->range, sum);
}

/* In the world, on the grid; no coordinate is 32 nm off. */
static LeafCoordinates fromGrid(const LeafGrid* grid) {
  LeafCoordinates coordinates;
  const ctLeafPositions* own = grid->positions;
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    coordinates.x[0][k] = rint(own->x[k] * GRID_STEPS) / GRID_STEPS;
    coordinates.x[1][k] = rint(own->y[k] * GRID_STEPS) / GRID_STEPS;
    coordinates.x[2][k] = rint(own->z[k] * GRID_STEPS) / GRID_STEPS;
  }
  return coordinates;
}

double ctPairSetExactOnGrid(const PairSet* set, int a, int b, const LeafGrid* gridA, const LeafGrid* gridB) {
  OpenedPair opened;
  if (!openPair(set, a, b, &opened)) {
    return 0;
  }
  const LeafCoordinates ofA = fromGrid(gridA);
  const LeafCoordinates ofB = fromGrid(gridB);
  return exactEnergy(set, &opened.pair, a, b, &ofA, &ofB);
}
