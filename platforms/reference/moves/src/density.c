#include "ctdensity.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.141592653589793238462643383280;
static const double TWO_PI = 6.283185307179586476925286766559;

/* The number of rotamers evaluated at a time, in loops that the compiler vectorizes. */
#define BATCH 16

/* Draws an index by its probability, with one uniform number and in constant time: the alias method of Walker (ACM
 * Trans. Math. Softw. 3, 253 (1977)), set up as by Vose (IEEE Trans. Softw. Eng. 17, 972 (1991)). Entry i stands for
 * index i up to its share, else for its alias. */
typedef struct AliasTable {
  int count;
  double* share;
  int* alias;
} AliasTable;

/* The bells of one torsion, one a rotamer: arrays of paddedCount. */
typedef struct Bells {
  double* mean;
  double* reach;  /* a quarter of the bell's whole width, rad: sqrt(3) standard deviations */
  double* scale;  /* 1 / reach */
  double* height; /* (1 - floor) / (48 reach), by which the spline below is to be multiplied */
  int images;     /* turns by which the widest bell reaches beyond the circle on each side */
} Bells;

struct ctDensity {
  int torsionCount;
  AliasTable choice;              /* of bins, or of rotamers */
  int binCounts[CT_DENSITY_MOST]; /* of a table */
  double* density;                /* of a table: of each bin */
  int paddedCount;                /* rotamers, rounded up to a whole number of batches; those added have weight 0 */
  double* weight;                 /* paddedCount, of a sum of 1 */
  Bells bells[CT_DENSITY_MOST];
  double floor;
};

/* True if all are finite and at least 0, and their sum is finite and above 0. */
static bool areWeights(int count, const double* weights) {
  double sum = 0;
  for (int i = 0; i < count; i++) {
    if (!(weights[i] >= 0)) {
      return false;
    }
    sum += weights[i];
  }
  return sum > 0 && sum < INFINITY;
}

static bool areBetween(size_t count, const double* values, double least, double most) {
  for (size_t i = 0; i < count; i++) {
    if (!(values[i] >= least && values[i] <= most)) {
      return false;
    }
  }
  return true;
}

/* True if both can be those of a density. */
static bool isPossible(int torsionCount, double floor) {
  return torsionCount >= 1 && torsionCount <= CT_DENSITY_MOST && floor >= 0 && floor <= 1;
}

/* Takes probabilities of any sum. False if there is no memory. */
static bool createAliasTable(AliasTable* table, int count, const double* probabilities) {
  const size_t n = (size_t)count;
  int* pending = malloc(n * sizeof *pending);
  table->share = malloc(n * sizeof *table->share);
  table->alias = malloc(n * sizeof *table->alias);
  if (pending == NULL || table->share == NULL || table->alias == NULL) {
    free(pending);
    return false;
  }
  table->count = count;
  double sum = 0;
  for (int i = 0; i < count; i++) {
    sum += probabilities[i];
  }
  /* Entries below the mean are pending from the left, those above it from the right. */
  int low = 0, high = count;
  for (int i = 0; i < count; i++) {
    table->share[i] = probabilities[i] / sum * count;
    table->alias[i] = i;
    pending[table->share[i] < 1 ? low++ : --high] = i;
  }
  while (low > 0 && high < count) {
    const int small = pending[--low], large = pending[high];
    table->alias[small] = large;
    table->share[large] -= 1 - table->share[small];
    if (table->share[large] < 1) {
      high++;
      pending[low++] = large;
    }
  }
  /* What rounding has left over stands for itself. */
  while (low > 0) {
    table->share[pending[--low]] = 1;
  }
  while (high < count) {
    table->share[pending[high++]] = 1;
  }
  free(pending);
  return true;
}

static int drawIndex(const AliasTable* table, double uniform) {
  const double scaled = uniform * table->count;
  /* Uniform numbers that are none lead to the ends. */
  const int i = !(scaled < table->count) ? table->count - 1 : scaled > 0 ? (int)scaled : 0;
  return scaled - i < table->share[i] ? i : table->alias[i];
}

/* An angle in [-pi, pi], of one that is less than a turn beyond. */
static double wrap(double angle) {
  return angle - TWO_PI * ((angle > PI) - (angle < -PI));
}

static ctDensity* allocateDensity(int torsionCount, double floor) {
  ctDensity* density = calloc(1, sizeof *density);
  if (density != NULL) {
    density->torsionCount = torsionCount;
    density->floor = floor;
  }
  return density;
}

/* ---- Tables ---- */

