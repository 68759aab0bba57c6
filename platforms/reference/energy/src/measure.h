/* What terms measure of the positions of their particles. As in OpenMM, a distance of zero gives an angle that is not a
 * number, and a dihedral of three collinear particles is a quarter turn. */
#ifndef CT_MEASURE_H_
#define CT_MEASURE_H_

#include "arctangent.h"

#define CT_PI 3.14159265358979323846

/* A dihedral by its cosine and sine. */
typedef struct Dihedral {
  double cosine;
  double sine;
} Dihedral;

static inline void differenceOf(const double a[3], const double b[3], double c[3]) {
  c[0] = a[0] - b[0];
  c[1] = a[1] - b[1];
  c[2] = a[2] - b[2];
}

static inline double dotOf(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void crossOf(const double a[3], const double b[3], double c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double measureDistance(const double a[3], const double b[3]) {
  double d[3];
  differenceOf(a, b, d);
  return sqrt(dotOf(d, d));
}

/* At b, in [0, pi]. */
static inline double measureAngle(const double a[3], const double b[3], const double c[3]) {
  double u[3], v[3], normal[3];
  differenceOf(a, b, u);
  differenceOf(c, b, v);
  crossOf(u, v, normal);
  const double opposite = sqrt(dotOf(normal, normal));
  const double adjacent = dotOf(u, v);
  return opposite == 0 && adjacent == 0 ? NAN : arctangent2(opposite, adjacent);
}

static inline Dihedral measureDihedral(const double a[3], const double b[3], const double c[3], const double d[3]) {
  double u[3], axis[3], v[3], normalU[3], normalV[3];
  differenceOf(a, b, u);
  differenceOf(c, b, axis);
  differenceOf(c, d, v);
  crossOf(u, axis, normalU);
  crossOf(axis, v, normalV);
  const double x = dotOf(normalU, normalV);
  const double y = sqrt(dotOf(axis, axis)) * dotOf(u, normalV);
  const double length = sqrt(x * x + y * y);
  if (length == 0) {
    return (Dihedral){0, 1};
  }
  const double scale = 1 / length;
  return (Dihedral){x * scale, y * scale};
}

/* In [-pi, pi]. */
static inline double angleOf(Dihedral dihedral) {
  /* Adding 0 makes it pi, not -pi, where the sine is -0. */
  return arctangent2(dihedral.sine + 0.0, dihedral.cosine);
}

#endif /* CT_MEASURE_H_ */
