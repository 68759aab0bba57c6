/* Pairs within a cutoff by a grid of cells whose particles lie one behind the other, so that those of some cells in a
 * row are tested many at a time. In single precision, about the corner of the box around all particles. */
#include <math.h>

#include "lanes.h"
#include "pairfinder.h"

/* Finer cells hold fewer particles that are too far away, but fill fewer lanes at a time. */
enum { CELLS_PER_CUTOFF = 1, MOST_ROWS = (2 * CELLS_PER_CUTOFF + 1) * (2 * CELLS_PER_CUTOFF + 1) };

/* Particles first ... last - 1 of the grid's order. */
typedef struct Row {
  int first;
  int last;
} Row;

typedef struct PairGrid {
  int particleCount;
  int mostCells;
  int dims[3];
  double low[3]; /* the corner */
  double edge;   /* of a cell */
  double perLength;
  int* cellBegins; /* of each cell and one more: its first particle */
  int* cells;      /* of particles as they come */
  float* x;        /* in the grid's order, as the next three */
  float* y;
  float* z;
  int* ids;
} PairGrid;

static void destroy(void* self) {
  PairGrid* grid = self;
  free(grid->cellBegins);
  free(grid->cells);
  free(grid->x);
  free(grid->y);
  free(grid->z);
  free(grid->ids);
  free(grid);
}

static void* make(const Scene* scene) {
  PairGrid* grid = allocate(1, sizeof *grid);
  const int padded = scene->particleCount + LANES; /* behind the last particle, a full load may be made */
  grid->particleCount = scene->particleCount;
  grid->mostCells = 16 * scene->particleCount + 64;
  grid->cellBegins = allocate(grid->mostCells + 2, sizeof(int));
  grid->cells = allocate(padded, sizeof(int));
  grid->x = allocate(padded, sizeof(float));
  grid->y = allocate(padded, sizeof(float));
  grid->z = allocate(padded, sizeof(float));
  grid->ids = allocate(padded, sizeof(int));
  return grid;
}

/* ---- Building ---- */

static void layOut(PairGrid* grid, const double* positions, double cutoff) {
  double high[3];
  for (int k = 0; k < 3; k++) {
    grid->low[k] = INFINITY;
    high[k] = -INFINITY;
  }
  for (int i = 0; i < grid->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      const double x = positions[3 * i + k];
      grid->low[k] = x < grid->low[k] ? x : grid->low[k];
      high[k] = x > high[k] ? x : high[k];
    }
  }
  for (grid->edge = cutoff / CELLS_PER_CUTOFF;; grid->edge *= 1.25) {
    double cells = 1;
    grid->perLength = 1 / grid->edge;
    for (int k = 0; k < 3; k++) {
      const double dim = floor((high[k] - grid->low[k]) * grid->perLength) + 1;
      cells *= dim;
      grid->dims[k] = dim < grid->mostCells ? (int)dim : grid->mostCells;
    }
    if (cells <= grid->mostCells) {
      return;
    }
  }
}

/* Sorts particles by cell, by counting. */
static void fillCells(PairGrid* grid, const double* positions) {
  const int cellCount = grid->dims[0] * grid->dims[1] * grid->dims[2];
  int* begins = grid->cellBegins;
  memset(begins, 0, ((size_t)cellCount + 2) * sizeof(int));
  for (int i = 0; i < grid->particleCount; i++) {
    const double* x = positions + 3 * i;
    const int cx = (int)((x[0] - grid->low[0]) * grid->perLength);
    const int cy = (int)((x[1] - grid->low[1]) * grid->perLength);
    const int cz = (int)((x[2] - grid->low[2]) * grid->perLength);
    grid->cells[i] = (cz * grid->dims[1] + cy) * grid->dims[0] + cx;
    begins[grid->cells[i] + 2]++;
  }
  for (int cell = 0; cell < cellCount; cell++) {
    begins[cell + 1] += begins[cell];
  }
  for (int i = 0; i < grid->particleCount; i++) {
    const int place = begins[grid->cells[i] + 1]++;
    grid->x[place] = (float)(positions[3 * i] - grid->low[0]);
    grid->y[place] = (float)(positions[3 * i + 1] - grid->low[1]);
    grid->z[place] = (float)(positions[3 * i + 2] - grid->low[2]);
    grid->ids[place] = i;
  }
}

/* ---- Looking around a cell ---- */

/* Which cells hold particles near one in a cell: rows along x, by their distance across. */
typedef struct Neighborhood {
  int reach;                                              /* in cells, across */
  int alongs[CELLS_PER_CUTOFF + 1][CELLS_PER_CUTOFF + 1]; /* by distances in y and z: in cells, along; -1: too far */
} Neighborhood;

