/* Runs a tape on the pairs of particles of two leaves, compiled once for each instruction set by the file that includes
 * this. It defines TAPE_KERNELS, the name of the table, before. */
#include "elementary.h"
#include "pairtable.h"
#include "rowsnear.h"
#include "sums.h"
#include "switching16.h"
#include "tapekernels.h"

/* ---- Pairs ---- */

/* The pairs of two leaves that count, without gaps. */
typedef struct PairList {
  int count;
  float* squared; /* of their distances */
  int rows[MOST_LEAF_PAIRS + CT_LEAF_WIDTH];
  int lanes[MOST_LEAF_PAIRS + CT_LEAF_WIDTH];
} PairList;

static void listPairs(const TapePair* pair, const TapeRange* range, PairList* list) {
  const LeafFrame* a = pair->frames[0];
  const LeafFrame* b = pair->frames[1];
  float shift[3];
  shiftBetween(a, b, shift);
  unsigned rows = pair->occupied[0];
  if (range->hasCutoff) {
    rows &= rowsNear(a, b, shift, range->squaredCutoff);
  }
  const Float16 xb = add16(load16(b->x), all16(shift[0]));
  const Float16 yb = add16(load16(b->y), all16(shift[1]));
  const Float16 zb = add16(load16(b->z), all16(shift[2]));
  int count = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const Float16 dx = sub16(xb, all16(a->x[k]));
    const Float16 dy = sub16(yb, all16(a->y[k]));
    const Float16 dz = sub16(zb, all16(a->z[k]));
    const Float16 squared = squared16(dx, dy, dz);
    unsigned mask = pair->occupied[1] & greater16(all16(range->squaredCutoff), squared);
    if (pair->allowed != NULL) {
      mask &= pair->allowed[k];
    }
    for (int l = 0; l < CT_LEAF_WIDTH; l++) {
      list->rows[count + l] = k;
    }
    count += pack16(mask, squared, list->squared + count, list->lanes + count);
  }
  list->count = count;
  /* What fills the last sixteen has to be as harmless as the others. */
  for (int i = count; count > 0 && i % CT_LEAF_WIDTH != 0; i++) {
    list->squared[i] = list->squared[0];
    list->rows[i] = list->rows[0];
    list->lanes[i] = list->lanes[0];
  }
}

/* ---- Steps ---- */

/* Stores a result for each sixteen pairs, of a and b. */
#define EACH_SIXTEEN(value)                            \
  for (int v = 0; v < count; v++) {                    \
    const Float16 a = load16(first + v * firstStep);   \
    const Float16 b = load16(second + v * secondStep); \
    store16(result + v * CT_LEAF_WIDTH, value);        \
    (void)a;                                           \
    (void)b;                                           \
  }                                                    \
  break

/* As that, with a and b from columns of the two leaves. */
#define EACH_OF_COLUMNS(value)                                             \
  for (int v = 0; v < count; v++) {                                        \
    const Float16 a = lookup16(first, slotsOfFirst + v * CT_LEAF_WIDTH);   \
    const Float16 b = lookup16(second, slotsOfSecond + v * CT_LEAF_WIDTH); \
    store16(result + v * CT_LEAF_WIDTH, value);                            \
  }                                                                        \
  break

/* As discreteValue. */
CT_INLINE Float16 discrete16(const TapeTable* table, const Float16 numbers[3]) {
  Float16 place = all16(0);
  Float16 known = all16(0); /* or NaN */
  float step = 1;
  for (int d = 0; d < table->exact.dimensions; d++) {
    const Float16 below = chooseBelow16(numbers[d], all16((float)table->exact.sizes[d] - 0.5f), known, all16(NAN));
    known = chooseBelow16(all16(-0.5f), numbers[d], below, all16(NAN));
    place = add16(place, mul16(nearest16(numbers[d]), all16(step)));
    step *= (float)table->exact.sizes[d];
  }
  const Float16 inside = chooseEqual16(known, all16(0), place, all16(0));
  return add16(gather16(table->values, intsOf16(inside)), known);
}

/* As pieceValue in one dimension. */
CT_INLINE Float16 line16(const TapeTable* table, Float16 x) {
  const double low = table->exact.minima[0];
  const float size = (float)table->exact.sizes[0];
  Float16 part = mul16(sub16(x, all16((float)low)), all16((float)(1 / (table->exact.maxima[0] - low))));
  if (table->exact.isPeriodic) {
    part = sub16(part, floor16(part));
  }
  const Float16 outside = chooseBelow16(part, all16(0), all16(1), chooseBelow16(all16(1), part, all16(1), all16(0)));
  const Float16 place = chooseBelow16(outside, all16(1), mul16(part, all16(size)), all16(0));
  /* In this order NaN, too, is a place. */
  const Float16 begin = max16(min16(floor16(place), all16(size - 1)), all16(0));
  const Int16 first = shiftLeftInts(intsOf16(begin), 2);
  const Float16 u = sub16(place, begin);
  Float16 value = gather16(table->values + 3, first);
  for (int i = 2; i >= 0; i--) {
    value = add16(mul16(value, u), gather16(table->values + i, first));
  }
  return chooseBelow16(outside, all16(1), value, all16(0));
}

