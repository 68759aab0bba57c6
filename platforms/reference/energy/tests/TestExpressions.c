/* Each operator against the oracle, where it has no value too; random tapes; and expressions that have to be refused.
 */
#include "smallterms.h"

static SmallScene scene;
static const int particles[] = {0, 1, 2, 3, 4, 5, 6, 7};

static ctTermSet makeSet(const ctExpression* expression, int parameterCount, const double* parameters) {
  return (ctTermSet){.kind = ctExpressionTerm,
                     .count = 1,
                     .particlesPerTerm = 5,
                     .particles = particles,
                     .parametersPerTerm = parameterCount,
                     .parameters = parameters,
                     .expression = expression};
}

static void checkValue(const ctExpression* expression, int parameterCount, const double* parameters) {
  const ctTermSet set = makeSet(expression, parameterCount, parameters);
  const double found = sumOfSet(&scene, &set);
  const long double expected = oracleTerm(&set, 0, scene.positions);
  const ctOperator last = expression->operations[expression->operationCount - 1].kind;
  if (isnan(expected) || isinf((double)expected)) {
    if (!(isnan(expected) ? isnan(found) : found == (double)expected)) {
      reportFailure("operator %d gives %g, not %g\n", (int)last, found, (double)expected);
    }
  } else if (!(fabsl(found - expected) <= 1e-12L * (1 + fabsl(expected)))) {
    reportFailure("operator %d gives %.17g, not %.17g\n", (int)last, found, (double)expected);
  }
}

/* ---- Operators ---- */

static void testOperators(void) {
  const double values[] = {0, -0.0, 0.5, -0.5, 1, -1, 1.75, -2.25, 40, -3};
  const double exponents[] = {0, 1, 2, 3, 7, -1, -2, -5, 0.5, -0.5, 2.5};
  enum { VALUES = sizeof values / sizeof *values, EXPONENTS = sizeof exponents / sizeof *exponents };
  for (int kind = ctAddOperator; kind <= ctImageLengthOperator; kind++) {
    for (int i = 0; i < VALUES * VALUES * EXPONENTS; i++) {
      const double constant = exponents[i / (VALUES * VALUES)];
      if (constant != 0 && kind != ctAddConstantOperator && kind != ctMultiplyConstantOperator &&
          kind != ctPowerConstantOperator) {
        break;
      }
      const double parameters[] = {values[i % VALUES], values[i / VALUES % VALUES], 7};
      const bool isSum = kind == ctMinOperator || kind == ctMaxOperator; /* of 0 and -0 either will do */
      if (isSum && parameters[0] == 0 && parameters[1] == 0) {
        continue;
      }
      const ctOperation operations[] = {{ctParameterOperator, {0, 99, 99}, 0},
                                        {ctParameterOperator, {1, 99, 99}, 0},
                                        {ctParameterOperator, {2, 99, 99}, 0},
                                        {(ctOperator)kind, {0, 1, 2}, constant}};
      const ctExpression expression = {.operationCount = 4, .operations = operations};
      checkValue(&expression, 3, parameters);
    }
  }
}

static double valueOf(ctOperator kind, double a, double b, double constant) {
  const double parameters[] = {a, b};
  const ctOperation operations[] = {
      {ctParameterOperator, {0, 0, 0}, 0}, {ctParameterOperator, {1, 0, 0}, 0}, {kind, {0, 1, 1}, constant}};
  const ctExpression expression = {.operationCount = 3, .operations = operations};
  const ctTermSet set = makeSet(&expression, 2, parameters);
  return sumOfSet(&scene, &set);
}

