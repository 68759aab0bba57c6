/* The least distance by testing all particles with all obstacles, many particles at a time, in single precision. */
#include <stdlib.h>

#include "bodies.h"
#include "lanes.h"
#include "nearest.h"

typedef struct BruteNearest {
  const Scene* scene;
  Sphere* spheres;
  int paddedCount; /* of particles; those beyond are far away */
  float* x;
  float* y;
  float* z;
  int obstacleCount;
  double* obstacles;
} BruteNearest;

static void destroy(void* self) {
  BruteNearest* brute = self;
  if (brute != NULL) {
    free(brute->spheres);
    free(brute->x);
    free(brute->y);
    free(brute->z);
    free(brute->obstacles);
    free(brute);
  }
}

static void copyColumns(BruteNearest* brute, int first, int last) {
  for (int i = first; i < last; i++) {
    brute->x[i] = (float)brute->spheres[i].x[0];
    brute->y[i] = (float)brute->spheres[i].x[1];
    brute->z[i] = (float)brute->spheres[i].x[2];
  }
}

static void* make(const Scene* scene, int obstacleCount, const double* obstacles) {
  BruteNearest* brute = calloc(1, sizeof *brute);
  if (brute == NULL) {
    return NULL;
  }
  const size_t count = (size_t)scene->particleCount;
  brute->scene = scene;
  brute->paddedCount = (scene->particleCount + LANES - 1) / LANES * LANES;
  brute->obstacleCount = obstacleCount;
  brute->spheres = malloc((count + 1) * sizeof(Sphere));
  brute->x = malloc((count + LANES) * sizeof(float));
  brute->y = malloc((count + LANES) * sizeof(float));
  brute->z = malloc((count + LANES) * sizeof(float));
  brute->obstacles = malloc(3 * (size_t)obstacleCount * sizeof(double) + 1);
  if (brute->spheres == NULL || brute->x == NULL || brute->y == NULL || brute->z == NULL || brute->obstacles == NULL) {
    destroy(brute);
    return NULL;
  }
  memcpy(brute->spheres, scene->spheres, count * sizeof(Sphere));
  memcpy(brute->obstacles, obstacles, 3 * (size_t)obstacleCount * sizeof(double));
  copyColumns(brute, 0, scene->particleCount);
  for (int i = scene->particleCount; i < brute->paddedCount; i++) {
    brute->x[i] = brute->y[i] = brute->z[i] = 1e18f;
  }
  return brute;
}

static bool turn(void* self, Turn turn) {
  BruteNearest* brute = self;
  const Torsion* torsion = &brute->scene->torsions[turn.torsion];
  const Rigid motion = rigidTurn(brute->spheres[torsion->axis[0]].x, brute->spheres[torsion->axis[1]].x, turn.angle);
  for (int i = torsion->first; i < torsion->last; i++) {
    brute->spheres[i] = movedSphere(&motion, &brute->spheres[i]);
  }
  copyColumns(brute, torsion->first, torsion->last);
  return true;
}

static float leastSquare(const BruteNearest* brute, const double* obstacle) {
  const Lanes x = lanesOf((float)obstacle[0]);
  const Lanes y = lanesOf((float)obstacle[1]);
  const Lanes z = lanesOf((float)obstacle[2]);
  Lanes least = lanesOf(INFINITY);
  for (int i = 0; i < brute->paddedCount; i += LANES) {
    least = lanesLesser(
        least, squaredDistances(x, y, z, lanesLoad(brute->x + i), lanesLoad(brute->y + i), lanesLoad(brute->z + i)));
  }
  return lanesLeast(least);
}

/* Which obstacle is nearest shows first; then which particle is. */
static bool find(void* self, Nearest* nearest) {
  const BruteNearest* brute = self;
  float least = INFINITY;
  for (int k = 0; k < brute->obstacleCount; k++) {
    const float square = leastSquare(brute, brute->obstacles + 3 * k);
    if (square < least) {
      least = square;
      nearest->obstacle = k;
    }
  }
  double leastSquared = INFINITY;
  for (int i = 0; i < brute->scene->particleCount; i++) {
    const double squared = squaredDistance(brute->spheres[i].x, brute->obstacles + 3 * nearest->obstacle);
    if (squared < leastSquared) {
      leastSquared = squared;
      nearest->particle = i;
    }
  }
  nearest->distance = sqrt(leastSquared);
  return true;
}

const NearestFinder CONTESTANT(nearestFinderBrute) = {.name = "brute",
                                                      .idea = "all particles with all obstacles, many at a time",
                                                      .make = make,
                                                      .destroy = destroy,
                                                      .turn = turn,
                                                      .find = find};
