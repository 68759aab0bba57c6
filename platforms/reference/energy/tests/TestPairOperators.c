/* Each operator of a pair expression, by every instruction set and in double, against its definition in long double. */
#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "../src/wide.h"
#include "operatororacle.h"

/* Each argument is the sum of a parameter of one particle and one of the other, so that it is no constant. */
enum { ARGUMENTS = 3, PARAMETERS = ARGUMENTS, ARGUMENT_OPERATIONS = 3 * ARGUMENTS, PARTICLES = 2 };

typedef struct Case {
  ctOperator kind;
  double most; /* error, relative to the value or to 1, in 2^-24 */
} Case;

static const Case cases[] = {
    {ctConstantOperator, 1},
    {ctAddOperator, 1},
    {ctSubtractOperator, 1},
    {ctMultiplyOperator, 1},
    {ctDivideOperator, 1},
    {ctPowerOperator, 2},
    {ctNegateOperator, 0},
    {ctSqrtOperator, 1},
    {ctExpOperator, 2},
    {ctLogOperator, 2},
    {ctSinOperator, 1},
    {ctCosOperator, 1},
    {ctSecOperator, 3},
    {ctCscOperator, 3},
    {ctTanOperator, 1},
    {ctCotOperator, 3},
    {ctAsinOperator, 1},
    {ctAcosOperator, 1},
    {ctAtanOperator, 1},
    {ctAtan2Operator, 1},
    {ctSinhOperator, 1},
    {ctCoshOperator, 1},
    {ctTanhOperator, 1},
    {ctErfOperator, 1},
    {ctErfcOperator, 1},
    {ctStepOperator, 0},
    {ctDeltaOperator, 0},
    {ctSquareOperator, 1},
    {ctCubeOperator, 3},
    {ctReciprocalOperator, 1},
    {ctAddConstantOperator, 2},
    {ctMultiplyConstantOperator, 3},
    {ctPowerConstantOperator, 130},
    {ctMinOperator, 0},
    {ctMaxOperator, 0},
    {ctAbsOperator, 0},
    {ctFloorOperator, 0},
    {ctCeilOperator, 0},
    {ctSelectOperator, 0},
};

/* ---- Tapes ---- */

/* An operation on three numbers. */
static void describe(ctOperation* operations, ctOperator kind, double v) {
  for (int k = 0; k < ARGUMENTS; k++) {
    operations[3 * k] = (ctOperation){ctParameterOperator, {k, 0, 0}, 0};
    operations[3 * k + 1] = (ctOperation){ctParameterOperator, {PARAMETERS + k, 0, 0}, 0};
    operations[3 * k + 2] = (ctOperation){ctAddOperator, {3 * k, 3 * k + 1, 0}, 0};
  }
  operations[ARGUMENT_OPERATIONS] = (ctOperation){kind, {2, 5, 8}, v};
}

/* What each instruction set makes of two particles, 1 nm apart, of one leaf each. */
static void runAll(const Tape* tape, float results[3]) {
  const Wide* const wide[] = {ctFindWide("portable"), ctFindWide("avx2"), ctFindWide("avx512")};
  static LeafFrame frames[2]; /* all zero but for one coordinate */
  const TapeRange range = {.squaredCutoff = 100};
  const size_t width = (size_t)tape->columnCount * CT_LEAF_WIDTH;
  frames[1].x[0] = 1;
  const TapePair pair = {
      .frames = {&frames[0], &frames[1]}, .columns = {tape->columns, tape->columns + width}, .occupied = {1, 1}};
  bool isThere[3] = {true, false, false};
#ifdef __x86_64__
  isThere[1] = __builtin_cpu_supports("avx2") != 0;
  isThere[2] = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0;
#endif
  for (int i = 0; i < 3; i++) {
    results[i] = isThere[i] ? (float)wide[i]->tapeEnergy(tape, &pair, &range) : results[0];
  }
}

static void checkValue(const char* what, int kind, const double* numbers, double value, long double expected,
                       double most) {
  const bool isRight = isnan(expected)           ? isnan(value)
                       : isinf((double)expected) ? value == (double)expected
                                                 : fabsl(value - expected) <= most * fmaxl(1, fabsl(expected));
  if (!isRight) {
    reportFailure("operator %d of %g, %g, %g %s is %.9g, not %.9Lg\n", kind, numbers[0], numbers[1], numbers[2], what,
                  value, expected);
  }
}

static int finite = 0;

static void checkCase(const Case* c, const double* numbers, double v) {
  static const int slotOf[PARTICLES] = {0, CT_LEAF_WIDTH};
  const double parameters[PARTICLES * PARAMETERS] = {numbers[0], numbers[1], numbers[2], 0, 0, 0};
  ctOperation operations[ARGUMENT_OPERATIONS + 1];
  float results[3];
  Tape tape;
  describe(operations, c->kind, v);
  const ctPairSet set = {.operationCount = ARGUMENT_OPERATIONS + 1,
                         .operations = operations,
                         .parametersPerParticle = PARAMETERS,
                         .parameters = parameters};
  CHECK(ctTapeCreate(&tape, &set, PARAMETERS, PARTICLES, PARTICLES, slotOf));
  const long double expected = c->kind == ctConstantOperator ? (long double)v
                                                             : oracleOperator(&operations[ARGUMENT_OPERATIONS],
                                                                              numbers[0], numbers[1], numbers[2]);
  const double inDouble = ctPairExpressionEvaluate(&tape.expression, 1, parameters, parameters + PARAMETERS);
  checkValue("in double", (int)c->kind, numbers, inDouble, expected, 1e-13);
  runAll(&tape, results);
  CHECK((isnan(results[0]) && isnan(results[1]) && isnan(results[2])) ||
        (memcmp(&results[0], &results[1], sizeof(float)) == 0 && memcmp(&results[0], &results[2], sizeof(float)) == 0));
  /* What is not finite is computed in double. */
  if (isfinite(results[0])) {
    finite++;
    checkValue("in floats", (int)c->kind, numbers, (double)results[0], expected, c->most * 0x1p-24);
  } else {
    CHECK(!(fabsl(expected) < 1e38L) || c->kind == ctPowerConstantOperator || c->kind == ctCscOperator ||
          c->kind == ctCotOperator);
  }
  ctTapeFree(&tape);
}