/* What OpenMM says of edges and of what is no number. */
static void testEdges(void) {
  CHECK(valueOf(ctStepOperator, 0, 0, 0) == 1 && valueOf(ctStepOperator, -1e-300, 0, 0) == 0);
  CHECK(valueOf(ctStepOperator, -0.0, 0, 0) == 1 && valueOf(ctStepOperator, NAN, 0, 0) == 0);
  CHECK(valueOf(ctDeltaOperator, -0.0, 0, 0) == 1 && valueOf(ctDeltaOperator, NAN, 0, 0) == 0);
  CHECK(valueOf(ctSelectOperator, NAN, 3, 0) == 3);
  CHECK(isnan(valueOf(ctMinOperator, NAN, 3, 0)) && valueOf(ctMinOperator, 3, NAN, 0) == 3);
  CHECK(isnan(valueOf(ctMaxOperator, NAN, 3, 0)) && valueOf(ctMaxOperator, 3, NAN, 0) == 3);
  CHECK(valueOf(ctPowerConstantOperator, 3, 0, 40) == valueOf(ctPowerConstantOperator, -3, 0, 40));
  CHECK(valueOf(ctPowerConstantOperator, NAN, 0, 0) == 1);
  CHECK(valueOf(ctPowerConstantOperator, 1.5, 0, INFINITY) == INFINITY);
  CHECK(valueOf(ctPowerConstantOperator, 1, 0, 1e300) == 1);
  CHECK(valueOf(ctPowerConstantOperator, 0.5, 0, -2147483647) == INFINITY);
  CHECK(valueOf(ctPowerConstantOperator, 0.5, 0, -2147483648.0) == INFINITY);
  CHECK(isnan(valueOf(ctPowerConstantOperator, 2, 0, NAN)));
  CHECK(valueOf(ctReciprocalOperator, 0, 0, 0) == INFINITY && isnan(valueOf(ctDivideOperator, 0, 0, 0)));
}

/* ---- Measures ---- */

static void testMeasures(void) {
  static const ctInput inputs[] = {{ctMeasureX, {4, -1, 99, 99}},    {ctMeasureY, {3, -1, 99, 99}},
                                   {ctMeasureZ, {2, -1, 99, 99}},    {ctMeasureDistance, {4, 1, 99, 99}},
                                   {ctMeasureAngle, {3, 0, 4, 99}},  {ctMeasureDihedral, {4, 2, 0, 1}},
                                   {ctMeasureDihedral, {1, 2, 0, 4}}};
  for (int i = 0; i < 7; i++) {
    const ctOperation operation = {ctInputOperator, {i, -5, 1000}, 0};
    const ctExpression expression = {7, inputs, 1, &operation};
    checkValue(&expression, 0, NULL);
  }
}

/* An angle of a particle with one in its own place is none, and a dihedral of a line is a quarter turn. */
static void testDegenerateMeasures(void) {
  static const ctInput inputs[] = {{ctMeasureAngle, {0, 1, 2, 0}}, {ctMeasureDihedral, {0, 1, 2, 3}}};
  double kept[sizeof scene.positions / sizeof(double)];
  memcpy(kept, scene.positions, sizeof kept);
  memcpy(scene.positions + 3, scene.positions, 3 * sizeof(double));
  for (int i = 0; i < 2; i++) {
    const ctOperation operation = {ctInputOperator, {i, 0, 0}, 0};
    const ctExpression expression = {2, inputs, 1, &operation};
    const ctTermSet set = makeSet(&expression, 0, NULL);
    const double found = sumOfSet(&scene, &set);
    CHECK(i == 0 ? isnan(found) : fabs(found - PI / 2) < 1e-15);
  }
  memcpy(scene.positions, kept, sizeof kept);
}

/* ---- Random tapes ---- */

static uint64_t chance = 88172645463325252u;

static int draw(int end) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return (int)(chance >> 33) % end;
}

