/* bornoracle.h: generalized Born in long double, all pairs, by the formulas of ctBorn as they stand there. */
#ifndef BORNORACLE_H_
#define BORNORACLE_H_

#include <math.h>

#include "ctenergy.h"

/* v(r; o, s) */
static inline long double oracleOverlap(long double r, long double o, long double s) {
  if (r + s < o) {
    return 0;
  }
  const long double upper = r + s;
  const long double lower = fmaxl(o, fabsl(r - s));
  return 0.5L * (1 / lower - 1 / upper + 0.25L * (r - s * s / r) * (1 / (upper * upper) - 1 / (lower * lower)) +
                 0.5L * logl(lower / upper) / r);
}

/* The same of two particles, with the additional part if spheres within others are filled. */
static inline long double oracleSpheres(const ctBorn* d, int i, int j, long double r) {
  const long double o = d->offsetRadii[i];
  const long double s = d->scaledRadii[j];
  const bool isWithin = d->isFilled && o < s - r;
  return oracleOverlap(r, o, s) + (isWithin ? 1 / o - 1 / (s - r) : 0);
}

/* What particle j contributes by its neck to the Born sum of i, neckScale included. */
static inline long double oracleNeck(const ctBorn* d, int i, int j, long double r) {
  if (d->neckTypeCount == 0 || r > (long double)d->radii[i] + d->radii[j] + d->neckCut) {
    return 0;
  }
  const int types = d->neckTypes[i] + d->neckTypeCount * d->neckTypes[j];
  const long double from = r - (long double)d->neckDistances[types];
  return d->neckScale * (long double)d->neckHeights[types] / (1 + 100 * from * from + 0.3e6L * powl(from, 6));
}

/* What particle j at a distance contributes to the Born sum of i, whatever the cutoff. */
static inline long double oracleBornPart(const ctBorn* d, int i, int j, long double r) {
  return oracleSpheres(d, i, j, r) + oracleNeck(d, i, j, r);
}

/* The vectors of the periodic box in which distances are those of nearest images, or NULL. */
static const double (*oracleBox)[3];

static inline long double oracleDistance(const double* positions, int i, int j) {
  long double apart[3];
  long double squared = 0;
  for (int k = 0; k < 3; k++) {
    apart[k] = (long double)positions[3 * i + k] - positions[3 * j + k];
  }
  for (int k = 2; k >= 0 && oracleBox != NULL; k--) {
    const long double count = floorl(apart[k] / oracleBox[k][k] + 0.5L);
    for (int d = 0; d <= k; d++) {
      apart[d] -= count * oracleBox[k][d];
    }
  }
  for (int k = 0; k < 3; k++) {
    squared += apart[k] * apart[k];
  }
  return sqrtl(squared);
}

/* The Born sum of particle i over all others that are nearer than a cutoff. */
static inline long double oracleBornSum(const ctBorn* d, int particleCount, const double* positions, int i,
                                        long double cutoff) {
  long double sum = 0;
  for (int j = 0; j < particleCount; j++) {
    const long double r = j != i ? oracleDistance(positions, i, j) : INFINITY;
    if (r < cutoff) {
      sum += oracleBornPart(d, i, j, r);
    }
  }
  return sum;
}

/* What the stand-in takes from that; see ctStandIn. */
static inline long double oracleBornTaken(const ctBorn* d, int particleCount, const double* positions, int i,
                                          long double cutoff) {
  long double taken = 0;
  for (int j = 0; j < particleCount; j++) {
    const long double r = j != i ? oracleDistance(positions, i, j) : INFINITY;
    if (r < cutoff) {
      const long double atCutoff = powl(d->scaledRadii[j], 3) / (3 * powl(cutoff, 4));
      taken += atCutoff * (-2.2L + 3.4L * r * r / (cutoff * cutoff));
    }
  }
  return taken;
}

static inline long double oracleBornRadius(const ctBorn* d, int i, long double sum) {
  const long double inverse = 1 / (long double)d->offsetRadii[i];
  if (!d->isRescaled) {
    return 1 / (inverse - sum);
  }
  const long double p = sum * d->offsetRadii[i];
  return 1 / (inverse - tanhl(d->alphas[i] * p - d->betas[i] * p * p + d->gammas[i] * p * p * p) / d->radii[i]);
}

/* -coulomb (1/soluteDielectric - exp(-kappa f) / solventDielectric) */
static inline long double oracleContrast(const ctBorn* d, long double f) {
  return -d->coulomb * (1 / (long double)d->soluteDielectric - expl(-d->kappa * f) / d->solventDielectric);
}

/* Of one particle, its surface included. */
static inline long double oracleBornSelf(const ctBorn* d, int i, long double bornRadius) {
  const long double charge = d->charges[i];
  const long double radius = d->radii[i];
  return 0.5L * oracleContrast(d, bornRadius) * charge * charge / bornRadius +
         d->surfaceEnergy * (radius + d->probeRadius) * (radius + d->probeRadius) * powl(radius / bornRadius, 6);
}

/* Of a pair with these Born radii, whatever the cutoff. */
static inline long double oracleBornPair(const ctBorn* d, int i, int j, long double r, long double bornI,
                                         long double bornJ) {
  const long double product = bornI * bornJ;
  const long double f = sqrtl(r * r + product * expl(-r * r / (4 * product)));
  return oracleContrast(d, f) * d->charges[i] * d->charges[j] * (1 / f - d->shift);
}

#endif /* BORNORACLE_H_ */