/* The number of bins of a table; 0 if it is none. */
static int countBins(int torsionCount, const int* binCounts) {
  int64_t count = 1;
  for (int k = 0; k < torsionCount; k++) {
    if (binCounts[k] < 1 || binCounts[k] > CT_BINS_MOST / count) {
      return 0;
    }
    count *= binCounts[k];
  }
  return (int)count;
}

ctDensity* ctCreateTable(int torsionCount, const int* binCounts, const double* values, double floor) {
  if (!isPossible(torsionCount, floor) || binCounts == NULL || values == NULL) {
    return NULL;
  }
  const int count = countBins(torsionCount, binCounts);
  if (count == 0 || !areWeights(count, values)) {
    return NULL;
  }
  ctDensity* density = allocateDensity(torsionCount, floor);
  if (density == NULL) {
    return NULL;
  }
  double volume = 1;
  for (int k = 0; k < torsionCount; k++) {
    density->binCounts[k] = binCounts[k];
    volume *= TWO_PI / binCounts[k];
  }
  density->density = malloc((size_t)count * sizeof *density->density);
  if (density->density == NULL) {
    ctDestroyDensity(density);
    return NULL;
  }
  double sum = 0;
  for (int i = 0; i < count; i++) {
    sum += values[i];
  }
  for (int i = 0; i < count; i++) {
    density->density[i] = ((1 - floor) * (values[i] / sum) + floor / count) / volume;
  }
  if (!createAliasTable(&density->choice, count, density->density)) {
    ctDestroyDensity(density);
    return NULL;
  }
  return density;
}

static void drawFromTable(const ctDensity* density, const double* uniforms, double* angles) {
  int bin = drawIndex(&density->choice, uniforms[0]);
  for (int k = density->torsionCount - 1; k >= 0; k--) {
    const int count = density->binCounts[k];
    angles[k] = (bin % count + uniforms[1 + k]) * (TWO_PI / count) - PI;
    bin /= count;
  }
}

static double getTableDensity(const ctDensity* density, const double* angles) {
  int index = 0;
  for (int k = 0; k < density->torsionCount; k++) {
    const int count = density->binCounts[k];
    const double bin = (angles[k] + PI) * (count / TWO_PI);
    index = index * count + (!(bin > 0) ? 0 : bin < count ? (int)bin : count - 1);
  }
  return density->density[index];
}

/* ---- Rotamers ---- */

/* 48 times the cubic B-spline of knots -2 ... 2, of integral 1, at distance t from its middle. Without a branch, so
 * that loops over it become SIMD: x + |x| is 2x above 0, else 0. */
static double spline(double t) {
  const double a = (2 - t) + fabs(2 - t), b = (1 - t) + fabs(1 - t);
  return a * a * a - 4 * (b * b * b);
}

/* The distance on the circle of two angles in [-pi, pi]. */
static double distance(double angle1, double angle2) {
  return PI - fabs(PI - fabs(angle1 - angle2));
}

/* Fills the bells of torsion k. False if there is no memory. */
static bool createBells(ctDensity* density, int k, int rotamerCount, const double* means, const double* widths) {
  Bells* bells = &density->bells[k];
  const size_t padded = (size_t)density->paddedCount;
  double* memory = malloc(4 * padded * sizeof *memory);
  if (memory == NULL) {
    return false;
  }
  bells->mean = memory;
  bells->reach = memory + padded;
  bells->scale = memory + 2 * padded;
  bells->height = memory + 3 * padded;
  for (int i = 0; i < density->paddedCount; i++) {
    const size_t source = (size_t)(i < rotamerCount ? i : 0) * (size_t)density->torsionCount + (size_t)k;
    const double reach = sqrt(3.0) * widths[source];
    const int images = (int)ceil((2 * reach - PI) / TWO_PI);
    bells->mean[i] = means[source];
    bells->reach[i] = reach;
    bells->scale[i] = 1 / reach;
    bells->height[i] = (1 - density->floor) / (48 * reach);
    bells->images = images > bells->images ? images : bells->images;
  }
  return true;
}