static void lookUp(const TapeTable* table, const float* x, const float* y, const float* z, float* result) {
  if (!table->isLong && table->exact.isDiscrete) {
    const Float16 numbers[3] = {load16(x), load16(y), load16(z)};
    store16(result, discrete16(table, numbers));
  } else if (!table->isLong && table->exact.dimensions == 1) {
    store16(result, line16(table, load16(x)));
  } else {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      result[k] = (float)tableValue(&table->exact, (double)x[k], (double)y[k], (double)z[k]);
    }
  }
}

/* Steps that read columns. */
static void runOnColumns(const TapeStep* step, float* result, int count, const TapePair* pair, const PairList* list) {
  const float* first = pair->columns[step->side] + step->columns[0] * CT_LEAF_WIDTH;
  const float* second = pair->columns[1 - step->side] + step->columns[1] * CT_LEAF_WIDTH;
  const int* slotsOfFirst = step->side == 0 ? list->rows : list->lanes;
  const int* slotsOfSecond = step->side == 0 ? list->lanes : list->rows;
  switch (step->kind) {
    case ctAddOperator:
      EACH_OF_COLUMNS(add16(a, b));
    case ctSubtractOperator:
      EACH_OF_COLUMNS(sub16(a, b));
    case ctMultiplyOperator:
      EACH_OF_COLUMNS(mul16(a, b));
    default:
      for (int v = 0; v < count; v++) {
        store16(result + v * CT_LEAF_WIDTH, lookup16(first, slotsOfFirst + v * CT_LEAF_WIDTH));
      }
  }
}

/* Steps that take long, apart, so that the others need few registers. */
static __attribute__((noinline)) void runLongStep(const TapeStep* step, float* scratch, int count) {
  const float* first = scratch + step->arguments[0].begin;
  const float* second = scratch + step->arguments[1].begin;
  const float* third = scratch + step->arguments[2].begin;
  const int firstStep = step->arguments[0].step;
  const int secondStep = step->arguments[1].step;
  const int thirdStep = step->arguments[2].step;
  float* result = scratch + step->result;
  switch (step->kind) {
    case ctExpOperator:
      EACH_SIXTEEN(exp16(a));
    case ctLogOperator:
      EACH_SIXTEEN(log16(a));
    case ctPowerOperator:
      EACH_SIXTEEN(pow16(a, b));
    case ctSinOperator:
      EACH_SIXTEEN(sin16(a));
    case ctCosOperator:
      EACH_SIXTEEN(cos16(a));
    case ctTanOperator:
      EACH_SIXTEEN(tan16(a));
    case ctAsinOperator:
      EACH_SIXTEEN(asin16(a));
    case ctAcosOperator:
      EACH_SIXTEEN(acos16(a));
    case ctAtanOperator:
      EACH_SIXTEEN(atan16(a));
    case ctAtan2Operator:
      EACH_SIXTEEN(atan216(a, b));
    case ctSinhOperator:
      EACH_SIXTEEN(sinh16(a));
    case ctCoshOperator:
      EACH_SIXTEEN(cosh16(a));
    case ctTanhOperator:
      EACH_SIXTEEN(tanh16(a));
    case ctErfOperator:
      EACH_SIXTEEN(erf16(a));
    case ctErfcOperator:
      EACH_SIXTEEN(erfc16(a));
    case ctTableOperator:
      for (int v = 0; v < count; v++) {
        lookUp(step->table, first + v * firstStep, second + v * secondStep, third + v * thirdStep,
               result + v * CT_LEAF_WIDTH);
      }
      break;
    default:
      EACH_SIXTEEN(all16(NAN));
  }
}