static void testOperators(void) {
  const double numbers[] = {0, 1, -1, 0.5, -0.75, 2, -3, 0.125, 7.25, -12.5, 50, 0x1p-10, 1000};
  const double constants[] = {0, 1, 2, 3, -1, -2, 6, 12, -12, 0.5, -0.5, 1.5, 2.5, -1.5, 0.25, -2.75, 7, 64, 65, 5.25};
  enum { NUMBERS = sizeof numbers / sizeof numbers[0], CONSTANTS = sizeof constants / sizeof constants[0] };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    const int before = finite;
    for (int a = 0; a < NUMBERS; a++) {
      for (int b = 0; b < NUMBERS; b++) {
        const double arguments[] = {numbers[a], numbers[b], numbers[(a + b) % NUMBERS]};
        checkCase(&cases[i], arguments, constants[(a + 3 * b) % CONSTANTS]);
      }
    }
    CHECK(finite > before + NUMBERS);
  }
}

/* ---- Tables ---- */

static double lookUp(const ctTable* table, const double* numbers) {
  static const int slotOf[PARTICLES] = {0, CT_LEAF_WIDTH};
  const double parameters[PARTICLES * PARAMETERS] = {numbers[0], numbers[1], numbers[2], 0, 0, 0};
  ctOperation operations[ARGUMENT_OPERATIONS + 1];
  float results[3];
  Tape tape;
  describe(operations, ctTableOperator, 0);
  const ctPairSet set = {.operationCount = ARGUMENT_OPERATIONS + 1,
                         .operations = operations,
                         .tableCount = 1,
                         .tables = table,
                         .parametersPerParticle = PARAMETERS,
                         .parameters = parameters};
  CHECK(ctTapeCreate(&tape, &set, PARAMETERS, PARTICLES, PARTICLES, slotOf));
  runAll(&tape, results);
  const double exact = ctPairExpressionEvaluate(&tape.expression, 1, parameters, parameters + PARAMETERS);
  CHECK(isnan(exact) ? isnan(results[0]) : fabs((double)results[0] - exact) <= 1e-6 * (1 + fabs(exact)));
  CHECK(isnan(exact) || (results[0] == results[1] && results[0] == results[2]));
  ctTapeFree(&tape);
  return exact;
}

static void testDiscrete(void) {
  double values[24];
  for (int i = 0; i < 24; i++) {
    values[i] = 10 + i;
  }
  for (int dimensions = 1; dimensions <= 3; dimensions++) {
    const ctTable table = {.isDiscrete = true, .dimensions = dimensions, .sizes = {2, 3, 4}, .values = values};
    for (int i = -1; i <= 2; i++) {
      for (int j = -1; j <= 3; j++) {
        for (int k = -1; k <= 4; k++) {
          const bool isInside =
              i >= 0 && i < 2 && (dimensions < 2 || (j >= 0 && j < 3)) && (dimensions < 3 || (k >= 0 && k < 4));
          const int at = i + (dimensions > 1 ? 2 * j : 0) + (dimensions > 2 ? 6 * k : 0);
          const double numbers[] = {i + 0.25, j - 0.25, k};
          const double value = lookUp(&table, numbers);
          CHECK(isInside ? value == 10 + at : isnan(value));
        }
      }
    }
  }
}

/* x^3 from 1 to 3 in two pieces: in the first x = 1 + u, in the second x = 2 + u. */
static void testPieces(void) {
  const double values[] = {1, 3, 3, 1, 8, 12, 6, 1};
  ctTable table = {.dimensions = 1, .sizes = {2}, .minima = {1}, .maxima = {3}, .values = values};
  for (double x = 0.5; x < 4; x += 0.0625) {
    const double numbers[] = {x, 0, 0};
    CHECK_NEAR(lookUp(&table, numbers), x < 1 || x > 3 ? 0 : x * x * x, 1e-12);
  }
  table.isPeriodic = true;
  for (double x = -7.5; x < 9; x += 0.0625) {
    const double within = x - 2 * floor((x - 1) / 2);
    const double numbers[] = {x, 0, 0};
    CHECK_NEAR(lookUp(&table, numbers), within * within * within, 1e-12);
  }
}

/* x + 10 y from 0 to 2 and from 0 to 3 in pieces of size 1. */
static void testPatches(void) {
  double values[16 * 6] = {0};
  for (int s = 0; s < 2; s++) {
    for (int t = 0; t < 3; t++) {
      double* patch = values + 16 * (s + 2 * t);
      patch[0] = s + 10 * t;
      patch[4] = 1;
      patch[1] = 10;
    }
  }
  const ctTable table = {.dimensions = 2, .sizes = {2, 3}, .maxima = {2, 3}, .values = values};
  for (double x = -0.25; x < 2.5; x += 0.125) {
    for (double y = -0.25; y < 3.5; y += 0.125) {
      const double numbers[] = {x, y, 0};
      const bool isInside = x >= 0 && x <= 2 && y >= 0 && y <= 3;
      CHECK_NEAR(lookUp(&table, numbers), isInside ? x + 10 * y : 0, 1e-12);
    }
  }
}

int main(void) {
  testOperators();
  testDiscrete();
  testPieces();
  testPatches();
  return checkResult();
}
