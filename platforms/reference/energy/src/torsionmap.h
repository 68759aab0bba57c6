/* A periodic function of two angles by bicubic patches: see ctTorsionMap. */
#ifndef CT_TORSIONMAP_H_
#define CT_TORSIONMAP_H_

#include "measure.h"

typedef struct TorsionMap {
  int size;
  double* coefficients;
} TorsionMap;

/* An angle in steps of a map, from 0 to its size; an angle from -pi to pi. */
static inline double mapSteps(const TorsionMap* map, double angle) {
  const double turned = angle < 0 ? angle + 2 * CT_PI : angle;
  return turned * (map->size / (2 * CT_PI));
}

static inline int patchOf(const TorsionMap* map, double steps) {
  return steps < map->size - 1 ? (int)steps : map->size - 1;
}

static inline double evaluateTorsionMap(const TorsionMap* map, double first, double second) {
  const double a = mapSteps(map, first);
  const double b = mapSteps(map, second);
  if (!(a >= 0 && b >= 0)) { /* not a number, so in no patch */
    return NAN;
  }
  const int s = patchOf(map, a);
  const int t = patchOf(map, b);
  const double* c = map->coefficients + 16 * ((size_t)s + (size_t)map->size * (size_t)t);
  const double u = a - s;
  const double v = b - t;
  double sum = 0;
  for (int i = 3; i >= 0; i--) {
    sum = u * sum + (((c[4 * i + 3] * v + c[4 * i + 2]) * v + c[4 * i + 1]) * v + c[4 * i]);
  }
  return sum;
}

#endif /* CT_TORSIONMAP_H_ */