static void runStep(const TapeStep* step, float* scratch, int count) {
  const float* first = scratch + step->arguments[0].begin;
  const float* second = scratch + step->arguments[1].begin;
  const float* third = scratch + step->arguments[2].begin;
  const int firstStep = step->arguments[0].step;
  const int secondStep = step->arguments[1].step;
  const int thirdStep = step->arguments[2].step;
  float* result = scratch + step->result;
  const Float16 zero = all16(0);
  const Float16 one = all16(1);
  switch (step->kind) {
    case ctAddOperator:
      EACH_SIXTEEN(add16(a, b));
    case ctSubtractOperator:
      EACH_SIXTEEN(sub16(a, b));
    case ctMultiplyOperator:
      EACH_SIXTEEN(mul16(a, b));
    case ctDivideOperator:
      EACH_SIXTEEN(div16(a, b));
    case ctSqrtOperator:
      EACH_SIXTEEN(sqrt16(a));
    /* If one is NaN, the first, as OpenMM does. */
    case ctMinOperator:
      EACH_SIXTEEN(chooseBelow16(b, a, b, a));
    case ctMaxOperator:
      EACH_SIXTEEN(chooseBelow16(a, b, b, a));
    case ctFloorOperator:
      EACH_SIXTEEN(floor16(a));
    case ctCeilOperator:
      EACH_SIXTEEN(ceil16(a));
    case ctAbsOperator:
      EACH_SIXTEEN(absolute16(a));
    case ctStepOperator:
      EACH_SIXTEEN(chooseBelow16(a, zero, zero, chooseEqual16(a, a, one, zero)));
    case ctDeltaOperator:
      EACH_SIXTEEN(chooseEqual16(a, zero, one, zero));
    case ctSelectOperator:
      for (int v = 0; v < count; v++) {
        const Float16 a = load16(first + v * firstStep);
        const Float16 b = load16(second + v * secondStep);
        const Float16 c = load16(third + v * thirdStep);
        store16(result + v * CT_LEAF_WIDTH, chooseEqual16(a, zero, c, b));
      }
      break;
    default:
      runLongStep(step, scratch, count);
  }
}

/* ---- Sums ---- */

/* Sixteen pairs each that are summed in single precision before they are added in double. */
enum { SUMMED_IN_FLOAT = 4 };

/* Lists the pairs and runs all steps on them; returns how many sixteens there are. */
static int run(const Tape* tape, const TapePair* pair, const TapeRange* range, PairList* list) {
  float* scratch = tape->scratch;
  list->squared = scratch + tape->squaredBegin;
  listPairs(pair, range, list);
  const int count = (list->count + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH;
  for (int i = 0; count > 0 && i < tape->stepCount; i++) {
    const TapeStep* step = &tape->steps[i];
    if (step->isOfColumns || step->kind == ctParameterOperator) {
      runOnColumns(step, scratch + step->result, count, pair, list);
    } else {
      runStep(step, scratch, count);
    }
  }
  return count;
}

static double energy(const Tape* tape, const TapePair* pair, const TapeRange* range) {
  PairList list;
  const int count = run(tape, pair, range, &list);
  if (count == 0) {
    return 0;
  }
  Sum16 sum = zeroSum16();
  Float16 part = all16(0);
  for (int v = 0; v < count; v++) {
    const int begin = v * CT_LEAF_WIDTH;
    Float16 value = load16(tape->scratch + tape->result.begin + v * tape->result.step);
    if (range->hasSwitch) {
      const Float16 distance = sqrt16(load16(list.squared + begin));
      value = mul16(value, switchFactor16(distance, range->switchingDistance, range->inverseSwitchWidth));
    }
    if (pair->times != NULL) {
      float times[CT_LEAF_WIDTH];
      for (int k = 0; k < CT_LEAF_WIDTH; k++) {
        times[k] = (float)pair->times[list.rows[begin + k]][list.lanes[begin + k]];
      }
      value = mul16(value, load16(times));
    }
    if (list.count - begin < CT_LEAF_WIDTH) {
      value = keep16((1u << (list.count - begin)) - 1, value);
    }
    part = add16(part, value);
    if (v % SUMMED_IN_FLOAT == SUMMED_IN_FLOAT - 1 || v == count - 1) {
      sum = addToSum16(sum, part);
      part = all16(0);
    }
  }
  return total16(sum);
}

static bool addRows(const Tape* tape, const TapePair* pair, const TapeRange* range, double sums[CT_LEAF_WIDTH]) {
  PairList list;
  double ofRows[CT_LEAF_WIDTH] = {0};
  const int count = run(tape, pair, range, &list);
  for (int v = 0; v < count; v++) {
    const int begin = v * CT_LEAF_WIDTH;
    const int end = begin + CT_LEAF_WIDTH < list.count ? begin + CT_LEAF_WIDTH : list.count;
    const float* values = tape->scratch + tape->result.begin + v * tape->result.step;
    if (end == begin + CT_LEAF_WIDTH && list.rows[begin] == list.rows[end - 1]) {
      ofRows[list.rows[begin]] += total16(addToSum16(zeroSum16(), load16(values)));
      continue;
    }
    for (int i = begin; i < end; i++) {
      ofRows[list.rows[i]] += (double)values[i - begin];
    }
  }
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

const TapeKernels TAPE_KERNELS = {.energy = energy, .addRows = addRows};
