#include "expression.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure.h"

int ctMeasureWidth(ctMeasure measure) {
  switch (measure) {
    case ctMeasureDistance:
      return 2;
    case ctMeasureAngle:
      return 3;
    case ctMeasureDihedral:
      return 4;
    default:
      return 1;
  }
}

/* ---- Checks ---- */

int ctArgumentCount(const ctOperation* operation, const ctTable* tables) {
  switch (operation->kind) {
    case ctConstantOperator:
    case ctInputOperator:
    case ctParameterOperator:
      return 0;
    case ctAddOperator:
    case ctSubtractOperator:
    case ctMultiplyOperator:
    case ctDivideOperator:
    case ctPowerOperator:
    case ctAtan2Operator:
    case ctMinOperator:
    case ctMaxOperator:
      return 2;
    case ctSelectOperator:
      return 3;
    case ctTableOperator:
      return tables[(int)operation->constant].dimensions;
    default:
      return 1;
  }
}

static bool isIndex(int value, int count) {
  return value >= 0 && value < count;
}

static bool inputIsValid(const ctInput* input, int number, int particles, char* text, size_t size) {
  if ((int)input->measure < 0 || input->measure > ctMeasureDihedral) {
    snprintf(text, size, "input %d has the unknown measure %d", number, (int)input->measure);
    return false;
  }
  for (int i = 0; i < ctMeasureWidth(input->measure); i++) {
    if (!isIndex(input->particles[i], particles)) {
      snprintf(text, size, "input %d is of particle %d of the term, which has %d", number, input->particles[i],
               particles);
      return false;
    }
  }
  return true;
}

static bool operationIsValid(const ctExpression* e, int number, int parameters, char* text, size_t size) {
  const ctOperation* operation = &e->operations[number];
  const int first = operation->arguments[0];
  if ((int)operation->kind < 0 || operation->kind > ctSelectOperator) {
    snprintf(text, size, "operation %d has the unknown operator %d", number, (int)operation->kind);
    return false;
  }
  if (operation->kind == ctInputOperator && !isIndex(first, e->inputCount)) {
    snprintf(text, size, "operation %d reads input %d; there are %d", number, first, e->inputCount);
    return false;
  }
  if (operation->kind == ctParameterOperator && !isIndex(first, parameters)) {
    snprintf(text, size, "operation %d reads parameter %d of the term, which has %d", number, first, parameters);
    return false;
  }
  for (int i = 0; i < ctArgumentCount(operation, NULL); i++) {
    if (!isIndex(operation->arguments[i], number)) {
      snprintf(text, size, "operation %d needs the result of operation %d, which is not an earlier one", number,
               operation->arguments[i]);
      return false;
    }
  }
  return true;
}

bool ctExpressionIsValid(const ctExpression* expression, int particlesPerTerm, int parametersPerTerm, char* text,
                         size_t size) {
  if (expression->inputCount < 0 || expression->inputCount > CT_MOST_COUNT || expression->operationCount < 1 ||
      expression->operationCount > CT_MOST_OPERATIONS) {
    snprintf(text, size, "it has %d inputs and %d operations; it needs an operation, and %d at most",
             expression->inputCount, expression->operationCount, CT_MOST_OPERATIONS);
    return false;
  }
  if ((expression->inputCount > 0 && expression->inputs == NULL) || expression->operations == NULL) {
    snprintf(text, size, "its inputs or its operations are NULL");
    return false;
  }
  for (int i = 0; i < expression->inputCount; i++) {
    if (!inputIsValid(&expression->inputs[i], i, particlesPerTerm, text, size)) {
      return false;
    }
  }
  for (int i = 0; i < expression->operationCount; i++) {
    if (!operationIsValid(expression, i, parametersPerTerm, text, size)) {
      return false;
    }
  }
  return true;
}

bool ctExpressionHasCoordinate(const ctExpression* expression) {
  for (int i = 0; i < expression->inputCount; i++) {
    if (ctMeasureWidth(expression->inputs[i].measure) == 1) {
      return true;
    }
  }
  return false;
}

/* ---- Life ---- */

bool ctExpressionCopy(const ctExpression* from, Expression* to) {
  const size_t inputs = (size_t)from->inputCount;
  const size_t operations = (size_t)from->operationCount;
  *to = (Expression){.inputCount = from->inputCount,
                     .inputs = malloc((inputs + 1) * sizeof(ctInput)),
                     .operationCount = from->operationCount,
                     .operations = malloc(operations * sizeof(ctOperation))};
  if (to->inputs == NULL || to->operations == NULL) {
    ctExpressionFree(to);
    return false;
  }
  if (inputs > 0) {
    memcpy(to->inputs, from->inputs, inputs * sizeof(ctInput));
  }
  memcpy(to->operations, from->operations, operations * sizeof(ctOperation));
  /* Arguments that are not taken may hold anything. */
  for (size_t i = 0; i < operations; i++) {
    ctOperation* operation = &to->operations[i];
    const bool takesNumber = operation->kind == ctInputOperator || operation->kind == ctParameterOperator;
    for (int k = takesNumber ? 1 : ctArgumentCount(operation, NULL); k < 3; k++) {
      operation->arguments[k] = 0;
    }
  }
  return true;
}

