/* valuescene.h: random value energies, and the same in long double. */
#ifndef VALUESCENE_H_
#define VALUESCENE_H_

#include "operatororacle.h"
#include "wholescene.h"

enum {
  PARAMETERS = 3,
  MOST_VALUES = 3,
  MOST_TERMS = 4,
  MOST_OPERATIONS = 32,
  MOST_NUMBERS = PARAMETERS + MOST_VALUES + 3
};

typedef struct ValueScene {
  WholeScene particles;
  double parameters[PARAMETERS * MOST_PARTICLES];
  ctOperation operations[MOST_VALUES + MOST_TERMS][MOST_OPERATIONS];
  ctValueExpression values[MOST_VALUES];
  ctValueExpression terms[MOST_TERMS];
  ctValueEnergy energy;
} ValueScene;

/* x^2 - 1 from -1 to 2 in three pieces; 0 outside. */
static const double squares[] = {0, -2, 1, 0, -1, 0, 1, 0, 0, 2, 1, 0};
static const ctTable squareTable = {.dimensions = 1, .sizes = {3}, .minima = {-1}, .maxima = {2}, .values = squares};

/* ---- Random expressions ---- */

/* All are smooth but for the least and the greatest, and their values are about 1. */
static const ctOperator drawnOperators[] = {ctAddOperator,          ctAddOperator,
                                            ctSubtractOperator,     ctMultiplyOperator,
                                            ctMultiplyOperator,     ctMultiplyOperator,
                                            ctTanhOperator,         ctErfOperator,
                                            ctAtanOperator,         ctSinOperator,
                                            ctCosOperator,          ctMinOperator,
                                            ctMaxOperator,          ctMultiplyConstantOperator,
                                            ctAddConstantOperator,  ctNegateOperator,
                                            ctAbsOperator,          ctTableOperator,
                                            ctSqrtOperator,         ctLogOperator,
                                            ctExpOperator,          ctDivideOperator,
                                            ctPowerOperator,        ctReciprocalOperator,
                                            ctPowerConstantOperator};

/* True for functions of numbers from 1/2 on, such as 1/2 + |a|. */
static inline bool needsPositive(ctOperator kind) {
  return kind == ctSqrtOperator || kind == ctLogOperator || kind == ctPowerOperator || kind == ctReciprocalOperator ||
         kind == ctPowerConstantOperator;
}

typedef struct Drawing {
  ctOperation* operations;
  int count;
} Drawing;

static inline int append(Drawing* d, ctOperator kind, int first, int second, double constant) {
  d->operations[d->count] = (ctOperation){kind, {first, second, 0}, constant};
  return d->count++;
}

/* At least 1/2. */
static inline int appendPositive(Drawing* d, int argument) {
  const int size = append(d, ctAbsOperator, argument, 0, 0);
  return append(d, ctAddConstantOperator, size, 0, 0.5);
}

/* Some number between -1 and 1 that is made of what an expression can read: the distance, `numberCount` numbers of the
 * one and of the other particle, coordinates. */