static Neighborhood neighborhoodOf(const PairGrid* grid, double cutoff) {
  Neighborhood hood = {.reach = (int)(cutoff / grid->edge * (1 - 1e-12)) + 1};
  for (int y = 0; y <= hood.reach; y++) {
    for (int z = 0; z <= hood.reach; z++) {
      const double gapY = y > 0 ? (y - 1) * grid->edge : 0;
      const double gapZ = z > 0 ? (z - 1) * grid->edge : 0;
      const double left = cutoff * cutoff - gapY * gapY - gapZ * gapZ;
      hood.alongs[y][z] = left < 0 ? -1 : (int)(sqrt(left) / grid->edge * (1 - 1e-12)) + 1;
    }
  }
  return hood;
}

/* The rows with particles around a cell: its own row from the cell on, and those behind. */
static int rowsAround(const PairGrid* grid, const Neighborhood* hood, int cell, Row* rows) {
  const int* dims = grid->dims;
  const int cx = cell % dims[0];
  const int cy = cell / dims[0] % dims[1];
  const int cz = cell / dims[0] / dims[1];
  int count = 0;
  for (int z = cz; z <= cz + hood->reach; z++) {
    for (int y = z == cz ? cy : cy - hood->reach; y <= cy + hood->reach; y++) {
      const int along = hood->alongs[y < cy ? cy - y : y - cy][z - cz];
      if (z >= dims[2] || y < 0 || y >= dims[1] || along < 0) {
        continue;
      }
      const int row = (z * dims[1] + y) * dims[0];
      const int from = z == cz && y == cy ? cx : cx - along < 0 ? 0 : cx - along;
      const int to = cx + along < dims[0] ? cx + along : dims[0] - 1;
      rows[count] = (Row){grid->cellBegins[row + from], grid->cellBegins[row + to + 1]};
      count += rows[count].first < rows[count].last;
    }
  }
  return count;
}

static unsigned firstLanes(int count) {
  return count >= LANES ? (1u << LANES) - 1 : (1u << count) - 1;
}

/* ---- Pairs ---- */

/* Pairs of a particle of the grid with those of a row. */
static void addPairs(const PairGrid* grid, int place, Row row, Lanes limit, PairList* list) {
  const Lanes x = lanesOf(grid->x[place]);
  const Lanes y = lanesOf(grid->y[place]);
  const Lanes z = lanesOf(grid->z[place]);
  const IntLanes id = intLanesOf(grid->ids[place]);
  const float* restrict xs = grid->x;
  const float* restrict ys = grid->y;
  const float* restrict zs = grid->z;
  const int* restrict ids = grid->ids;
  int* restrict first = list->first;
  int* restrict second = list->second;
  int count = list->count;
  for (int t = row.first; t < row.last; t += LANES) {
    const Lanes squared = squaredDistances(x, y, z, lanesLoad(xs + t), lanesLoad(ys + t), lanesLoad(zs + t));
    const unsigned near = lanesAtMost(squared, limit) & firstLanes(row.last - t);
    intLanesStore(first + count, id);
    intLanesStoreSome(second + count, near, intLanesLoad(ids + t));
    count += bitCount(near);
  }
  list->count = count;
}

static void find(void* self, const double* positions, double cutoff, PairList* list) {
  PairGrid* grid = self;
  layOut(grid, positions, cutoff);
  fillCells(grid, positions);
  const Neighborhood hood = neighborhoodOf(grid, cutoff);
  const Lanes limit = lanesOf((float)(cutoff * cutoff));
  const int cellCount = grid->dims[0] * grid->dims[1] * grid->dims[2];
  list->count = 0;
  for (int cell = 0; cell < cellCount; cell++) {
    const int first = grid->cellBegins[cell];
    const int last = grid->cellBegins[cell + 1];
    if (first == last) {
      continue;
    }
    Row rows[MOST_ROWS];
    const int rowCount = rowsAround(grid, &hood, cell, rows);
    int most = 0;
    for (int r = 0; r < rowCount; r++) {
      most += rows[r].last - rows[r].first;
    }
    pairListReserve(list, most * (last - first));
    for (int place = first; place < last; place++) {
      rows[0].first = place + 1;
      for (int r = 0; r < rowCount; r++) {
        addPairs(grid, place, rows[r], limit, list);
      }
    }
  }
}

const PairFinder CONTESTANT(pairFinderCells) = {
    .name = "cells", .idea = "a cell grid, many particles at a time", .make = make, .destroy = destroy, .find = find};
