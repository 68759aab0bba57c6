/* Oriented boxes. */
#ifndef OBB_H_
#define OBB_H_

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "rigid.h"

/* Row k of `axes` is the direction of edge k, which is twice half[k] long. */
typedef struct Obb {
  double centre[3];
  double axes[3][3];
  double half[3];
} Obb;

/* Around a sphere at the origin. */
static inline Obb obbOfSphere(double radius) {
  return (Obb){{0, 0, 0}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {radius, radius, radius}};
}

static inline Obb obbMoved(const Obb* box, const Rigid* motion) {
  Obb moved;
  rigidApply(motion, box->centre, moved.centre);
  for (int k = 0; k < 3; k++) {
    rigidRotate(motion, box->axes[k], moved.axes[k]);
    moved.half[k] = box->half[k];
  }
  return moved;
}

/* ---- Overlap ---- */

/* Whether boxes overlap, given the axes of b (columns of r) and its centre t in the frame of a: 15 candidates for a
 * separating axis (Gottschalk, Lin and Manocha, 1996). Near parallel edges their cross product is rounding; then it
 * must not separate. */
static inline bool halvesOverlap(const double a[3], const double b[3], const double r[3][3], const double t[3]) {
  double f[3][3];
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      f[i][j] = fabs(r[i][j]) + 1e-12;
    }
  }
  for (int i = 0; i < 3; i++) {
    if (fabs(t[i]) > a[i] + b[0] * f[i][0] + b[1] * f[i][1] + b[2] * f[i][2]) {
      return false;
    }
  }
  for (int j = 0; j < 3; j++) {
    if (fabs(t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j]) >
        b[j] + a[0] * f[0][j] + a[1] * f[1][j] + a[2] * f[2][j]) {
      return false;
    }
  }
  for (int i = 0; i < 3; i++) {
    const int i1 = (i + 1) % 3;
    const int i2 = (i + 2) % 3;
    for (int j = 0; j < 3; j++) {
      const int j1 = (j + 1) % 3;
      const int j2 = (j + 2) % 3;
      if (fabs(t[i2] * r[i1][j] - t[i1] * r[i2][j]) >
          a[i1] * f[i2][j] + a[i2] * f[i1][j] + b[j1] * f[i][j2] + b[j2] * f[i][j1]) {
        return false;
      }
    }
  }
  return true;
}

static inline bool obbsOverlapHere(const Obb* a, const Obb* b) {
  double r[3][3];
  double t[3];
  double d[3];
  subtract(b->centre, a->centre, d);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      r[i][j] = dot(a->axes[i], b->axes[j]);
    }
    t[i] = dot(a->axes[i], d);
  }
  return halvesOverlap(a->half, b->half, (const double(*)[3])r, t);
}

/* The same, b moved by `motion`. */
static inline bool obbsOverlap(const Obb* a, const Obb* b, const Rigid* motion) {
  const Obb moved = obbMoved(b, motion);
  return obbsOverlapHere(a, &moved);
}

/* ---- Fitting ---- */

/* How far a box reaches to both sides of its centre along a unit vector. */
static inline double obbReach(const Obb* box, const double u[3]) {
  return box->half[0] * fabs(dot(box->axes[0], u)) + box->half[1] * fabs(dot(box->axes[1], u)) +
         box->half[2] * fabs(dot(box->axes[2], u));
}

/* Makes a box reach from `low` to `high` along its axes. */
static inline void obbSetExtents(Obb* box, const double low[3], const double high[3]) {
  for (int c = 0; c < 3; c++) {
    box->centre[c] = 0;
    for (int k = 0; k < 3; k++) {
      box->centre[c] += 0.5 * (low[k] + high[k]) * box->axes[k][c];
    }
    box->half[c] = 0.5 * (high[c] - low[c]);
  }
}

/* The smallest box of these axes around two others. */
static inline Obb obbAround(const Obb* a, const Obb* b, const double axes[3][3]) {
  Obb box;
  double low[3];
  double high[3];
  for (int k = 0; k < 3; k++) {
    const double atA = dot(a->centre, axes[k]);
    const double atB = dot(b->centre, axes[k]);
    const double reachA = obbReach(a, axes[k]);
    const double reachB = obbReach(b, axes[k]);
    low[k] = fmin(atA - reachA, atB - reachB);
    high[k] = fmax(atA + reachA, atB + reachB);
    memcpy(box.axes[k], axes[k], sizeof box.axes[k]);
  }
  obbSetExtents(&box, low, high);
  return box;
}

