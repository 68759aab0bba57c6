/* A grid of cubic cells, wrapped around in all directions so that it is a table of fixed size however far a chain
 * reaches: particles of far cells share an entry, and cost no more than the test of a distance. */
#ifndef CELLS_H_
#define CELLS_H_

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contestant.h"
#include "rigid.h"

typedef struct Cells {
  double perLength;     /* cells per unit of length */
  double largestRadius; /* of any particle */
  int bits[3];          /* 2^bits entries along each axis */
  size_t count;
  int* heads; /* the first particle in each cell, or -1 */
  int* next;  /* the particle behind each in its cell, or -1 */
} Cells;

/* Particles per volume of the box around them. */
static inline double cellsDensity(const Scene* scene) {
  double low[3] = {INFINITY, INFINITY, INFINITY};
  double high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int i = 0; i < scene->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      low[k] = fmin(low[k], scene->spheres[i].x[k]);
      high[k] = fmax(high[k], scene->spheres[i].x[k]);
    }
  }
  const double reach = 2 * sceneLargestRadius(scene);
  return scene->particleCount / ((high[0] - low[0] + reach) * (high[1] - low[1] + reach) * (high[2] - low[2] + reach));
}

/* The edge for which a search visits fewest cells and particles together: large cells hold more particles than are
 * near, small ones are too many. */
static inline double cellsBestEdge(const Scene* scene) {
  const double reach = 2 * sceneLargestRadius(scene);
  const double density = cellsDensity(scene);
  double bestEdge = reach;
  double bestCost = INFINITY;
  for (double edge = 2 * reach; edge > reach / 2; edge *= 0.9) {
    const double cells = pow(1 + 2 * reach / edge, 3);
    const double cost = cells * (1 + density * edge * edge * edge);
    if (cost < bestCost) {
      bestCost = cost;
      bestEdge = edge;
    }
  }
  return bestEdge;
}

static inline void cellsClear(Cells* cells) {
  memset(cells->heads, -1, cells->count * sizeof(int));
}

/* With at least `entriesPerParticle` entries of the table for each particle; false if there is no memory. */
static inline bool cellsInit(Cells* cells, const Scene* scene, int entriesPerParticle) {
  cells->perLength = 1 / cellsBestEdge(scene);
  cells->largestRadius = sceneLargestRadius(scene);
  int bits = 6;
  while ((1LL << bits) < (long long)entriesPerParticle * scene->particleCount) {
    bits++;
  }
  for (int k = 0; k < 3; k++) {
    cells->bits[k] = (bits + 2 - k) / 3;
  }
  cells->count = (size_t)1 << bits;
  cells->heads = malloc(cells->count * sizeof(int));
  cells->next = malloc(((size_t)scene->particleCount + 1) * sizeof(int));
  if (cells->heads == NULL || cells->next == NULL) {
    return false;
  }
  cellsClear(cells);
  return true;
}

static inline void cellsFree(Cells* cells) {
  free(cells->heads);
  free(cells->next);
}

/* Coordinates are far within +-2^24 cells; conversion of a positive number needs no rounding mode. */
static inline int cellAlong(const Cells* cells, double x) {
  return (int)(x * cells->perLength + 0x1p24);
}

static inline int cellEntry(const Cells* cells, int x, int y, int z) {
  const int column = y & ((1 << cells->bits[1]) - 1);
  const int layer = z & ((1 << cells->bits[2]) - 1);
  return (((layer << cells->bits[1]) | column) << cells->bits[0]) | (x & ((1 << cells->bits[0]) - 1));
}

static inline int cellOf(const Cells* cells, const Sphere* sphere) {
  return cellEntry(cells, cellAlong(cells, sphere->x[0]), cellAlong(cells, sphere->x[1]),
                   cellAlong(cells, sphere->x[2]));
}

static inline void cellsInsert(Cells* cells, int entry, int i) {
  cells->next[i] = cells->heads[entry];
  cells->heads[entry] = i;
}

static inline void cellsRemove(Cells* cells, int entry, int i) {
  int* link = &cells->heads[entry];
  while (*link != i) {
    link = &cells->next[*link];
  }
  *link = cells->next[i];
}

/* Whether a pair that overlaps counts. */
typedef bool CellsFilter(const void* context, int i, int j);

/* Whether particle i, at `sphere`, overlaps one in the grid, and the filter lets the pair count. */
__attribute__((always_inline)) static inline bool cellsMeet(const Cells* cells, const Sphere* spheres, int i,
                                                            const Sphere* sphere, CellsFilter* filter,
                                                            const void* context, int64_t* particleTests) {
  const double reach = sphere->radius + cells->largestRadius;
  int low[3];
  int high[3];
  for (int k = 0; k < 3; k++) {
    low[k] = cellAlong(cells, sphere->x[k] - reach);
    high[k] = cellAlong(cells, sphere->x[k] + reach);
  }
  int64_t tests = 0;
  bool meets = false;
  for (int z = low[2]; z <= high[2] && !meets; z++) {
    for (int y = low[1]; y <= high[1] && !meets; y++) {
      for (int x = low[0]; x <= high[0] && !meets; x++) {
        for (int j = cells->heads[cellEntry(cells, x, y, z)]; j >= 0; j = cells->next[j]) {
          const double sum = sphere->radius + spheres[j].radius;
          tests++;
          if (squaredDistance(sphere->x, spheres[j].x) < sum * sum && filter(context, i, j)) {
            meets = true;
            break;
          }
        }
      }
    }
  }
  *particleTests += tests;
  return meets;
}

#endif /* CELLS_H_ */
