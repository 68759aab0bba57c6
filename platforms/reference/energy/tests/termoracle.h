/* termoracle.h: values of terms from all positions in long double, written from their formulas. */
#ifndef TERMORACLE_H_
#define TERMORACLE_H_

#include <math.h>
#include <stdlib.h>

#include "operatororacle.h"

enum { MOST_GROUPS = 8 };

#define LONG_PI 3.14159265358979323846264338327950288L

typedef struct LongVector {
  long double x[3];
} LongVector;

static inline LongVector between(const double* positions, int from, int to) {
  LongVector v;
  for (int d = 0; d < 3; d++) {
    v.x[d] = (long double)positions[3 * to + d] - (long double)positions[3 * from + d];
  }
  return v;
}

static inline long double longDot(LongVector a, LongVector b) {
  return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static inline LongVector longCross(LongVector a, LongVector b) {
  return (LongVector){
      {a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

/* Without its part along an axis. */
static inline LongVector normalPart(LongVector v, LongVector axis) {
  const long double along = longDot(v, axis) / longDot(axis, axis);
  return (LongVector){{v.x[0] - along * axis.x[0], v.x[1] - along * axis.x[1], v.x[2] - along * axis.x[2]}};
}

static inline long double oracleDistance(const double* positions, const int* p) {
  const LongVector v = between(positions, p[0], p[1]);
  return sqrtl(longDot(v, v));
}

static inline long double oracleAngle(const double* positions, const int* p) {
  const LongVector u = between(positions, p[1], p[0]);
  const LongVector v = between(positions, p[1], p[2]);
  const long double cosine = longDot(u, v) / sqrtl(longDot(u, u) * longDot(v, v));
  const LongVector normal = longCross(u, v);
  const long double sine = sqrtl(longDot(normal, normal) / (longDot(u, u) * longDot(v, v)));
  return fabsl(cosine) < 0.7L ? acosl(cosine) : cosine > 0 ? asinl(sine) : LONG_PI - asinl(sine);
}

/* By the IUPAC: the angle from the bond in front to the bond behind, clockwise along the axis. */
static inline long double oracleDihedral(const double* positions, const int* p) {
  const LongVector axis = between(positions, p[1], p[2]);
  const LongVector front = normalPart(between(positions, p[1], p[0]), axis);
  const LongVector back = normalPart(between(positions, p[2], p[3]), axis);
  const long double length = sqrtl(longDot(axis, axis));
  return atan2l(longDot(axis, longCross(front, back)) / length, longDot(front, back));
}

static inline long double oracleMeasure(const ctInput* input, const double* positions, const int* particles) {
  int p[4];
  for (int i = 0; i < 4; i++) {
    const int count = input->measure <= ctMeasureZ ? 1 : (int)input->measure - (int)ctMeasureZ + 1;
    p[i] = i < count ? particles[input->particles[i]] : 0;
  }
  switch (input->measure) {
    case ctMeasureDistance:
      return oracleDistance(positions, p);
    case ctMeasureAngle:
      return oracleAngle(positions, p);
    case ctMeasureDihedral:
      return oracleDihedral(positions, p);
    default:
      return positions[3 * p[0] + (int)input->measure];
  }
}

/* The result of one operation, from those before by recursion. */
static inline long double oracleOperation(const ctExpression* e, int number, const double* positions,
                                          const int* particles, const double* parameters) {
  const ctOperation* operation = &e->operations[number];
  switch (operation->kind) {
    case ctConstantOperator:
      return operation->constant;
    case ctInputOperator:
      return oracleMeasure(&e->inputs[operation->arguments[0]], positions, particles);
    case ctParameterOperator:
      return parameters[operation->arguments[0]];
    default:
      break;
  }
  long double results[3] = {0, 0, 0};
  for (int i = 0; i < takes(operation->kind); i++) {
    results[i] = oracleOperation(e, operation->arguments[i], positions, particles, parameters);
  }
  return oracleOperator(operation, results[0], results[1], results[2]);
}

static inline long double oracleMap(const ctTorsionMap* map, long double first, long double second) {
  const long double step = 2 * LONG_PI / map->size;
  const long double a = (first < 0 ? first + 2 * LONG_PI : first) / step;
  const long double b = (second < 0 ? second + 2 * LONG_PI : second) / step;
  const int s = (int)a % map->size;
  const int t = (int)b % map->size;
  long double sum = 0;
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < 4; j++) {
      sum += map->coefficients[16 * (s + map->size * t) + 4 * i + j] * powl(a - s, i) * powl(b - t, j);
    }
  }
  return sum;
}

/* The value of an expression whose particles are centroids of groups. */
static inline long double oracleCentroids(const ctTermSet* set, const double* positions, const int* p,
                                          const double* parameters) {
  const double* weights = parameters + set->parametersPerTerm - set->particlesPerTerm;
  double centroids[3 * MOST_GROUPS];
  int groups[MOST_GROUPS];
  for (int g = 0; g < set->groupsPerTerm; g++) {
    const int size = set->particlesPerTerm / set->groupsPerTerm;
    groups[g] = g;
    for (int d = 0; d < 3; d++) {
      long double sum = 0;
      long double total = 0;
      for (int i = g * size; i < (g + 1) * size; i++) {
        sum += (long double)weights[i] * positions[3 * p[i] + d];
        total += weights[i];
      }
      centroids[3 * g + d] = (double)(sum / total);
    }
  }
  return oracleOperation(set->expression, set->expression->operationCount - 1, centroids, groups, parameters);
}

/* The value of a term at 3 coordinates a particle. */
static inline long double oracleTerm(const ctTermSet* set, int term, const double* positions) {
  const int* p = set->particles + (size_t)term * (size_t)set->particlesPerTerm;
  const double* c = set->parameters + (size_t)term * (size_t)set->parametersPerTerm;
  switch (set->kind) {
    case ctHarmonicBondTerm:
      return 0.5L * c[1] * powl(oracleDistance(positions, p) - c[0], 2);
    case ctHarmonicAngleTerm:
      return 0.5L * c[1] * powl(oracleAngle(positions, p) - c[0], 2);
    case ctPeriodicTorsionTerm:
      return c[2] * (1 + cosl(c[0] * oracleDihedral(positions, p) - c[1]));
    case ctRyckaertBellemansTerm: {
      long double sum = 0;
      for (int i = 0; i < 6; i++) {
        sum += c[i] * powl(cosl(oracleDihedral(positions, p) - LONG_PI), i);
      }
      return sum;
    }
    case ctTorsionMapTerm:
      return oracleMap(&set->maps[(int)c[0]], oracleDihedral(positions, p), oracleDihedral(positions, p + 4));
    case ctExceptionTerm: {
      const long double r = oracleDistance(positions, p);
      return 4 * c[2] * (powl(c[1] / r, 12) - powl(c[1] / r, 6)) + CT_COULOMB * c[0] / r;
    }
    case ctExpressionTerm:
      return oracleOperation(set->expression, set->expression->operationCount - 1, positions, p, c);
    case ctCentroidTerm:
      return oracleCentroids(set, positions, p, c);
  }
  abort();
}

#endif /* TERMORACLE_H_ */
