/* Rigid transforms. The whole state goes through here, so this code must not be contracted to fused multiply-adds: the
 * same state has the same bits with every instruction set. */
#ifndef CT_TRANSFORM_H_
#define CT_TRANSFORM_H_

#include <math.h>
#include <string.h>

#include "angle.h"
#include "chaintree.h"
#include "inline.h"
#include "vector.h"

/* A rigid transform x -> R x + t: columns 0 to 2 are R, column 3 is t. A row fills a vector register. */
typedef struct Frame {
  double m[3][4];
} Frame;

/* The lesser of two numbers that are not NaN. The library's fmin and fmax are calls. */
static inline double lesser(double a, double b) {
  return a < b ? a : b;
}

static inline double larger(double a, double b) {
  return a > b ? a : b;
}

static inline double squaredDistance(const double a[3], const double b[3]) {
  double d[3];
  subtract(a, b, d);
  return dot(d, d);
}

/* Rotates b; c may be b. */
static inline void rotate(const Frame* t, const double b[3], double c[3]) {
  const double x = t->m[0][0] * b[0] + t->m[0][1] * b[1] + t->m[0][2] * b[2];
  const double y = t->m[1][0] * b[0] + t->m[1][1] * b[1] + t->m[1][2] * b[2];
  const double z = t->m[2][0] * b[0] + t->m[2][1] * b[1] + t->m[2][2] * b[2];
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

/* Rotates b by the transpose; c may be b. */
static inline void rotateBack(const Frame* t, const double b[3], double c[3]) {
  const double x = t->m[0][0] * b[0] + t->m[1][0] * b[1] + t->m[2][0] * b[2];
  const double y = t->m[0][1] * b[0] + t->m[1][1] * b[1] + t->m[2][1] * b[2];
  const double z = t->m[0][2] * b[0] + t->m[1][2] * b[1] + t->m[2][2] * b[2];
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

static inline Frame transformIdentity(void) {
  return (Frame){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

/* True if a frame turns nothing. */
static inline bool isTranslation(const Frame* t) {
  return t->m[0][0] == 1 && t->m[1][1] == 1 && t->m[2][2] == 1;
}

static inline void translationOf(const Frame* t, double x[3]) {
  x[0] = t->m[0][3];
  x[1] = t->m[1][3];
  x[2] = t->m[2][3];
}

static inline void setTranslation(Frame* t, const double x[3]) {
  t->m[0][3] = x[0];
  t->m[1][3] = x[1];
  t->m[2][3] = x[2];
}

/* Transforms x; y may be x. */
static inline void transformPoint(const Frame* t, const double x[3], double y[3]) {
  rotate(t, x, y);
  y[0] += t->m[0][3];
  y[1] += t->m[1][3];
  y[2] += t->m[2][3];
}

/* Transforms x by the inverse; y may be x. */
static inline void transformPointBack(const Frame* t, const double x[3], double y[3]) {
  double shift[3];
  translationOf(t, shift);
  subtract(x, shift, y);
  rotateBack(t, y, y);
}

/* A frame by its columns: products with these need no shuffling of lanes. The fourth lane is 0. */
typedef double Column __attribute__((vector_size(32)));

typedef struct Columns {
  Column column[4];
} Columns;

CT_INLINE void columnsOf(const Frame* t, Columns* columns) {
  for (int j = 0; j < 4; j++) {
    columns->column[j] = (Column){t->m[0][j], t->m[1][j], t->m[2][j], 0};
  }
}

CT_INLINE Frame frameOfColumns(const Columns* columns) {
  Frame t;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 4; j++) {
      t.m[i][j] = columns->column[j][i];
    }
  }
  return t;
}

/* Transforms x; y may be x. */
CT_INLINE void columnsPoint(const Columns* a, const double x[3], double y[3]) {
  const Column point = a->column[0] * x[0] + a->column[1] * x[1] + (a->column[2] * x[2] + a->column[3]);
  y[0] = point[0];
  y[1] = point[1];
  y[2] = point[2];
}

/* Makes a the transform x -> a(b(x)). b is given by the entries of its m, `stride` apart. */
CT_INLINE void columnsCompose(Columns* a, const double* b, size_t stride) {
  const Column x = a->column[0];
  const Column y = a->column[1];
  const Column z = a->column[2];
  for (size_t j = 0; j < 3; j++) {
    a->column[j] = x * b[j * stride] + y * b[(4 + j) * stride] + z * b[(8 + j) * stride];
  }
  a->column[3] = x * b[3 * stride] + y * b[7 * stride] + (z * b[11 * stride] + a->column[3]);
}

/* x -> a(b(x)) */
static inline Frame transformCompose(const Frame* a, const Frame* b) {
  Column rows[3];
  for (int i = 0; i < 3; i++) { /* all at once, they would go by way of the stack */
    memcpy(&rows[i], b->m[i], sizeof rows[i]);
  }
  Frame c;
  for (int i = 0; i < 3; i++) {
    Column row = a->m[i][0] * rows[0] + a->m[i][1] * rows[1] + a->m[i][2] * rows[2];
    row += (Column){-0.0, -0.0, -0.0, a->m[i][3]}; /* adding -0 changes no bit */
    memcpy(c.m[i], &row, sizeof row);
  }
  return c;
}

static inline Frame transformInverse(const Frame* a) {
  Frame c;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      c.m[i][j] = a->m[j][i];
    }
  }
  const double back[3] = {-a->m[0][3], -a->m[1][3], -a->m[2][3]};
  double shift[3];
  rotate(&c, back, shift);
  setTranslation(&c, shift);
  return c;
}

