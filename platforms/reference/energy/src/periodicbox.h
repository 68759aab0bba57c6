/* Nearest images of positions that terms measure. */
#ifndef CT_PERIODICBOX_H_
#define CT_PERIODICBOX_H_

#include <math.h>
#include <stdbool.h>

typedef struct PeriodicBox {
  double vectors[3][3];
  double squaredHalf; /* of half its width: shorter differences are of nearest images */
} PeriodicBox;

static inline PeriodicBox makePeriodicBox(const double vectors[3][3]) {
  PeriodicBox box;
  double width = INFINITY;
  for (int k = 0; k < 3; k++) {
    for (int d = 0; d < 3; d++) {
      box.vectors[k][d] = vectors[k][d];
    }
    width = fmin(width, vectors[k][k]);
  }
  box.squaredHalf = width * width / 4;
  return box;
}

/* Writes the image of x that OpenMM takes for the nearest to another point. False if x may be another one. */
static inline bool nearestImage(const PeriodicBox* box, const double about[3], const double x[3], double image[3]) {
  double apart[3];
  double squared = 0;
  for (int d = 0; d < 3; d++) {
    apart[d] = x[d] - about[d];
    squared += apart[d] * apart[d];
    image[d] = x[d];
  }
  if (squared < box->squaredHalf) {
    return true;
  }
  for (int k = 2; k >= 0; k--) {
    const double count = floor(apart[k] / box->vectors[k][k] + 0.5);
    for (int d = 0; d <= k; d++) {
      apart[d] -= count * box->vectors[k][d];
    }
  }
  for (int d = 0; d < 3; d++) {
    image[d] = about[d] + apart[d];
  }
  return false;
}

/* Writes some points as a chain: each by the image that is nearest to the one before. False if that may change one. */
static inline bool chainOfImages(const PeriodicBox* box, int count, const double* const points[], double chain[][3]) {
  bool isShort = true;
  for (int i = 0; i < count; i++) {
    for (int d = 0; d < 3; d++) {
      chain[i][d] = points[i][d];
    }
    if (i > 0) {
      isShort = nearestImage(box, chain[i - 1], points[i], chain[i]) && isShort;
    }
  }
  return isShort;
}

#endif /* CT_PERIODICBOX_H_ */
