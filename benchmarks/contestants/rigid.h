/* Rigid transforms. */
#ifndef RIGID_H_
#define RIGID_H_

#include <math.h>

/* x -> r x + t; r is row-major. */
typedef struct Rigid {
  double r[9];
  double t[3];
} Rigid;

static inline double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void subtract(const double a[3], const double b[3], double c[3]) {
  c[0] = a[0] - b[0];
  c[1] = a[1] - b[1];
  c[2] = a[2] - b[2];
}

/* c must be neither a nor b. */
static inline void cross(const double a[3], const double b[3], double c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double squaredDistance(const double a[3], const double b[3]) {
  double d[3];
  subtract(a, b, d);
  return dot(d, d);
}

static inline Rigid rigidIdentity(void) {
  return (Rigid){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
}

/* y must not be x. */
static inline void rigidRotate(const Rigid* a, const double x[3], double y[3]) {
  y[0] = a->r[0] * x[0] + a->r[1] * x[1] + a->r[2] * x[2];
  y[1] = a->r[3] * x[0] + a->r[4] * x[1] + a->r[5] * x[2];
  y[2] = a->r[6] * x[0] + a->r[7] * x[1] + a->r[8] * x[2];
}

/* By the transpose; y must not be x. */
static inline void rigidRotateBack(const Rigid* a, const double x[3], double y[3]) {
  y[0] = a->r[0] * x[0] + a->r[3] * x[1] + a->r[6] * x[2];
  y[1] = a->r[1] * x[0] + a->r[4] * x[1] + a->r[7] * x[2];
  y[2] = a->r[2] * x[0] + a->r[5] * x[1] + a->r[8] * x[2];
}

/* y must not be x. */
static inline void rigidApply(const Rigid* a, const double x[3], double y[3]) {
  rigidRotate(a, x, y);
  y[0] += a->t[0];
  y[1] += a->t[1];
  y[2] += a->t[2];
}

/* x -> a(b(x)) */
static inline Rigid rigidCompose(const Rigid* a, const Rigid* b) {
  Rigid c;
  for (int i = 0; i < 9; i += 3) {
    for (int k = 0; k < 3; k++) {
      c.r[i + k] = a->r[i] * b->r[k] + a->r[i + 1] * b->r[3 + k] + a->r[i + 2] * b->r[6 + k];
    }
  }
  rigidApply(a, b->t, c.t);
  return c;
}

static inline Rigid rigidInvert(const Rigid* a) {
  Rigid b;
  for (int i = 0; i < 3; i++) {
    for (int k = 0; k < 3; k++) {
      b.r[3 * i + k] = a->r[3 * k + i];
    }
  }
  rigidRotate(&b, a->t, b.t);
  for (int k = 0; k < 3; k++) {
    b.t[k] = -b.t[k];
  }
  return b;
}

/* Turns by an angle, right-handed, about the line from `from` to `to`. */
static inline Rigid rigidTurn(const double from[3], const double to[3], double angle) {
  double u[3];
  subtract(to, from, u);
  const double length = sqrt(dot(u, u));
  for (int k = 0; k < 3; k++) {
    u[k] /= length;
  }
  const double c = cos(angle);
  const double s = sin(angle);
  const double v = 1 - c;
  Rigid turn = {{c + v * u[0] * u[0], v * u[0] * u[1] - s * u[2], v * u[0] * u[2] + s * u[1],
                 v * u[0] * u[1] + s * u[2], c + v * u[1] * u[1], v * u[1] * u[2] - s * u[0],
                 v * u[0] * u[2] - s * u[1], v * u[1] * u[2] + s * u[0], c + v * u[2] * u[2]},
                {0, 0, 0}};
  double turned[3];
  rigidRotate(&turn, from, turned);
  subtract(from, turned, turn.t);
  return turn;
}

#endif /* RIGID_H_ */
