/* Vectors of three numbers. The state is made of them, by the engine and by moves, so nothing here may be contracted to
 * fused multiply-adds. */
#ifndef CT_VECTOR_H_
#define CT_VECTOR_H_

#include <math.h>

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

/* c may be a or b. Without a loop, so that compilers keep short arrays in registers: they make vectors of loops, which
 * load at once what has been stored in parts, and a processor waits for that. */
static inline void add(double sum[3], const double x[3]) {
  sum[0] += x[0];
  sum[1] += x[1];
  sum[2] += x[2];
}

static inline void subtract(const double a[3], const double b[3], double c[3]) {
  const double x = a[0] - b[0];
  const double y = a[1] - b[1];
  const double z = a[2] - b[2];
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

/* a = a + f b */
static inline void addScaled(double a[3], double f, const double b[3]) {
  for (int k = 0; k < 3; k++) {
    a[k] += f * b[k];
  }
}

static inline void scale(double a[3], double f) {
  for (int k = 0; k < 3; k++) {
    a[k] *= f;
  }
}

#endif /* CT_VECTOR_H_ */