/* Operators whose results stay moderate, in tapes that use results many times. */
static void testTapes(void) {
  static const ctOperator kinds[] = {
      ctAddOperator,  ctSubtractOperator, ctNegateOperator, ctSinOperator,         ctCosOperator,     ctTanhOperator,
      ctAtanOperator, ctAtan2Operator,    ctErfOperator,    ctErfcOperator,        ctMinOperator,     ctMaxOperator,
      ctAbsOperator,  ctSelectOperator,   ctStepOperator,   ctAddConstantOperator, ctConstantOperator};
  static const ctInput inputs[] = {{ctMeasureDistance, {0, 1, 0, 0}}, {ctMeasureDihedral, {4, 2, 0, 1}}};
  const double parameters[] = {0.3, -1.2};
  for (int i = 0; i < 2000; i++) {
    ctOperation operations[12];
    const int count = 3 + draw(10);
    for (int k = 0; k < count; k++) {
      operations[k] = (ctOperation){.constant = 0.25 * draw(9) - 1};
      if (k < 3) {
        operations[k].kind = draw(2) ? ctInputOperator : ctParameterOperator;
        operations[k].arguments[0] = draw(2);
      } else {
        operations[k].kind = kinds[draw(sizeof kinds / sizeof *kinds)];
        for (int a = 0; a < 3; a++) {
          operations[k].arguments[a] = draw(k);
        }
      }
    }
    const ctExpression expression = {2, inputs, count, operations};
    checkValue(&expression, 2, parameters);
  }
}

/* ---- Expressions that have to be refused ---- */

static void checkOperationsRefused(int count, const ctOperation* operations, const char* culprit) {
  static const ctInput input = {ctMeasureDistance, {0, 1, 0, 0}};
  const double parameter = 1;
  const ctExpression expression = {1, &input, count, operations};
  const ctTermSet set = makeSet(&expression, 1, &parameter);
  checkRefused(&scene, 1, &set, culprit);
}

static void checkInputRefused(ctInput input, const char* culprit) {
  const ctOperation operation = {ctInputOperator, {0, 0, 0}, 0};
  const ctExpression expression = {1, &input, 1, &operation};
  const ctTermSet set = makeSet(&expression, 0, NULL);
  checkRefused(&scene, 1, &set, culprit);
}

static void testRefusals(void) {
  const ctOperation later[] = {{ctParameterOperator, {0, 0, 0}, 0}, {ctAddOperator, {0, 1, 0}, 0}};
  const ctOperation negative[] = {{ctParameterOperator, {0, 0, 0}, 0}, {ctSelectOperator, {0, 0, -1}, 0}};
  const ctOperation input[] = {{ctInputOperator, {1, 0, 0}, 0}};
  const ctOperation parameter[] = {{ctParameterOperator, {1, 0, 0}, 0}};
  const ctOperation table[] = {{ctTableOperator, {0, 0, 0}, 0}};
  const ctOperation unknown[] = {{(ctOperator)(ctTableOperator + 1), {0, 0, 0}, 0}};
  checkOperationsRefused(2, later, "operation 1 of the expression of term set 0 needs the result of operation 1");
  checkOperationsRefused(2, negative, "operation 1 of the expression of term set 0 needs the result of operation -1");
  checkOperationsRefused(1, input, "operation 0 of the expression of term set 0 reads input 1; there are 1");
  checkOperationsRefused(1, parameter, "operation 0 of the expression of term set 0 reads parameter 1; there are 1");
  checkOperationsRefused(1, table, "operation 0 of the expression of term set 0 reads table 0; there are 0");
  checkOperationsRefused(1, unknown, "operation 0 of the expression of term set 0 has the unknown operator 43");
  checkOperationsRefused(0, NULL, "the expression of term set 0 has 0 operations, which are NULL,");
  checkInputRefused((ctInput){ctMeasureAngle, {0, 1, 5, 0}},
                    "input 0 of the expression of term set 0 is of particle 5 of the term, which has 5");
  checkInputRefused((ctInput){ctMeasureX, {-1, 0, 0, 0}}, "particle -1 of the term");
  checkInputRefused((ctInput){(ctMeasure)6, {0, 0, 0, 0}},
                    "input 0 of the expression of term set 0 has the unknown measure 6");
  const ctTermSet set = makeSet(NULL, 0, NULL);
  checkRefused(&scene, 1, &set, "term set 0 has no expression");
}

int main(void) {
  makeSmallScene(&scene, CT_NULL);
  testOperators();
  testEdges();
  testMeasures();
  testDegenerateMeasures();
  testTapes();
  testRefusals();
  return checkResult();
}
