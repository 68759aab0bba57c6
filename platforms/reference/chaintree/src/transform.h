/* Rigid transforms. Everything the state is made of goes through here, so this code must not be contracted to fused
 * multiply-adds: the same state has the same bits on every machine path. */
#ifndef CT_TRANSFORM_H_
#define CT_TRANSFORM_H_

#include <math.h>

#include "chaintree.h"

/* Of two numbers neither of which is NaN; fmin and fmax are calls. */
static inline double lesser(double a, double b) {
  return a < b ? a : b;
}

static inline double larger(double a, double b) {
  return a > b ? a : b;
}

static inline double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double a[3], const double b[3], double c[3]) {
  const double x = a[1] * b[2] - a[2] * b[1];
  const double y = a[2] * b[0] - a[0] * b[2];
  const double z = a[0] * b[1] - a[1] * b[0];
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

static inline void subtract(const double a[3], const double b[3], double c[3]) {
  c[0] = a[0] - b[0];
  c[1] = a[1] - b[1];
  c[2] = a[2] - b[2];
}

static inline double squaredDistance(const double a[3], const double b[3]) {
  double d[3];
  subtract(a, b, d);
  return dot(d, d);
}

/* c may be b. */
static inline void rotate(const double r[9], const double b[3], double c[3]) {
  const double x = r[0] * b[0] + r[1] * b[1] + r[2] * b[2];
  const double y = r[3] * b[0] + r[4] * b[1] + r[5] * b[2];
  const double z = r[6] * b[0] + r[7] * b[1] + r[8] * b[2];
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

/* By the transpose; c may be b. */
static inline void rotateBack(const double r[9], const double b[3], double c[3]) {
  const double x = r[0] * b[0] + r[3] * b[1] + r[6] * b[2];
  const double y = r[1] * b[0] + r[4] * b[1] + r[7] * b[2];
  const double z = r[2] * b[0] + r[5] * b[1] + r[8] * b[2];
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

static inline ctTransform transformIdentity(void) {
  return (ctTransform){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
}

/* y may be x. */
static inline void transformPoint(const ctTransform* t, const double x[3], double y[3]) {
  rotate(t->rotation, x, y);
  y[0] += t->translation[0];
  y[1] += t->translation[1];
  y[2] += t->translation[2];
}

static inline void transformPointBack(const ctTransform* t, const double x[3], double y[3]) {
  subtract(x, t->translation, y);
  rotateBack(t->rotation, y, y);
}

/* x -> a(b(x)) */
static inline ctTransform transformCompose(const ctTransform* a, const ctTransform* b) {
  ctTransform c;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      c.rotation[3 * i + j] = a->rotation[3 * i] * b->rotation[j] + a->rotation[3 * i + 1] * b->rotation[3 + j] +
                              a->rotation[3 * i + 2] * b->rotation[6 + j];
    }
  }
  transformPoint(a, b->translation, c.translation);
  return c;
}

static inline ctTransform transformInverse(const ctTransform* a) {
  ctTransform c;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      c.rotation[3 * i + j] = a->rotation[3 * j + i];
    }
  }
  const double back[3] = {-a->translation[0], -a->translation[1], -a->translation[2]};
  rotate(c.rotation, back, c.translation);
  return c;
}

/* Rotation about a unit axis by an angle of this cosine and sine, right-handed. */
static inline void rotationAbout(const double u[3], double cosine, double sine, double r[9]) {
  const double t = 1 - cosine;
  r[0] = cosine + t * u[0] * u[0];
  r[1] = t * u[0] * u[1] - sine * u[2];
  r[2] = t * u[0] * u[2] + sine * u[1];
  r[3] = t * u[0] * u[1] + sine * u[2];
  r[4] = cosine + t * u[1] * u[1];
  r[5] = t * u[1] * u[2] - sine * u[0];
  r[6] = t * u[0] * u[2] - sine * u[1];
  r[7] = t * u[1] * u[2] + sine * u[0];
  r[8] = cosine + t * u[2] * u[2];
}

/* Makes t the rotation t->rotation about a point, followed by a shift. */
static inline void transformAbout(const double point[3], const double shift[3], ctTransform* t) {
  double turned[3];
  rotate(t->rotation, point, turned);
  for (int k = 0; k < 3; k++) {
    t->translation[k] = point[k] - turned[k] + shift[k];
  }
}

/* Unit quaternion (w, x, y, z) of a rotation vector. */
static inline void quaternionFromVector(const double v[3], double q[4]) {
  const double angle = sqrt(dot(v, v));
  /* sin(a/2)/a tends to 1/2; below this angle the next term is lost in rounding. */
  const double factor = angle > 1e-8 ? sin(0.5 * angle) / angle : 0.5;
  q[0] = cos(0.5 * angle);
  q[1] = factor * v[0];
  q[2] = factor * v[1];
  q[3] = factor * v[2];
}

/* c = a b, normalised; c may be a or b. */
static inline void quaternionMultiply(const double a[4], const double b[4], double c[4]) {
  const double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  const double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  const double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  const double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
  const double norm = sqrt(w * w + x * x + y * y + z * z);
  c[0] = w / norm;
  c[1] = x / norm;
  c[2] = y / norm;
  c[3] = z / norm;
}

static inline void rotationFromQuaternion(const double q[4], double r[9]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  r[0] = 1 - 2 * (y * y + z * z);
  r[1] = 2 * (x * y - w * z);
  r[2] = 2 * (x * z + w * y);
  r[3] = 2 * (x * y + w * z);
  r[4] = 1 - 2 * (x * x + z * z);
  r[5] = 2 * (y * z - w * x);
  r[6] = 2 * (x * z - w * y);
  r[7] = 2 * (y * z + w * x);
  r[8] = 1 - 2 * (x * x + y * y);
}

#endif /* CT_TRANSFORM_H_ */
