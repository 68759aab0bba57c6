#include "ctlocal.h"

#include <stddef.h>

#include "turning.h"

/* The derivatives of the ends' positions by the angle of a torsion. */
static void differentiate(const ctLocalWindow* window, int torsion, double derivatives[CT_LOCAL_ENDS][3]) {
  for (int k = 0; k < CT_LOCAL_ENDS; k++) {
    double arm[3];
    subtract(window->ends[k], window->points[torsion], arm);
    cross(window->axes[torsion], arm, derivatives[k]);
  }
}

static bool isCount(int count) {
  return count >= 1 && count <= CT_LOCAL_MOST;
}

bool ctFindLocalSteps(const ctLocalWindow* window, double sigma, double stiffness, ctLocalSteps* steps) {
  if (steps == NULL) {
    return false;
  }
  steps->count = 0;
  if (window == NULL || !isCount(window->count) || !(sigma > 0) || !(sigma < INFINITY) || !(stiffness >= 0)) {
    return false;
  }
  const int count = window->count;
  steps->sigma = sigma;
  double derivatives[CT_LOCAL_MOST][CT_LOCAL_ENDS][3];
  for (int i = 0; i < count; i++) {
    differentiate(window, i, derivatives[i]);
  }
  /* Cholesky's way, row by row. */
  for (int i = 0; i < count; i++) {
    double* row = steps->factor[i];
    for (int j = 0; j <= i; j++) {
      const double* other = steps->factor[j];
      double sum = 0;
      for (int k = 0; k < CT_LOCAL_ENDS; k++) {
        sum += dot(derivatives[i][k], derivatives[j][k]);
      }
      sum = stiffness * sum + (i == j ? 1 : 0);
      for (int k = 0; k < j; k++) {
        sum -= row[k] * other[k];
      }
      if (j < i) {
        row[j] = sum / other[j];
      } else if (sum > 0 && sum < INFINITY) {
        row[i] = sqrt(sum);
      } else {
        return false;
      }
    }
  }
  steps->count = count;
  return true;
}

void ctDrawLocalStep(const ctLocalSteps* steps, const double* normals, double* changes) {
  if (steps == NULL || normals == NULL || changes == NULL || !isCount(steps->count)) {
    return;
  }
  /* L^T d = sigma z, from the last row upwards. */
  for (int i = steps->count - 1; i >= 0; i--) {
    double sum = steps->sigma * normals[i];
    for (int k = i + 1; k < steps->count; k++) {
      sum -= steps->factor[k][i] * changes[k];
    }
    changes[i] = sum / steps->factor[i][i];
  }
}

double ctComputeLocalLogDensity(const ctLocalSteps* steps, const double* changes) {
  if (steps == NULL || changes == NULL || !isCount(steps->count)) {
    return NAN;
  }
  double logarithm = 0;
  double squares = 0;
  for (int i = 0; i < steps->count; i++) {
    double sum = 0;
    for (int k = i; k < steps->count; k++) {
      sum += steps->factor[k][i] * changes[k];
    }
    sum /= steps->sigma;
    squares += sum * sum;
    logarithm += log(steps->factor[i][i] / steps->sigma);
  }
  return logarithm - 0.5 * squares;
}

void ctTurnLocalWindow(const ctLocalWindow* window, const double* changes, ctLocalWindow* turned) {
  if (window == NULL || changes == NULL || turned == NULL || !isCount(window->count)) {
    return;
  }
  /* What the torsions before have done to an axis: each turns about where its own axis was. */
  Turning before = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
  turned->count = window->count;
  for (int i = 0; i < window->count; i++) {
    turnPoint(&before, window->points[i], turned->points[i]);
    turnDirection(&before, window->axes[i], turned->axes[i]);
    const Turning turning = turningAbout(window->points[i], window->axes[i], changes[i]);
    turnFirst(&before, &turning);
  }
  for (int k = 0; k < CT_LOCAL_ENDS; k++) {
    turnPoint(&before, window->ends[k], turned->ends[k]);
  }
}
