#include "expression.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"
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
#define CT_COUNT(name, count, value) [ct##name##Operator] = count,
  static const int counts[] = {[ctConstantOperator] = 0,
                               [ctInputOperator] = 0,
                               [ctParameterOperator] = 0,
                               CT_OPERATORS(CT_COUNT)[ctImageLengthOperator] = 3};
#undef CT_COUNT
  return operation->kind == ctTableOperator ? tables[(int)operation->constant].dimensions : counts[operation->kind];
}

static bool inputIsValid(const ctInput* input, int number, const char* name, int particles, char* text, size_t size) {
  if ((int)input->measure < 0 || input->measure > ctMeasureDihedral) {
    return ctInvalid(text, size, "input %d of %s has the unknown measure %d", number, name, (int)input->measure);
  }
  for (int i = 0; i < ctMeasureWidth(input->measure); i++) {
    if (input->particles[i] < 0 || input->particles[i] >= particles) {
      return ctInvalid(text, size, "input %d of %s is of particle %d of the term, which has %d", number, name,
                       input->particles[i], particles);
    }
  }
  return true;
}

bool ctExpressionIsValid(const ctExpression* expression, const char* name, int particlesPerTerm, int parametersPerTerm,
                         char* text, size_t size) {
  const Operations operations = {.name = name,
                                 .operationCount = expression->operationCount,
                                 .operations = expression->operations,
                                 .inputCount = expression->inputCount,
                                 .parameterCount = parametersPerTerm,
                                 .isOfTerms = true};
  if (expression->inputCount < 0 || expression->inputCount > CT_MOST_COUNT ||
      (expression->inputCount > 0 && expression->inputs == NULL)) {
    return ctInvalid(text, size, "%s has %d inputs%s", name, expression->inputCount,
                     expression->inputs == NULL ? ", which are NULL" : "");
  }
  for (int i = 0; i < expression->inputCount; i++) {
    if (!inputIsValid(&expression->inputs[i], i, name, particlesPerTerm, text, size)) {
      return false;
    }
  }
  return ctOperationsAreValid(&operations, text, size);
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

ctOperation* ctCopyOperations(const ctOperation* from, int count, const ctTable* tables) {
  ctOperation* copies = malloc((size_t)count * sizeof *copies);
  if (copies == NULL) {
    return NULL;
  }
  memcpy(copies, from, (size_t)count * sizeof *copies);
  for (int i = 0; i < count; i++) {
    ctOperation* copy = &copies[i];
    const bool takesNumber = copy->kind == ctInputOperator || copy->kind == ctParameterOperator;
    for (int k = takesNumber ? 1 : ctArgumentCount(copy, tables); k < 3; k++) {
      copy->arguments[k] = 0;
    }
  }
  return copies;
}

bool ctExpressionCopy(const ctExpression* from, Expression* to) {
  const size_t inputs = (size_t)from->inputCount;
  *to = (Expression){.inputCount = from->inputCount,
                     .inputs = malloc((inputs + 1) * sizeof(ctInput)),
                     .operationCount = from->operationCount,
                     .operations = ctCopyOperations(from->operations, from->operationCount, NULL)};
  if (to->inputs == NULL || to->operations == NULL) {
    ctExpressionFree(to);
    return false;
  }
  if (inputs > 0) {
    memcpy(to->inputs, from->inputs, inputs * sizeof(ctInput));
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

/* The same of nearest images, if there is a box. */
static double measureImages(const ctInput* input, const double (*x)[3], const PeriodicBox* box, bool* isLong) {
  const int count = ctMeasureWidth(input->measure);
  const double* points[4] = {NULL};
  double chain[4][3];
  if (box == NULL || count == 1) {
    return measure(input, x);
  }
  for (int i = 0; i < count; i++) {
    points[i] = x[input->particles[i]];
  }
  *isLong = !chainOfImages(box, count, points, chain) || *isLong;
  const ctInput ofChain = {input->measure, {0, 1, 2, 3}};
  return measure(&ofChain, (const double(*)[3])chain);
}

/* The length of a difference of positions, or of its nearest image, if there is a box. */
static double imageLength(double x, double y, double z, const PeriodicBox* box) {
  const double origin[3] = {0, 0, 0};
  double apart[3] = {x, y, z};
  if (box != NULL) {
    nearestImage(box, origin, (const double[3]){x, y, z}, apart);
  }
  return sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
}

/* As OpenMM computes it. */
static double constantPower(double base, double exponent) {
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
  const double v = operation->constant;
  switch (operation->kind) {
#define CT_CASE(name, count, value) \
  case ct##name##Operator:          \
    return value;
    CT_OPERATORS(CT_CASE)
#undef CT_CASE
    default:
      return v;
  }
}

double ctExpressionEvaluate(const Expression* expression, const double (*positions)[3], const PeriodicBox* box,
                            const double* parameters, double* results, bool* isLong) {
  *isLong = false;
  for (int i = 0; i < expression->operationCount; i++) {
    const ctOperation* operation = &expression->operations[i];
    const int* arguments = operation->arguments;
    if (operation->kind == ctInputOperator) {
      results[i] = measureImages(&expression->inputs[arguments[0]], positions, box, isLong);
    } else if (operation->kind == ctParameterOperator) {
      results[i] = parameters[arguments[0]];
    } else if (operation->kind == ctImageLengthOperator) {
      results[i] = imageLength(results[arguments[0]], results[arguments[1]], results[arguments[2]], box);
    } else {
      results[i] = ctOperate(operation, results[arguments[0]], results[arguments[1]], results[arguments[2]]);
    }
  }
  return results[expression->operationCount - 1];
}
