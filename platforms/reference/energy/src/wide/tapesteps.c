/* The steps of a tape on the pairs of particles of a batch. */
#include "tapesteps.h"

#include "../pairtable.h"
#include "elementary.h"

/* Stores a result for each sixteen pairs, of a, b and c. */
#define EACH_SIXTEEN(value)                            \
  for (int v = 0; v < count; v++) {                    \
    const Float16 a = load16(first + v * firstStep);   \
    const Float16 b = load16(second + v * secondStep); \
    const Float16 c = load16(third + v * thirdStep);   \
    store16(result + v * CT_LEAF_WIDTH, value);        \
    (void)a;                                           \
    (void)b;                                           \
    (void)c;                                           \
  }                                                    \
  break

/* As that, with a and b from columns of the two leaves. */
#define EACH_OF_COLUMNS(value)                                                 \
  for (int v = 0; v < count; v++) {                                            \
    const Int16 lanes = loadInts(batch->places + v * CT_LEAF_WIDTH);           \
    const Int16 rows = shiftRightInts(lanes, 4);                               \
    const Float16 a = lookup16(firsts[v] + first, isSwapped ? lanes : rows);   \
    const Float16 b = lookup16(seconds[v] + second, isSwapped ? rows : lanes); \
    const Float16 c = load16(third + v * thirdStep);                           \
    store16(result + v * CT_LEAF_WIDTH, value);                                \
    (void)b;                                                                   \
    (void)c;                                                                   \
  }                                                                            \
  break

/* As one of these, with the step's sequel. */
#define WITH_SEQUEL(EACH, value) \
  switch (step->sequel) {        \
    case THEN_ADD:               \
      EACH(add16(value, c));     \
    case THEN_SUBTRACT:          \
      EACH(sub16(value, c));     \
    case THEN_SUBTRACT_FROM:     \
      EACH(sub16(c, value));     \
    case THEN_MULTIPLY:          \
      EACH(mul16(value, c));     \
    default:                     \
      EACH(value);               \
  }                              \
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

/* Steps that read columns: a constant for `isSwapped` tells of which leaf the first is. */
CT_INLINE void runOnSides(const TapeStep* step, float* scratch, const TapeBatch* batch, bool isSwapped) {
  const float* const* firsts = batch->columns[isSwapped ? 1 : 0];
  const float* const* seconds = batch->columns[isSwapped ? 0 : 1];
  const int first = step->columns[0] * CT_LEAF_WIDTH;
  const int second = step->columns[1] * CT_LEAF_WIDTH;
  const float* third = scratch + step->arguments[2].begin;
  const int thirdStep = step->arguments[2].step;
  float* result = scratch + step->result;
  const int count = batch->count;
  switch (step->kind) {
    case ctAddOperator:
      WITH_SEQUEL(EACH_OF_COLUMNS, add16(a, b));
    case ctSubtractOperator:
      WITH_SEQUEL(EACH_OF_COLUMNS, sub16(a, b));
    case ctMultiplyOperator:
      WITH_SEQUEL(EACH_OF_COLUMNS, mul16(a, b));
    default:
      EACH_OF_COLUMNS(a);
  }
}

static void runOnColumns(const TapeStep* step, float* scratch, const TapeBatch* batch) {
  if (step->side == 0) {
    runOnSides(step, scratch, batch, false);
  } else {
    runOnSides(step, scratch, batch, true);
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
  switch ((int)step->kind) {
    case ctAddOperator:
      WITH_SEQUEL(EACH_SIXTEEN, add16(a, b));
    case ctSubtractOperator:
      WITH_SEQUEL(EACH_SIXTEEN, sub16(a, b));
    case ctMultiplyOperator:
      WITH_SEQUEL(EACH_SIXTEEN, mul16(a, b));
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
      EACH_SIXTEEN(chooseEqual16(a, zero, c, b));
    case INVERSE_ROOT_OPERATOR:
      EACH_SIXTEEN(inverseRoot16(a));
    default:
      runLongStep(step, scratch, count);
  }
}

void CT_WIDE(runSteps)(const Tape* tape) {
  float* scratch = tape->scratch;
  for (int i = 0; i < tape->stepCount; i++) {
    const TapeStep* step = &tape->steps[i];
    if (step->isOfColumns || step->kind == ctParameterOperator) {
      runOnColumns(step, scratch, tape->batch);
    } else {
      runStep(step, scratch, tape->batch->count);
    }
  }
}
