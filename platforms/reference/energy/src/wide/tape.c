/* Runs a tape on the pairs of particles of leaves. */
#include <math.h>

#include "ints.h"
#include "rows.h"
#include "set.h"
#include "sums.h"
#include "switching16.h"
#include "tapesteps.h"

/* ---- Pairs ---- */

/* Lists those of some rows that count behind those of the batch; returns how many. The second leaf is shifted. */
CT_INLINE int listPairs(const TapePair* pair, const TapeRange* range, unsigned rows, const float shift[3],
                        float* squares, int* places) {
  const LeafFrame* a = pair->frames[0];
  const LeafFrame* b = pair->frames[1];
  const Float16 xb = add16(load16(b->x), all16(shift[0]));
  const Float16 yb = add16(load16(b->y), all16(shift[1]));
  const Float16 zb = add16(load16(b->z), all16(shift[2]));
  /* Read once, not for each row: what is written might be these. */
  const Float16 squaredCutoff = all16(range->squaredCutoff);
  const unsigned occupied = pair->occupied[1];
  const uint16_t* allowed = pair->allowed;
  int count = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const Float16 dx = sub16(xb, all16(a->x[k]));
    const Float16 dy = sub16(yb, all16(a->y[k]));
    const Float16 dz = sub16(zb, all16(a->z[k]));
    const Float16 squared = squared16(dx, dy, dz);
    unsigned mask = occupied & greater16(squaredCutoff, squared);
    if (allowed != NULL) {
      mask &= allowed[k];
    }
    count += pack16(mask, squared, CT_LEAF_WIDTH * k, squares + count, places + count);
  }
  /* What fills the last sixteen has to be as harmless as the others. */
  store16(squares + count, all16(squares[0]));
  storeInts16(places + count, allInts16(places[0]));
  return count;
}

static int rowOf(int place) {
  return place / CT_LEAF_WIDTH;
}

static void emptyBatch(TapeBatch* batch) {
  batch->count = 0;
  batch->partCount = 0;
}

/* ---- Sums ---- */

/* Sixteen pairs each that are summed in single precision before they are added in double. */
enum { SUMMED_IN_FLOAT = 4 };

/* The weighted energies of sixteen pairs. */
static Float16 weightedEnergy(const Tape* tape, const TapeRange* range, const TapePart* part, int v, Float16 value) {
  if (range->hasSwitch) {
    const Float16 distance = sqrt16(load16(tape->scratch + tape->squaredBegin + v * CT_LEAF_WIDTH));
    value = mul16(value, switchFactor16(distance, range->switchingDistance, range->inverseSwitchWidth));
  }
  return part->hasTimes ? mul16(value, load16(tape->batch->times + v * CT_LEAF_WIDTH)) : value;
}

static double energyOfPart(const Tape* tape, const TapeRange* range, const TapePart* part) {
  const float* values = tape->scratch + tape->result.begin;
  const int step = tape->result.step;
  const bool isWeighted = range->hasSwitch || part->hasTimes;
  const int last = part->begin + (part->pairCount - 1) / CT_LEAF_WIDTH;
  const int inLast = part->pairCount - (last - part->begin) * CT_LEAF_WIDTH;
  Sum16 sum = zeroSum16();
  Float16 few = all16(0);
  for (int v = part->begin; v < last; v++) {
    const Float16 value = load16(values + v * step);
    few = add16(few, isWeighted ? weightedEnergy(tape, range, part, v, value) : value);
    if ((v - part->begin) % SUMMED_IN_FLOAT == SUMMED_IN_FLOAT - 1) {
      sum = addToSum16(sum, few);
      few = all16(0);
    }
  }
  Float16 value = load16(values + last * step);
  if (isWeighted) {
    value = weightedEnergy(tape, range, part, last, value);
  }
  return total16(addToSum16(sum, add16(few, keep16((2u << (inLast - 1)) - 1, value))));
}

