/* A grid of cubic cells, wrapped around in all directions so that it is a table of fixed size however far a chain
 * reaches: particles of far cells share an entry, and cost no more than the test of a distance. */
#ifndef CELLS_H_
#define CELLS_H_

#include <math.h>
#include <string.h>

#include "contestant.h"
#include "random.h"
#include "rigid.h"

enum { MOST_CELLS_ALONG = 4, MOST_CELLS_AROUND = MOST_CELLS_ALONG * MOST_CELLS_ALONG * MOST_CELLS_ALONG };

typedef struct Cells {
  double perLength; /* cells per unit of length */
  double reach;     /* centres of particles that meet are never farther apart, along any axis */
  int along;        /* number of cells in a row that hold all particles within reach of one */
  int bits[3];      /* 2^bits entries along each axis */
  size_t count;
  int* heads; /* the first particle (or block of them) in each cell, or -1 */
  int* next;  /* the particle behind each in its cell, or -1; NULL if cells hold blocks */
} Cells;

/* How many particles are within some distance of one, in the mean over some of them, as a density. */
static inline double cellsDensity(const Scene* scene, double distance) {
  enum { SAMPLES = 50 };
  const int step = scene->particleCount / SAMPLES + 1;
  int samples = 0;
  double found = 0;
  for (int i = 0; i < scene->particleCount; i += step) {
    samples++;
    for (int j = 0; j < scene->particleCount; j++) {
      found += squaredDistance(scene->spheres[i].x, scene->spheres[j].x) < distance * distance;
    }
  }
  return found / samples / (4.0 / 3 * PI * distance * distance * distance);
}

/* Few large cells hold more particles than are near, many small ones are too many: the fewest of both together, where
 * particles are compared `blockSize` at a time; and large enough to fill the blocks. */
static inline void cellsChooseEdge(Cells* cells, const Scene* scene, int blockSize) {
  const double density = cellsDensity(scene, 1.5 * cells->reach);
  double leastCost = INFINITY;
  for (int along = 2; along <= MOST_CELLS_ALONG; along++) {
    const double least = 2 * cells->reach / (along - 1) * (1 + 1e-9);
    const double edge = blockSize > 1 ? fmax(least, cbrt(blockSize / density)) : least;
    const double cost = pow(along, 3) + density * pow(along * edge, 3) / blockSize;
    if (cost < leastCost) {
      leastCost = cost;
      cells->along = along;
      cells->perLength = 1 / edge;
    }
  }
}

static inline void cellsClear(Cells* cells) {
  memset(cells->heads, -1, cells->count * sizeof(int));
}

/* Within which the centres of two particles are that meet. */
static inline double cellsReach(const Scene* scene) {
  return 2 * sceneLargestRadius(scene);
}

/* With at least `entriesPerParticle` entries of the table for each particle. If `blockSize` is more than 1, cells hold
 * blocks of that many particles, which are the contestant's. */
static inline void cellsInit(Cells* cells, const Scene* scene, double reach, int entriesPerParticle, int blockSize) {
  int bits = 3 * MOST_CELLS_ALONG / 2;
  while ((1LL << bits) < (long long)entriesPerParticle * scene->particleCount) {
    bits++;
  }
  for (int k = 0; k < 3; k++) {
    cells->bits[k] = (bits + 2 - k) / 3;
  }
  cells->reach = reach;
  cellsChooseEdge(cells, scene, blockSize);
  cells->count = (size_t)1 << bits;
  cells->heads = allocate(1 << bits, sizeof(int));
  cells->next = blockSize == 1 ? allocate(scene->particleCount, sizeof(int)) : NULL;
  cellsClear(cells);
}

static inline void cellsFree(Cells* cells) {
  free(cells->heads);
  free(cells->next);
}

/* Coordinates are far within +-2^24 cells; conversion of a positive number needs no rounding mode. */
static inline int cellAlong(const Cells* cells, double x) {
  return (int)(x * cells->perLength + 0x1p24);
}

/* What a cell's number along an axis adds to its entry. */
static inline int cellPart(const Cells* cells, int axis, int number) {
  const int shift = axis == 0 ? 0 : axis == 1 ? cells->bits[0] : cells->bits[0] + cells->bits[1];
  return (number & ((1 << cells->bits[axis]) - 1)) << shift;
}

static inline int cellOf(const Cells* cells, const Sphere* sphere) {
  return cellPart(cells, 0, cellAlong(cells, sphere->x[0])) | cellPart(cells, 1, cellAlong(cells, sphere->x[1])) |
         cellPart(cells, 2, cellAlong(cells, sphere->x[2]));
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

/* The entries of the cells that hold all particles within reach of a sphere. */
typedef struct CellsAround {
  int parts[3][MOST_CELLS_ALONG]; /* by axis; an entry is the parts of three together */
} CellsAround;

static inline CellsAround cellsAround(const Cells* cells, const Sphere* sphere) {
  CellsAround around;
  for (int k = 0; k < 3; k++) {
    const int low = cellAlong(cells, sphere->x[k] - cells->reach);
    for (int c = 0; c < cells->along; c++) {
      around.parts[k][c] = cellPart(cells, k, low + c);
    }
  }
  return around;
}

/* Whether pairs with particle j count; 1 or 0. It must not branch. */
typedef int CellsFilter(const void* context, int j);

#endif /* CELLS_H_ */