/* The factor that makes an axis the Rodrigues vector of a turn about it, whose length is the tangent of half the angle.
 */
static inline double rodriguesFactor(const double axis[3], double angle) {
  const Angle half = angleOfAny(0.5 * angle);
  return half.sine / (half.cosine * sqrt(dot(axis, axis)));
}

/* Writes the right-handed rotation of a Rodrigues vector into entries of Frame.m that are `stride` apart. */
static inline void rotationFromRodrigues(double wx, double wy, double wz, double* m, size_t stride) {
  const double f = 2 / (1 + (wx * wx + wy * wy + wz * wz));
  const double x = f * wx;
  const double y = f * wy;
  const double z = f * wz;
  m[0] = 1 - (y * wy + z * wz);
  m[stride] = x * wy - z;
  m[2 * stride] = x * wz + y;
  m[4 * stride] = x * wy + z;
  m[5 * stride] = 1 - (x * wx + z * wz);
  m[6 * stride] = y * wz - x;
  m[8 * stride] = x * wz - y;
  m[9 * stride] = y * wz + x;
  m[10 * stride] = 1 - (x * wx + y * wy);
}

/* Makes t its own rotation, but about a point. */
static inline void transformAbout(const double point[3], Frame* t) {
  double turned[3];
  rotate(t, point, turned);
  t->m[0][3] = point[0] - turned[0];
  t->m[1][3] = point[1] - turned[1];
  t->m[2][3] = point[2] - turned[2];
}

/* Unit quaternion (w, x, y, z) of a rotation vector. */
static inline void quaternionFromVector(const double v[3], double q[4]) {
  const double angle = sqrt(dot(v, v));
  /* sin(a/2)/a = 1/2 - a^2/48 + ...: below 1e-8 the second term is less than 3e-18, far below the rounding of 1/2. */
  const Angle half = angleOfAny(0.5 * angle);
  const double factor = angle > 1e-8 ? half.sine / angle : 0.5;
  q[0] = half.cosine;
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

/* Writes the rotation of a unit quaternion into entries of Frame.m that are `stride` apart. */
static inline void rotationFromUnit(double w, double x, double y, double z, double* m, size_t stride) {
  const double x2 = x + x;
  const double y2 = y + y;
  const double z2 = z + z;
  m[0] = 1 - (y * y2 + z * z2);
  m[stride] = x * y2 - w * z2;
  m[2 * stride] = x * z2 + w * y2;
  m[4 * stride] = x * y2 + w * z2;
  m[5 * stride] = 1 - (x * x2 + z * z2);
  m[6 * stride] = y * z2 - w * x2;
  m[8 * stride] = x * z2 - w * y2;
  m[9 * stride] = y * z2 + w * x2;
  m[10 * stride] = 1 - (x * x2 + y * y2);
}

/* Makes the rotation of t that of a unit quaternion. */
static inline void rotationFromQuaternion(const double q[4], Frame* t) {
  rotationFromUnit(q[0], q[1], q[2], q[3], t->m[0], 1);
}

#endif /* CT_TRANSFORM_H_ */
