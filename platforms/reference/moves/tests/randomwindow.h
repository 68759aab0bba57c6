/* Windows of protein-like and of arbitrary geometry, and what their turns do, in long double. */
#ifndef RANDOMWINDOW_H_
#define RANDOMWINDOW_H_

#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "ctclosure.h"

typedef long double Real;

static uint64_t chance = 88172645463325252u;

static inline double uniform(double least, double most) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return least + (most - least) * (double)(chance >> 11) * 0x1p-53;
}

static inline void crossReal(const Real a[3], const Real b[3], Real c[3]) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static inline Real dotReal(const Real a[3], const Real b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Turns a direction about an axis. */
static inline void turnReal(const Real axis[3], Real angle, Real x[3]) {
  const Real c = cosl(angle), s = sinl(angle), along = dotReal(axis, x) * (1 - c);
  Real across[3];
  crossReal(axis, x, across);
  for (int k = 0; k < 3; k++) {
    x[k] = c * x[k] + s * across[k] + along * axis[k];
  }
}

static inline void turnPointReal(const double point[3], const double axis[3], Real angle, Real x[3]) {
  const Real square = (Real)axis[0] * axis[0] + (Real)axis[1] * axis[1] + (Real)axis[2] * axis[2];
  Real unit[3], arm[3];
  for (int k = 0; k < 3; k++) {
    unit[k] = axis[k] / sqrtl(square);
    arm[k] = x[k] - point[k];
  }
  turnReal(unit, angle, arm);
  for (int k = 0; k < 3; k++) {
    x[k] = point[k] + arm[k];
  }
}

/* How far a window is from closed, in nm: the largest displacement of a point of the tail at distance `lever` from the
 * last axis. */
static inline double gapOf(const ctWindow* window, const double* angles, double lever) {
  Real most = 0;
  const double* last = window->points[window->count - 1];
  for (int corner = 0; corner < 6; corner++) {
    Real x[3] = {last[0], last[1], last[2]};
    x[corner / 2] += corner % 2 ? lever : -lever;
    const Real start[3] = {x[0], x[1], x[2]};
    for (int i = window->count - 1; i >= 0; i--) {
      turnPointReal(window->points[i], window->axes[i], angles[i], x);
    }
    const Real d[3] = {x[0] - start[0], x[1] - start[1], x[2] - start[2]};
    const Real way = sqrtl(dotReal(d, d));
    most = way > most ? way : most;
  }
  return (double)most;
}

static inline void drawDirection(double x[3]) {
  double square;
  do {
    square = 0;
    for (int k = 0; k < 3; k++) {
      x[k] = uniform(-1, 1);
      square += x[k] * x[k];
    }
  } while (square > 1 || square < 0.01);
  for (int k = 0; k < 3; k++) {
    x[k] /= sqrt(square);
  }
}

/* A chain of atoms: each next one from a length, an angle between bonds and a dihedral. */
static inline void addAtom(double (*atoms)[3], int n, double length, double angle, double dihedral) {
  Real u[3], v[3], across[3];
  for (int k = 0; k < 3; k++) {
    u[k] = atoms[n - 2][k] - atoms[n - 3][k];
    v[k] = atoms[n - 1][k] - atoms[n - 2][k];
  }
  crossReal(u, v, across);
  const Real norm = sqrtl(dotReal(across, across)), bond = sqrtl(dotReal(v, v));
  for (int k = 0; k < 3; k++) {
    across[k] /= norm;
    v[k] /= bond;
    u[k] = v[k];
  }
  turnReal(across, PI - angle, u);
  turnReal(v, dihedral, u);
  for (int k = 0; k < 3; k++) {
    atoms[n][k] = (double)(atoms[n - 1][k] + length * u[k]);
  }
}

/* A backbone of `residues` residues, N, CA, C of each, with random torsions; omega is trans but for one in ten. */
static inline void drawBackbone(int residues, double (*atoms)[3], double shift) {
  for (int k = 0; k < 3; k++) {
    atoms[0][k] = shift * uniform(-1, 1);
  }
  double u[3], v[3];
  drawDirection(u);
  drawDirection(v);
  for (int k = 0; k < 3; k++) {
    atoms[1][k] = atoms[0][k] + 0.146 * u[k];
    atoms[2][k] = atoms[1][k] + 0.153 * v[k];
  }
  double psi = uniform(-PI, PI);
  for (int n = 3; n < 3 * residues; n++) {
    const double spread = uniform(-0.05, 0.05);
    if (n % 3 == 0) {
      addAtom(atoms, n, 0.133, 2.035 + spread, psi);
    } else if (n % 3 == 1) {
      addAtom(atoms, n, 0.146, 2.124 + spread, (uniform(0, 1) < 0.1 ? 0 : PI) + uniform(-0.2, 0.2));
    } else {
      addAtom(atoms, n, 0.153, 1.939 + spread, uniform(-PI, PI));
      psi = uniform(-PI, PI);
    }
  }
}

static inline void addTorsion(ctWindow* window, double (*atoms)[3], int from, int to) {
  double* axis = window->axes[window->count];
  double square = 0;
  for (int k = 0; k < 3; k++) {
    axis[k] = atoms[to][k] - atoms[from][k];
    square += axis[k] * axis[k];
  }
  /* The point is the alpha carbon. */
  const int alpha = from % 3 == 1 ? from : to;
  for (int k = 0; k < 3; k++) {
    axis[k] /= sqrt(square);
    window->points[window->count][k] = atoms[alpha][k];
  }
  window->count++;
}

/* A window of phi and psi along a backbone, some of them frozen, with three residues of free phi and psi as pivots. */
static inline void drawProteinWindow(ctWindow* window, int drivers, double shift) {
  enum { RESIDUES = 9 };
  double atoms[3 * RESIDUES][3];
  drawBackbone(RESIDUES, atoms, shift);
  do {
    window->count = 0;
    int found = 0;
    int free = drivers;
    for (int r = 1; r < RESIDUES; r++) {
      const bool isPivot = found < 3 && uniform(0, 1) < 0.5;
      for (int k = 0; k < 2; k++) {
        if (isPivot) {
          window->pivots[2 * found + k] = window->count;
        }
        if (isPivot || (free > 0 && uniform(0, 1) < 0.6)) {
          addTorsion(window, atoms, 3 * r + k, 3 * r + k + 1);
          free -= isPivot ? 0 : 1;
        }
      }
      found += isPivot ? 1 : 0;
    }
    window->count = found < 3 || free > 0 ? 0 : window->count;
  } while (window->count == 0);
}

/* Axes anywhere. */
static inline void drawArbitraryWindow(ctWindow* window, int drivers) {
  window->count = CT_PIVOTS + drivers;
  int corner = 0;
  int i = 0;
  while (i < window->count) {
    const int left = window->count - i - (CT_PIVOTS - 2 * corner); /* drivers to come */
    double point[3];
    for (int k = 0; k < 3; k++) {
      point[k] = uniform(-0.5, 0.5);
    }
    const bool isPivot = corner < 3 && (left == 0 || uniform(0, 1) < 0.5);
    for (int n = 0; n < (isPivot ? 2 : 1); n++) {
      memcpy(window->points[i + n], point, sizeof point);
      drawDirection(window->axes[i + n]);
      if (isPivot) {
        window->pivots[2 * corner + n] = i + n;
      }
    }
    corner += isPivot ? 1 : 0;
    i += isPivot ? 2 : 1;
  }
}

static inline void drawDrivers(const ctWindow* window, double most, double* angles) {
  int pivot = 0;
  for (int i = 0; i < window->count; i++) {
    const bool isPivot = pivot < CT_PIVOTS && window->pivots[pivot] == i;
    pivot += isPivot ? 1 : 0;
    angles[i] = isPivot ? 0 : uniform(-most, most);
  }
}

#endif /* RANDOMWINDOW_H_ */
