#include "ctvelocities.h"

#include <stddef.h>
#include <string.h>

#include "vector.h"

/* Directions whose cosine is within this of -1 define no plane. */
static const double OPPOSITE = 1e-9;

static const double IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* c = a b^T; c may be a or b. */
static void multiplyByTranspose(const double a[9], const double b[9], double c[9]) {
  double product[9];
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      product[3 * i + j] = dot(a + 3 * i, b + 3 * j);
    }
  }
  memcpy(c, product, sizeof product);
}

/* c may be b. */
static void rotate(const double rotation[9], const double b[3], double c[3]) {
  const double x = dot(rotation, b);
  const double y = dot(rotation + 3, b);
  const double z = dot(rotation + 6, b);
  c[0] = x;
  c[1] = y;
  c[2] = z;
}

bool ctFindTurns(int count, const double (*before)[9], double (*after)[9]) {
  if (before == NULL || after == NULL) {
    return false;
  }
  bool isTurned = false;
  for (int i = 0; i < count; i++) {
    if (memcmp(before[i], after[i], sizeof after[i]) == 0) {
      memcpy(after[i], IDENTITY, sizeof after[i]);
    } else {
      multiplyByTranspose(after[i], before[i], after[i]);
      isTurned = true;
    }
  }
  return isTurned;
}

void ctTurnVelocities(int particleCount, const int* particleBodies, const double (*turns)[9], double* velocities) {
  if (particleBodies == NULL || turns == NULL || velocities == NULL) {
    return;
  }
  for (int i = 0; i < particleCount; i++) {
    double* v = velocities + 3 * (size_t)i;
    rotate(turns[particleBodies[i]], v, v);
  }
}

/* Solves a y = b by Cramer's rule. */
static void solve(const double a[9], const double b[3], double y[3]) {
  double minors[3][3]; /* rows of the adjugate's transpose */
  cross(a + 3, a + 6, minors[0]);
  cross(a + 6, a, minors[1]);
  cross(a, a + 3, minors[2]);
  const double determinant = dot(a, minors[0]);
  for (int k = 0; k < 3; k++) {
    y[k] = (minors[0][k] * b[0] + minors[1][k] * b[1] + minors[2][k] * b[2]) / determinant;
  }
}

void ctTurnVelocitiesKeepingMomentum(int particleCount, const int* particleBodies, const double (*turns)[9],
                                     const double* masses, double* velocities) {
  if (particleBodies == NULL || turns == NULL || masses == NULL || velocities == NULL) {
    return;
  }
  double mass = 0;
  double drift[3] = {0};
  int heaviest = 0;
  for (int i = 0; i < particleCount; i++) {
    mass += masses[i];
    addScaled(drift, masses[i], velocities + 3 * (size_t)i);
    if (masses[i] > masses[heaviest]) {
      heaviest = i;
    }
  }
  if (!(mass > 0)) {
    ctTurnVelocities(particleCount, particleBodies, turns, velocities);
    return;
  }
  scale(drift, 1 / mass);

  const double* pivotal = turns[particleBodies[heaviest]];
  double meanTurn[9] = {0};
  double mean[3] = {0};
  for (int i = 0; i < particleCount; i++) {
    if (masses[i] == 0) {
      continue;
    }
    double* v = velocities + 3 * (size_t)i;
    const double* turn = turns[particleBodies[i]];
    subtract(v, drift, v);
    rotate(turn, v, v);
    addScaled(mean, masses[i] / mass, v);
    for (int k = 0; k < 9; k++) {
      meanTurn[k] += masses[i] / mass * turn[k];
    }
  }
  double matrix[9];
  multiplyByTranspose(meanTurn, pivotal, matrix);
  for (int k = 0; k < 9; k++) {
    matrix[k] += IDENTITY[k];
  }
  double y[3];
  double inPivotal[3]; /* Q^T y */
  solve(matrix, mean, y);
  for (int k = 0; k < 3; k++) {
    inPivotal[k] = pivotal[k] * y[0] + pivotal[3 + k] * y[1] + pivotal[6 + k] * y[2];
  }
  for (int i = 0; i < particleCount; i++) {
    double* v = velocities + 3 * (size_t)i;
    double shift[3];
    if (masses[i] == 0) {
      rotate(turns[particleBodies[i]], v, v);
      continue;
    }
    rotate(turns[particleBodies[i]], inPivotal, shift);
    for (int k = 0; k < 3; k++) {
      v[k] += drift[k] - y[k] - shift[k];
    }
  }
}

/* The sum of m a . b. */
static double product(int particleCount, const double* masses, const double* a, const double* b) {
  double sum = 0;
  for (int i = 0; i < particleCount; i++) {
    sum += masses[i] * dot(a + 3 * (size_t)i, b + 3 * (size_t)i);
  }
  return sum;
}

void ctRotateVelocities(int particleCount, const double* masses, const double* from, const double* to,
                        double* velocities) {
  if (masses == NULL || from == NULL || to == NULL || velocities == NULL) {
    return;
  }
  const double lengthFrom = sqrt(product(particleCount, masses, from, from));
  const double lengthTo = sqrt(product(particleCount, masses, to, to));
  if (!(lengthFrom > 0 && lengthTo > 0)) {
    return;
  }
  /* With unit vectors a and b and s = a + b: v' = v - s (s . v) / (1 + a . b) + 2 b (a . v). */
  const double cosine = product(particleCount, masses, from, to) / (lengthFrom * lengthTo);
  if (!(1 + cosine > OPPOSITE)) {
    return;
  }
  const double alongFrom = product(particleCount, masses, from, velocities) / lengthFrom;
  const double alongTo = product(particleCount, masses, to, velocities) / lengthTo;
  const double alongSum = (alongFrom + alongTo) / (1 + cosine);
  for (int i = 0; i < 3 * particleCount; i++) {
    const double unitFrom = from[i] / lengthFrom;
    const double unitTo = to[i] / lengthTo;
    velocities[i] += 2 * alongFrom * unitTo - alongSum * (unitFrom + unitTo);
  }
}