static inline void drawExpression(const ctValueEnergy* energy, ctValueExpression* expression, ctOperation* operations,
                                  int valueCount) {
  const bool isOfPairs = expression->extent != ctOfParticles;
  const int readable = PARAMETERS + valueCount;
  const int second = PARAMETERS + energy->valueCount;
  Drawing d = {operations, 0};
  for (int i = 0; i < 3; i++) {
    const int number = drawInt(readable);
    append(&d, ctParameterOperator, isOfPairs && i == 1 ? second + number : number, 0, 0);
  }
  if (isOfPairs) {
    append(&d, ctInputOperator, 0, 0, 0);
  } else if (drawInt(2) == 0) {
    append(&d, ctParameterOperator, PARAMETERS + energy->valueCount + drawInt(3), 0, 0);
  }
  while (d.count < MOST_OPERATIONS - 12) {
    const ctOperator kind = drawnOperators[drawInt(sizeof drawnOperators / sizeof *drawnOperators)];
    const int a = drawInt(d.count);
    const int b = drawInt(d.count);
    if (kind == ctTableOperator) {
      append(&d, kind, append(&d, ctTanhOperator, a, 0, 0), 0, 0);
    } else if (kind == ctExpOperator) {
      append(&d, kind, append(&d, ctTanhOperator, a, 0, 0), 0, 0);
    } else if (kind == ctDivideOperator) {
      append(&d, kind, a, appendPositive(&d, b), 0);
    } else if (needsPositive(kind)) {
      append(&d, kind, appendPositive(&d, a), kind == ctPowerOperator ? append(&d, ctTanhOperator, b, 0, 0) : 0,
             drawInt(5) - 2);
    } else {
      append(&d, kind, a, b, draw(-1, 1));
    }
  }
  /* All that is left is added, and falls off with the distance. */
  int sum = append(&d, ctAddOperator, d.count - 1, d.count - 2, 0);
  if (isOfPairs) {
    const int fall = append(&d, ctMultiplyConstantOperator, append(&d, ctSquareOperator, 3, 0, 0), 0, -draw(1, 20));
    sum = append(&d, ctTanhOperator, sum, 0, 0);
    append(&d, ctMultiplyOperator, sum, append(&d, ctExpOperator, fall, 0, 0), 0);
  } else {
    append(&d, ctTanhOperator, sum, 0, 0);
  }
  expression->operations = operations;
  expression->operationCount = d.count;
  expression->tables = &squareTable;
  expression->tableCount = 1;
}

static inline void drawValueScene(ValueScene* s) {
  drawWholeScene(&s->particles);
  ctValueEnergy* energy = &s->energy;
  *energy = (ctValueEnergy){.parametersPerParticle = PARAMETERS,
                            .parameters = s->parameters,
                            .valueCount = drawInt(MOST_VALUES + 1),
                            .values = s->values,
                            .termCount = drawInt(MOST_TERMS + 1),
                            .terms = s->terms,
                            .cutoff = s->particles.nonbonded.cutoff,
                            .exclusionCount = s->particles.nonbonded.exclusionCount,
                            .exclusions = s->particles.nonbonded.exclusions};
  for (int i = 0; i < PARAMETERS * s->particles.count; i++) {
    s->parameters[i] = drawInt(4) == 0 ? 0.5 : draw(i % PARAMETERS == 0 ? 0 : -1, 1);
  }
  for (int i = 0; i < energy->valueCount; i++) {
    s->values[i].extent = i == 0 ? (ctExtent)(1 + drawInt(2)) : (ctExtent)drawInt(3);
    drawExpression(energy, &s->values[i], s->operations[i], i);
  }
  for (int i = 0; i < energy->termCount; i++) {
    s->terms[i].extent = (ctExtent)drawInt(3);
    drawExpression(energy, &s->terms[i], s->operations[MOST_VALUES + i], energy->valueCount);
  }
}

/* ---- In long double ---- */

static inline long double oracleTable(long double a) {
  return a < -1 || a > 2 ? 0 : a * a - 1;
}

/* Of numbers of one particle and, for pairs, of the other. */
static inline long double oracleExpression(const ctValueExpression* e, int each, long double distance,
                                           const long double* first, const long double* second) {
  long double results[MOST_OPERATIONS];
  for (int i = 0; i < e->operationCount; i++) {
    const ctOperation* o = &e->operations[i];
    const int* n = o->arguments;
    results[i] = o->kind == ctInputOperator ? distance
                 : o->kind == ctParameterOperator
                     ? (e->extent == ctOfParticles || n[0] < each ? first[n[0]] : second[n[0] - each])
                 : o->kind == ctTableOperator
                     ? oracleTable(results[n[0]])
                     : oracleOperator(o, results[n[0]], takes(o->kind) == 2 ? results[n[1]] : 0, 0);
  }
  return results[e->operationCount - 1];
}

#endif /* VALUESCENE_H_ */
