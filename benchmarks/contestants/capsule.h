/* Line-swept spheres. */
#ifndef CAPSULE_H_
#define CAPSULE_H_

#include <math.h>
#include <stdbool.h>

#include "rigid.h"

/* All points at most `radius` from the line between two ends. */
typedef struct Capsule {
  double ends[2][3];
  double radius;
} Capsule;

static inline Capsule capsuleOfSphere(double radius) {
  return (Capsule){{{0, 0, 0}, {0, 0, 0}}, radius};
}

static inline Capsule capsuleMoved(const Capsule* capsule, const Rigid* motion) {
  Capsule moved = {.radius = capsule->radius};
  rigidApply(motion, capsule->ends[0], moved.ends[0]);
  rigidApply(motion, capsule->ends[1], moved.ends[1]);
  return moved;
}

static inline double clampToUnit(double x) {
  return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Of the lines between two ends each. */
static inline double squaredLineDistance(const double a[2][3], const double b[2][3]) {
  double u[3];
  double v[3];
  double w[3];
  subtract(a[1], a[0], u);
  subtract(b[1], b[0], v);
  subtract(b[0], a[0], w);
  const double uu = dot(u, u);
  const double vv = dot(v, v);
  const double uv = dot(u, v);
  const double uw = dot(u, w);
  const double vw = dot(v, w);
  const double determinant = uu * vv - uv * uv;
  double s = determinant > 1e-12 * uu * vv ? clampToUnit((uw * vv - vw * uv) / determinant) : 0;
  const double t = vv > 0 ? clampToUnit((s * uv - vw) / vv) : 0;
  s = uu > 0 ? clampToUnit((t * uv + uw) / uu) : 0;
  double d[3];
  for (int k = 0; k < 3; k++) {
    d[k] = w[k] + t * v[k] - s * u[k];
  }
  return dot(d, d);
}

/* b is moved by `motion`. */
static inline bool capsulesOverlap(const Capsule* a, const Capsule* b, const Rigid* motion) {
  const Capsule moved = capsuleMoved(b, motion);
  const double sum = a->radius + b->radius;
  return squaredLineDistance((const double(*)[3])a->ends, (const double(*)[3])moved.ends) <= sum * sum;
}

static inline double capsuleMeasure(const Capsule* capsule) {
  const double length = sqrt(squaredDistance(capsule->ends[0], capsule->ends[1]));
  return capsule->radius * capsule->radius * (length + 4.0 / 3 * capsule->radius);
}

/* Around the four ends of two capsules, its line parallel to u, a unit vector: the line goes through the middle of
 * those two ends that are farthest apart across u. */
static inline Capsule capsuleAlong(const double u[3], const Capsule* a, const Capsule* b) {
  const double* points[4] = {a->ends[0], a->ends[1], b->ends[0], b->ends[1]};
  const double radii[4] = {a->radius, a->radius, b->radius, b->radius};
  double along[4];
  double across[4][3];
  for (int i = 0; i < 4; i++) {
    along[i] = dot(points[i], u);
    for (int k = 0; k < 3; k++) {
      across[i][k] = points[i][k] - along[i] * u[k];
    }
  }
  double middle[3] = {0, 0, 0};
  double widest = -1;
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < i; j++) {
      const double distance = sqrt(squaredDistance(across[i], across[j]));
      if (distance + radii[i] + radii[j] > widest) {
        /* the middle of the two spheres' outer sides */
        const double share = distance > 0 ? clampToUnit(0.5 + 0.5 * (radii[j] - radii[i]) / distance) : 0;
        widest = distance + radii[i] + radii[j];
        for (int k = 0; k < 3; k++) {
          middle[k] = across[i][k] + share * (across[j][k] - across[i][k]);
        }
      }
    }
  }
  Capsule capsule = {.radius = 0};
  for (int i = 0; i < 4; i++) {
    capsule.radius = fmax(capsule.radius, sqrt(squaredDistance(across[i], middle)) + radii[i]);
  }
  capsule.radius *= 1 + 1e-14;
  double low = INFINITY;
  double high = -INFINITY;
  for (int i = 0; i < 4; i++) {
    const double spare = capsule.radius - radii[i];
    const double slide = sqrt(fmax(0, spare * spare - squaredDistance(across[i], middle)));
    low = fmin(low, along[i] + slide);
    high = fmax(high, along[i] - slide);
  }
  if (low > high) {
    low = high = 0.5 * (low + high);
  }
  for (int k = 0; k < 3; k++) {
    capsule.ends[0][k] = middle[k] + low * u[k];
    capsule.ends[1][k] = middle[k] + high * u[k];
  }
  return capsule;
}

/* Around two capsules, b moved by `motion`: the best along one of the lines through two of the four ends. */
static inline Capsule capsuleOfPair(const Capsule* a, const Capsule* b, const Rigid* motion) {
  const Capsule moved = capsuleMoved(b, motion);
  const double* points[4] = {a->ends[0], a->ends[1], moved.ends[0], moved.ends[1]};
  const double x[3] = {1, 0, 0};
  Capsule best = capsuleAlong(x, a, &moved);
  double least = capsuleMeasure(&best);
  for (int i = 0; i < 4; i++) {
    for (int j = 0; j < i; j++) {
      double u[3];
      subtract(points[i], points[j], u);
      const double length = sqrt(dot(u, u));
      if (length == 0) {
        continue;
      }
      for (int k = 0; k < 3; k++) {
        u[k] /= length;
      }
      const Capsule capsule = capsuleAlong(u, a, &moved);
      const double measure = capsuleMeasure(&capsule);
      if (measure < least) {
        least = measure;
        best = capsule;
      }
    }
  }
  return best;
}

#endif /* CAPSULE_H_ */