void CT_WIDE(finishBatch)(const Tape* tape, const TapeRange* range, double* energies) {
  CT_WIDE(runSteps)(tape);
  for (int i = 0; i < tape->batch->partCount; i++) {
    const TapePart* part = &tape->batch->parts[i];
    energies[part->number] = energyOfPart(tape, range, part);
  }
  emptyBatch(tape->batch);
}

bool CT_WIDE(addToBatch)(const Tape* tape, const TapePair* pair, const TapeRange* range, int number, double* energies) {
  TapeBatch* batch = tape->batch;
  float shift[3];
  shiftBetween(pair->frames[0], pair->frames[1], shift);
  unsigned rows = pair->occupied[0];
  if (range->hasCutoff) {
    rows &= rowsNear(pair->frames[0], pair->frames[1], shift, range->squaredCutoff);
  }
  if (rows == 0) {
    return false;
  }
  if (batch->count + __builtin_popcount(rows) > MOST_SIXTEENS) {
    CT_WIDE(finishBatch)(tape, range, energies);
  }
  /* The steps read them later. */
  for (int i = 0; i < tape->columnCount; i++) {
    __builtin_prefetch(pair->columns[0] + i * CT_LEAF_WIDTH);
    __builtin_prefetch(pair->columns[1] + i * CT_LEAF_WIDTH);
  }
  const int begin = batch->count * CT_LEAF_WIDTH;
  int* places = batch->places + begin;
  const int count = listPairs(pair, range, rows, shift, tape->scratch + tape->squaredBegin + begin, places);
  if (count == 0) {
    return false;
  }
  batch->parts[batch->partCount++] = (TapePart){number, batch->count, count, pair->times != NULL};
  const int sixteens = (count + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH;
  /* For the largest possible count: counting would cost more than writing. */
  for (int v = 0; v < CT_LEAF_WIDTH; v++) {
    batch->columns[0][batch->count + v] = pair->columns[0];
    batch->columns[1][batch->count + v] = pair->columns[1];
  }
  batch->count += sixteens;
  for (int i = 0; pair->times != NULL && i < sixteens * CT_LEAF_WIDTH; i++) {
    batch->times[begin + i] = (float)pair->times[rowOf(places[i])][places[i] % CT_LEAF_WIDTH];
  }
  return true;
}

double CT_WIDE(tapeEnergy)(const Tape* tape, const TapePair* pair, const TapeRange* range) {
  double sum = 0;
  if (CT_WIDE(addToBatch)(tape, pair, range, 0, &sum)) {
    CT_WIDE(finishBatch)(tape, range, &sum);
  }
  return sum;
}

bool CT_WIDE(addTapeRows)(const Tape* tape, const TapePair* pair, const TapeRange* range, double sums[CT_LEAF_WIDTH]) {
  TapeBatch* batch = tape->batch;
  double ofRows[CT_LEAF_WIDTH] = {0};
  double none;
  if (!CT_WIDE(addToBatch)(tape, pair, range, 0, &none)) {
    return true;
  }
  CT_WIDE(runSteps)(tape);
  for (int v = 0; v < batch->count; v++) {
    const int begin = v * CT_LEAF_WIDTH;
    const int left = batch->parts[0].pairCount - begin;
    const int* places = batch->places + begin;
    const float* values = tape->scratch + tape->result.begin + v * tape->result.step;
    if (left >= CT_LEAF_WIDTH && rowOf(places[0]) == rowOf(places[CT_LEAF_WIDTH - 1])) {
      ofRows[rowOf(places[0])] += total16(addToSum16(zeroSum16(), load16(values)));
      continue;
    }
    for (int i = 0; i < CT_LEAF_WIDTH && i < left; i++) {
      ofRows[rowOf(places[i])] += (double)values[i];
    }
  }
  emptyBatch(batch);
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    if (!isfinite(ofRows[k])) {
      return false;
    }
  }
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] += ofRows[k];
  }
  return true;
}