ctDensity* ctCreateRotamers(int torsionCount, int rotamerCount, const double* weights, const double* means,
                            const double* widths, double floor) {
  if (!isPossible(torsionCount, floor) || rotamerCount < 1 || rotamerCount > CT_BINS_MOST || weights == NULL ||
      means == NULL || widths == NULL) {
    return NULL;
  }
  const size_t angleCount = (size_t)rotamerCount * (size_t)torsionCount;
  if (!areWeights(rotamerCount, weights) || !areBetween(angleCount, means, -CT_MOST_ANGLE, CT_MOST_ANGLE) ||
      !areBetween(angleCount, widths, DBL_MIN, CT_MOST_ANGLE)) {
    return NULL;
  }
  ctDensity* density = allocateDensity(torsionCount, floor);
  if (density == NULL) {
    return NULL;
  }
  density->paddedCount = (rotamerCount + BATCH - 1) / BATCH * BATCH;
  density->weight = calloc((size_t)density->paddedCount, sizeof *density->weight);
  if (density->weight == NULL || !createAliasTable(&density->choice, rotamerCount, weights)) {
    ctDestroyDensity(density);
    return NULL;
  }
  double sum = 0;
  for (int i = 0; i < rotamerCount; i++) {
    sum += weights[i];
  }
  for (int i = 0; i < rotamerCount; i++) {
    density->weight[i] = weights[i] / sum;
  }
  for (int k = 0; k < torsionCount; k++) {
    if (!createBells(density, k, rotamerCount, means, widths)) {
      ctDestroyDensity(density);
      return NULL;
    }
  }
  return density;
}

static void drawFromRotamers(const ctDensity* density, const double* uniforms, double* angles) {
  const int rotamer = drawIndex(&density->choice, uniforms[0]);
  for (int k = 0; k < density->torsionCount; k++) {
    const double* u = uniforms + 1 + 4 * (size_t)k;
    const double floor = density->floor;
    if (u[0] < floor) {
      angles[k] = u[0] / floor * TWO_PI - PI;
      continue;
    }
    const double first = (u[0] - floor) / (1 - floor); /* what is above the floor is uniform again */
    const Bells* bells = &density->bells[k];
    double angle = bells->mean[rotamer] + bells->reach[rotamer] * (first + u[1] + u[2] + u[3] - 2);
    for (int i = 0; i < 1 + bells->images; i++) {
      angle = wrap(angle);
    }
    angles[k] = angle;
  }
}

/* Multiplies products, one a rotamer of a batch, by the densities of torsion k at an angle. */
static void multiplyBells(const Bells* bells, int first, double angle, double base, double* restrict products) {
  const double *mean = bells->mean + first, *scale = bells->scale + first, *height = bells->height + first;
  if (bells->images == 0) {
    for (int i = 0; i < BATCH; i++) {
      products[i] *= base + height[i] * spline(distance(angle, mean[i]) * scale[i]);
    }
    return;
  }
  for (int i = 0; i < BATCH; i++) {
    const double difference = distance(angle, mean[i]);
    double sum = 0;
    for (int turn = -bells->images; turn <= bells->images; turn++) {
      sum += spline(fabs(difference + turn * TWO_PI) * scale[i]);
    }
    products[i] *= base + height[i] * sum;
  }
}

static double getRotamerDensity(const ctDensity* density, const double* angles) {
  const double base = density->floor / TWO_PI;
  double products[BATCH], sums[BATCH] = {0};
  for (int first = 0; first < density->paddedCount; first += BATCH) {
    memcpy(products, density->weight + first, sizeof products);
    for (int k = 0; k < density->torsionCount; k++) {
      multiplyBells(&density->bells[k], first, angles[k], base, products);
    }
    for (int i = 0; i < BATCH; i++) {
      sums[i] += products[i];
    }
  }
  for (int half = BATCH / 2; half > 0; half /= 2) {
    for (int i = 0; i < half; i++) {
      sums[i] += sums[half + i];
    }
  }
  return sums[0];
}

/* ---- Either ---- */

static bool isTable(const ctDensity* density) {
  return density->density != NULL;
}

void ctDestroyDensity(ctDensity* density) {
  if (density == NULL) {
    return;
  }
  for (int k = 0; k < density->torsionCount; k++) {
    free(density->bells[k].mean);
  }
  free(density->choice.share);
  free(density->choice.alias);
  free(density->density);
  free(density->weight);
  free(density);
}

int ctCountUniforms(const ctDensity* density) {
  return density == NULL ? 0 : 1 + density->torsionCount * (isTable(density) ? 1 : 4);
}

void ctDrawAngles(const ctDensity* density, const double* uniforms, double* angles) {
  if (density == NULL || uniforms == NULL || angles == NULL) {
    return;
  }
  if (isTable(density)) {
    drawFromTable(density, uniforms, angles);
  } else {
    drawFromRotamers(density, uniforms, angles);
  }
}

double ctGetDensity(const ctDensity* density, const double* angles) {
  if (density == NULL || angles == NULL) {
    return NAN;
  }
  return isTable(density) ? getTableDensity(density, angles) : getRotamerDensity(density, angles);
}