void ctExpressionFree(Expression* expression) {
  free(expression->inputs);
  free(expression->operations);
  *expression = (Expression){0};
}

/* ---- Evaluation ---- */

static double measure(const ctInput* input, const double (*x)[3]) {
  const int* p = input->particles;
  switch (input->measure) {
    case ctMeasureX:
      return x[p[0]][0];
    case ctMeasureY:
      return x[p[0]][1];
    case ctMeasureZ:
      return x[p[0]][2];
    case ctMeasureDistance:
      return measureDistance(x[p[0]], x[p[1]]);
    case ctMeasureAngle:
      return measureAngle(x[p[0]], x[p[1]], x[p[2]]);
    default:
      return angleOf(measureDihedral(x[p[0]], x[p[1]], x[p[2]], x[p[3]]));
  }
}

/* By repeated multiplication if the exponent is a whole number, as OpenMM does. */
static double power(double base, double exponent) {
  if (!(fabs(exponent) < INT_MAX) || exponent != (int)exponent) {
    return pow(base, exponent);
  }
  double square = exponent < 0 ? 1 / base : base;
  double result = 1;
  for (int left = abs((int)exponent); left > 0; left /= 2) {
    result *= left % 2 == 1 ? square : 1;
    square *= square;
  }
  return result;
}

double ctOperate(const ctOperation* operation, double a, double b, double c) {
  switch (operation->kind) {
    case ctAddOperator:
      return a + b;
    case ctSubtractOperator:
      return a - b;
    case ctMultiplyOperator:
      return a * b;
    case ctDivideOperator:
      return a / b;
    case ctPowerOperator:
      return pow(a, b);
    case ctNegateOperator:
      return -a;
    case ctSqrtOperator:
      return sqrt(a);
    case ctExpOperator:
      return exp(a);
    case ctLogOperator:
      return log(a);
    case ctSinOperator:
      return sin(a);
    case ctCosOperator:
      return cos(a);
    case ctSecOperator:
      return 1 / cos(a);
    case ctCscOperator:
      return 1 / sin(a);
    case ctTanOperator:
      return tan(a);
    case ctCotOperator:
      return 1 / tan(a);
    case ctAsinOperator:
      return asin(a);
    case ctAcosOperator:
      return acos(a);
    case ctAtanOperator:
      return atan(a);
    case ctAtan2Operator:
      return atan2(a, b);
    case ctSinhOperator:
      return sinh(a);
    case ctCoshOperator:
      return cosh(a);
    case ctTanhOperator:
      return tanh(a);
    case ctErfOperator:
      return erf(a);
    case ctErfcOperator:
      return erfc(a);
    case ctStepOperator:
      return a >= 0 ? 1 : 0;
    case ctDeltaOperator:
      return a == 0 ? 1 : 0;
    case ctSquareOperator:
      return a * a;
    case ctCubeOperator:
      return a * a * a;
    case ctReciprocalOperator:
      return 1 / a;
    case ctAddConstantOperator:
      return a + operation->constant;
    case ctMultiplyConstantOperator:
      return a * operation->constant;
    case ctPowerConstantOperator:
      return power(a, operation->constant);
    /* If one is NaN, the first: as OpenMM does. */
    case ctMinOperator:
      return b < a ? b : a;
    case ctMaxOperator:
      return a < b ? b : a;
    case ctAbsOperator:
      return fabs(a);
    case ctFloorOperator:
      return floor(a);
    case ctCeilOperator:
      return ceil(a);
    case ctSelectOperator:
      return a != 0 ? b : c;
    default:
      return operation->constant;
  }
}

double ctExpressionEvaluate(const Expression* expression, const double (*positions)[3], const double* parameters,
                            double* results) {
  for (int i = 0; i < expression->operationCount; i++) {
    const ctOperation* operation = &expression->operations[i];
    const int* arguments = operation->arguments;
    if (operation->kind == ctInputOperator) {
      results[i] = measure(&expression->inputs[arguments[0]], positions);
    } else if (operation->kind == ctParameterOperator) {
      results[i] = parameters[arguments[0]];
    } else {
      results[i] = ctOperate(operation, results[arguments[0]], results[arguments[1]], results[arguments[2]]);
    }
  }
  return results[expression->operationCount - 1];
}
