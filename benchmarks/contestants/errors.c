#define REAL long double

#include "errors.h"

#include <stdlib.h>

#include "rigid.h"

enum { MOST_PAIRS = 100000 };

/* Torsions about bonds whose neighbours are nearer to their line than that, as a sine, are not defined well. */
#define STRAIGHT 0.1L

/* ---- Pairs ---- */

bool pairSampleInit(PairSample* sample, int particleCount, Random* random) {
  const long long all = (long long)particleCount * (particleCount - 1) / 2;
  const bool takesAll = all <= MOST_PAIRS;
  sample->pairs = calloc(takesAll ? (size_t)all + 1 : MOST_PAIRS, sizeof *sample->pairs);
  sample->count = 0;
  if (sample->pairs == NULL) {
    return false;
  }
  for (int i = 0; i < particleCount && takesAll; i++) {
    for (int j = 0; j < i; j++) {
      sample->pairs[sample->count][0] = i;
      sample->pairs[sample->count++][1] = j;
    }
  }
  while (!takesAll && sample->count < MOST_PAIRS) {
    const int i = randomInt(random, particleCount);
    const int j = randomInt(random, particleCount);
    if (i != j) {
      sample->pairs[sample->count][0] = i;
      sample->pairs[sample->count++][1] = j;
    }
  }
  return true;
}

void pairSampleFree(PairSample* sample) {
  free(sample->pairs);
  *sample = (PairSample){0};
}

/* ---- Geometry ---- */

static long double bendOf(const Place* x) {
  Place a;
  Place b;
  Place normal;
  subtract(x[0], x[1], a);
  subtract(x[2], x[1], b);
  cross(a, b, normal);
  return atan2(sqrt(dot(normal, normal)), dot(a, b));
}

static long double torsionOf(const Place* x) {
  Place first;
  Place axis;
  Place last;
  Place normal1;
  Place normal2;
  subtract(x[1], x[0], first);
  subtract(x[2], x[1], axis);
  subtract(x[3], x[2], last);
  cross(first, axis, normal1);
  cross(axis, last, normal2);
  return atan2(sqrt(dot(axis, axis)) * dot(first, normal2), dot(normal1, normal2));
}

/* ---- Sums ---- */

typedef struct Sum {
  long double largest;
  long double squares;
  int count;
} Sum;

static void add(Sum* sum, long double error) {
  sum->largest = fmax(sum->largest, fabs(error));
  sum->squares += error * error;
  sum->count++;
}

static Error errorOf(const Sum* sum) {
  return (Error){(double)sum->largest, sum->count == 0 ? 0 : (double)sqrt(sum->squares / sum->count)};
}

static void placeOf(const double* positions, int particle, Place place) {
  for (int k = 0; k < 3; k++) {
    place[k] = positions[3 * particle + k];
  }
}

static long double distance(const Place a, const Place b) {
  return sqrt(squaredDistance(a, b));
}

Errors errorsOf(const PairSample* sample, int particleCount, const double* positions, const Place* expected) {
  const long double halfTurn = acos(-1.0L);
  Sum distances = {0};
  Sum bonds = {0};
  Sum bends = {0};
  Sum torsions = {0};
  for (int p = 0; p < sample->count; p++) {
    const int i = sample->pairs[p][0];
    const int j = sample->pairs[p][1];
    Place a;
    Place b;
    placeOf(positions, i, a);
    placeOf(positions, j, b);
    add(&distances, distance(a, b) - distance(expected[i], expected[j]));
  }
  for (int i = 0; i + 1 < particleCount; i++) {
    Place x[4] = {{0}};
    for (int k = 0; k < 4 && i + k < particleCount; k++) {
      placeOf(positions, i + k, x[k]);
    }
    const Place* y = expected + i;
    add(&bonds, distance(x[0], x[1]) - distance(y[0], y[1]));
    if (i + 2 < particleCount) {
      add(&bends, bendOf((const Place*)x) - bendOf(y));
    }
    if (i + 3 < particleCount && sin(bendOf(y)) > STRAIGHT && sin(bendOf(y + 1)) > STRAIGHT) {
      add(&torsions, remainder(torsionOf((const Place*)x) - torsionOf(y), 2 * halfTurn));
    }
  }
  return (Errors){errorOf(&distances), errorOf(&bonds), errorOf(&bends), errorOf(&torsions)};
}

double sizeOf(int particleCount, const Place* places) {
  Place centroid = {0, 0, 0};
  long double farthest = 0;
  for (int i = 0; i < particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      centroid[k] += places[i][k] / particleCount;
    }
  }
  for (int i = 0; i < particleCount; i++) {
    farthest = fmax(farthest, squaredDistance(places[i], centroid));
  }
  return 2 * (double)sqrt(farthest);
}
