/* Rotations about axes in space. */
#ifndef CT_TURNING_H_
#define CT_TURNING_H_

#include <stdbool.h>

#include "angle.h"
#include "vector.h"

/* x -> R x + t */
typedef struct Turning {
  double r[3][3];
  double t[3];
} Turning;

static inline void turnDirection(const Turning* a, const double x[3], double y[3]) {
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  for (int k = 0; k < 3; k++) {
    y[k] = a->r[k][0] * x0 + a->r[k][1] * x1 + a->r[k][2] * x2;
  }
}

static inline void turnPoint(const Turning* a, const double x[3], double y[3]) {
  turnDirection(a, x, y);
  for (int k = 0; k < 3; k++) {
    y[k] += a->t[k];
  }
}

/* The rotation by `angle` about a unit vector through a point. */
static inline Turning turningAbout(const double point[3], const double axis[3], double angle) {
  const Angle half = angleOfAny(0.5 * angle);
  const double c = half.cosine;
  const double x = half.sine * axis[0], y = half.sine * axis[1], z = half.sine * axis[2];
  Turning a = {{{1 - 2 * (y * y + z * z), 2 * (x * y - c * z), 2 * (x * z + c * y)},
                {2 * (x * y + c * z), 1 - 2 * (x * x + z * z), 2 * (y * z - c * x)},
                {2 * (x * z - c * y), 2 * (y * z + c * x), 1 - 2 * (x * x + y * y)}},
               {0}};
  double turned[3];
  turnDirection(&a, point, turned);
  subtract(point, turned, a.t);
  return a;
}

/* Makes a the transform x -> a(b(x)). */
static inline void turnFirst(Turning* a, const Turning* b) {
  Turning c;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      c.r[i][j] = a->r[i][0] * b->r[0][j] + a->r[i][1] * b->r[1][j] + a->r[i][2] * b->r[2][j];
    }
  }
  turnPoint(a, b->t, c.t);
  *a = c;
}

#endif /* CT_TURNING_H_ */