/* Rows of `axes` become the eigenvectors of a symmetric matrix, by Jacobi's rotations; `a` is overwritten. */
static inline void eigenvectors(double a[3][3], double axes[3][3]) {
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      axes[i][j] = i == j;
    }
  }
  for (int sweep = 0; sweep < 10; sweep++) {
    const double off = fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]);
    if (off <= 1e-12 * (fabs(a[0][0]) + fabs(a[1][1]) + fabs(a[2][2]))) {
      return;
    }
    for (int p = 0; p < 2; p++) {
      for (int q = p + 1; q < 3; q++) {
        if (a[p][q] == 0) {
          continue;
        }
        const double theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
        const double c = 1 / sqrt(t * t + 1);
        const double s = t * c;
        const int o = 3 - p - q;
        const double aop = a[o][p];
        const double aoq = a[o][q];
        a[p][p] -= t * a[p][q];
        a[q][q] += t * a[p][q];
        a[p][q] = a[q][p] = 0;
        a[o][p] = a[p][o] = c * aop - s * aoq;
        a[o][q] = a[q][o] = s * aop + c * aoq;
        for (int k = 0; k < 3; k++) {
          const double x = axes[p][k];
          const double y = axes[q][k];
          axes[p][k] = c * x - s * y;
          axes[q][k] = s * x + c * y;
        }
      }
    }
  }
}

/* Around two boxes, b moved by `motion`, along the eigenvectors of the covariance of their corners. */
static inline Obb obbOfPair(const Obb* a, const Obb* b, const Rigid* motion) {
  const Obb moved = obbMoved(b, motion);
  double d[3];
  double covariance[3][3];
  double axes[3][3];
  subtract(moved.centre, a->centre, d);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      covariance[i][j] = 0.5 * d[i] * d[j];
      for (int k = 0; k < 3; k++) {
        covariance[i][j] += a->half[k] * a->half[k] * a->axes[k][i] * a->axes[k][j] +
                            moved.half[k] * moved.half[k] * moved.axes[k][i] * moved.axes[k][j];
      }
    }
  }
  eigenvectors(covariance, axes);
  return obbAround(a, &moved, (const double(*)[3])axes);
}

/* Unit vectors along a line, and across it such that the longest edge of a box lies in the plane of the first two. */
static inline bool axesAlong(const double line[3], const Obb* box, double axes[3][3]) {
  int longest = 0;
  for (int k = 1; k < 3; k++) {
    longest = box->half[k] > box->half[longest] ? k : longest;
  }
  for (int pass = 0; pass < 2; pass++) {
    const double* edge = box->axes[(longest + pass) % 3];
    cross(line, edge, axes[2]);
    cross(axes[2], line, axes[1]);
    memcpy(axes[0], line, sizeof axes[0]);
    bool success = true;
    for (int k = 0; k < 3; k++) {
      const double length = sqrt(dot(axes[k], axes[k]));
      success = success && length > 1e-6 * sqrt(dot(line, line));
      for (int c = 0; c < 3 && success; c++) {
        axes[k][c] /= length;
      }
    }
    if (success) {
      return true;
    }
  }
  return false;
}

/* An eighth of the surface. */
static inline double obbMeasure(const Obb* box) {
  return box->half[0] * box->half[1] + box->half[1] * box->half[2] + box->half[2] * box->half[0];
}

/* Around two boxes, b moved by `motion`: the best that has the axes of a, those of b, or the line between their centres
 * as one of its axes. */
static inline Obb obbByCandidates(const Obb* a, const Obb* b, const Rigid* motion) {
  const Obb moved = obbMoved(b, motion);
  Obb best = obbAround(a, &moved, a->axes);
  double least = obbMeasure(&best);
  Obb box = obbAround(a, &moved, moved.axes);
  if (obbMeasure(&box) < least) {
    best = box;
    least = obbMeasure(&box);
  }
  double line[3];
  double axes[3][3];
  subtract(moved.centre, a->centre, line);
  if (axesAlong(line, obbMeasure(a) > obbMeasure(&moved) ? a : &moved, axes)) {
    box = obbAround(a, &moved, (const double(*)[3])axes);
    if (obbMeasure(&box) < least) {
      best = box;
    }
  }
  return best;
}

#endif /* OBB_H_ */
