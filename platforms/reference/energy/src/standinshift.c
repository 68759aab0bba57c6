/* What a pair of the stand-in is at the cutoff, as products of functions of one radius each: so two radii cost no more
 * than a few products, and the energy of a pair vanishes at the cutoff within 0.1 kJ/mol per product of charges. */
#include <math.h>
#include <string.h>

#include "standin.h"

/* Radii in a protein or a nucleic acid, nm. Beyond these the values are those at the end. */
#define LEAST_RADIUS 0.1
#define MOST_RADIUS 0.7

typedef double Matrix[SHIFT_TERMS][SHIFT_TERMS];

static double valueAt(const ctEnergyDefinition* d, double log) {
  const double cutoff = d->standIn->pairCutoff;
  const double product = exp(log);
  const double f = sqrt(cutoff * cutoff + product * exp(-cutoff * cutoff / (4 * product)));
  const double perDielectric = 1 / d->born->soluteDielectric - exp(-d->born->kappa * f) / d->born->solventDielectric;
  return 1 / cutoff - perDielectric / f;
}

/* Its derivative by ln B, in units of STANDIN_GRADIENT. */
static double slopeAt(const ctEnergyDefinition* d, double log) {
  const double step = 1e-4;
  return (valueAt(d, log + step) - valueAt(d, log - step)) / (2 * step * (double)STANDIN_GRADIENT);
}

/* The eigenvector of a symmetric matrix whose eigenvalue is the largest in magnitude, by powers of it; returns the
 * eigenvalue. */
static double findLargest(const Matrix m, double vector[SHIFT_TERMS]) {
  double norm = 0;
  double product[SHIFT_TERMS];
  for (int i = 0; i < SHIFT_TERMS; i++) {
    vector[i] = 1 + 0.1 * i;
  }
  for (int pass = 0; pass < 400; pass++) {
    norm = 0;
    for (int i = 0; i < SHIFT_TERMS; i++) {
      product[i] = 0;
      for (int j = 0; j < SHIFT_TERMS; j++) {
        product[i] += m[i][j] * vector[j];
      }
      norm += product[i] * product[i];
    }
    norm = sqrt(norm);
    for (int i = 0; i < SHIFT_TERMS && norm > 0; i++) {
      vector[i] = product[i] / norm;
    }
  }
  double value = 0;
  for (int i = 0; i < SHIFT_TERMS; i++) {
    for (int j = 0; j < SHIFT_TERMS; j++) {
      value += vector[i] * m[i][j] * vector[j];
    }
  }
  return value;
}

/* The polynomial that has these values at the nodes, by Gauss and Jordan. */
static void interpolate(const double nodes[SHIFT_TERMS], const double values[SHIFT_TERMS], float c[SHIFT_TERMS]) {
  double m[SHIFT_TERMS][SHIFT_TERMS + 1];
  for (int i = 0; i < SHIFT_TERMS; i++) {
    for (int j = 0; j < SHIFT_TERMS; j++) {
      m[i][j] = pow(nodes[i], j);
    }
    m[i][SHIFT_TERMS] = values[i];
  }
  for (int i = 0; i < SHIFT_TERMS; i++) {
    int pivot = i;
    for (int row = i + 1; row < SHIFT_TERMS; row++) {
      pivot = fabs(m[row][i]) > fabs(m[pivot][i]) ? row : pivot;
    }
    double swapped[SHIFT_TERMS + 1];
    memcpy(swapped, m[i], sizeof swapped);
    memcpy(m[i], m[pivot], sizeof swapped);
    memcpy(m[pivot], swapped, sizeof swapped);
    for (int row = 0; row < SHIFT_TERMS; row++) {
      const double factor = row != i ? m[row][i] / m[i][i] : 0;
      for (int j = i; j <= SHIFT_TERMS; j++) {
        m[row][j] -= factor * m[i][j];
      }
    }
  }
  for (int i = 0; i < SHIFT_TERMS; i++) {
    c[i] = (float)(m[i][SHIFT_TERMS] / m[i][i]);
  }
}

/* Takes the largest products from a matrix of values at pairs of nodes, one after another. */
static void factor(Matrix m, const double nodes[SHIFT_TERMS], int ranks, float c[][SHIFT_TERMS], float sign[]) {
  for (int rank = 0; rank < ranks; rank++) {
    double vector[SHIFT_TERMS];
    const double value = findLargest((const double(*)[SHIFT_TERMS])m, vector);
    for (int i = 0; i < SHIFT_TERMS; i++) {
      for (int j = 0; j < SHIFT_TERMS; j++) {
        m[i][j] -= value * vector[i] * vector[j];
      }
    }
    for (int i = 0; i < SHIFT_TERMS; i++) {
      vector[i] *= sqrt(fabs(value));
    }
    interpolate(nodes, vector, c[rank]);
    sign[rank] = value < 0 ? -1.0f : 1.0f;
  }
}

void ctStandInFitShift(StandInModel* model, const ctEnergyDefinition* d) {
  const double middle = (log(LEAST_RADIUS) + log(MOST_RADIUS)) / 2;
  const double half = (log(MOST_RADIUS) - log(LEAST_RADIUS)) / 2;
  double nodes[SHIFT_TERMS];
  Matrix values;
  Matrix slopes;
  for (int i = 0; i < SHIFT_TERMS; i++) {
    nodes[i] = cos(3.14159265358979324 * (i + 0.5) / SHIFT_TERMS);
  }
  for (int i = 0; i < SHIFT_TERMS; i++) {
    for (int j = 0; j < SHIFT_TERMS; j++) {
      values[i][j] = valueAt(d, 2 * middle + half * (nodes[i] + nodes[j]));
      slopes[i][j] = slopeAt(d, 2 * middle + half * (nodes[i] + nodes[j]));
    }
  }
  model->middleLog = (float)middle;
  model->perHalfWidth = (float)(1 / half);
  factor(values, nodes, VALUE_RANK, model->shift, model->shiftSign);
  factor(slopes, nodes, SLOPE_RANK, model->shift + VALUE_RANK, model->shiftSign + VALUE_RANK);
  const float fade[] = STANDIN_FADE;
  const float bornFade[] = STANDIN_BORN_FADE;
  const double squared = d->standIn->pairCutoff * d->standIn->pairCutoff;
  const double bornSquared = d->standIn->bornCutoff * d->standIn->bornCutoff;
  for (int i = 0; i < FADE_TERMS; i++) {
    model->fade[i] = (float)((double)fade[i] / pow(squared, i + 2));
  }
  model->bornFade[0] = (float)((double)bornFade[0] / (3 * bornSquared * bornSquared));
  model->bornFade[1] = (float)((double)bornFade[1] / (3 * bornSquared * bornSquared * bornSquared));
}
