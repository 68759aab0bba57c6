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
  /* of pairs in order: */
  int* higher; /* neighbours of one particle */
  float* distances;
  float* byParticle; /* their distances, by their indices */
  uint64_t* bits;    /* one for each particle, set for neighbours */
  uint64_t* words;   /* one bit for each word of bits */
} PairGrid;

static void destroy(void* self) {
  PairGrid* grid = self;
  if (grid != NULL) {
    free(grid->cellBegins);
    free(grid->cells);
    free(grid->x);
    free(grid->y);
    free(grid->z);
    free(grid->ids);
    free(grid->higher);
    free(grid->distances);
    free(grid->byParticle);
    free(grid->bits);
    free(grid->words);
    free(grid);
  }
}

static void* make(const Scene* scene) {
  PairGrid* grid = calloc(1, sizeof *grid);
  if (grid == NULL) {
    return NULL;
  }
  /* Behind the last particle, a full load may be made. */
  const size_t padded = (size_t)scene->particleCount + LANES;
  grid->particleCount = scene->particleCount;
  grid->mostCells = 16 * scene->particleCount + 64;
  grid->cellBegins = calloc((size_t)grid->mostCells + 2, sizeof(int));
  grid->cells = calloc(padded, sizeof(int));
  grid->x = calloc(padded, sizeof(float));
  grid->y = calloc(padded, sizeof(float));
  grid->z = calloc(padded, sizeof(float));
  grid->ids = calloc(padded, sizeof(int));
  grid->higher = calloc(padded, sizeof(int));
  grid->distances = calloc(padded, sizeof(float));
  grid->byParticle = calloc(padded, sizeof(float));
  grid->bits = calloc(padded / 64 + 1, sizeof(uint64_t));
  grid->words = calloc(padded / 4096 + 1, sizeof(uint64_t));
  if (grid->cellBegins == NULL || grid->cells == NULL || grid->x == NULL || grid->y == NULL || grid->z == NULL ||
      grid->ids == NULL || grid->higher == NULL || grid->distances == NULL || grid->byParticle == NULL ||
      grid->bits == NULL || grid->words == NULL) {
    destroy(grid);
    return NULL;
  }
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

/* The rows around a cell that hold particles; if `half`, only the cell's own row from the cell on, and those behind. */
static int rowsAround(const PairGrid* grid, const Neighborhood* hood, int cell, bool half, Row* rows) {
  const int* dims = grid->dims;
  const int cx = cell % dims[0];
  const int cy = cell / dims[0] % dims[1];
  const int cz = cell / dims[0] / dims[1];
  int count = 0;
  for (int z = half ? cz : cz - hood->reach; z <= cz + hood->reach; z++) {
    for (int y = half && z == cz ? cy : cy - hood->reach; y <= cy + hood->reach; y++) {
      const int along = hood->alongs[y < cy ? cy - y : y - cy][z < cz ? cz - z : z - cz];
      if (z < 0 || z >= dims[2] || y < 0 || y >= dims[1] || along < 0) {
        continue;
      }
      const int row = (z * dims[1] + y) * dims[0];
      const int from = half && z == cz && y == cy ? cx : cx - along < 0 ? 0 : cx - along;
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

/* ---- Pairs in any order ---- */

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

static bool findUnsorted(void* self, const double* positions, double cutoff, PairList* list) {
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
    const int rowCount = rowsAround(grid, &hood, cell, true, rows);
    int most = 0;
    for (int r = 0; r < rowCount; r++) {
      most += rows[r].last - rows[r].first;
    }
    if (!pairListReserve(list, most * (last - first))) {
      return false;
    }
    for (int place = first; place < last; place++) {
      rows[0].first = place + 1;
      for (int r = 0; r < rowCount; r++) {
        addPairs(grid, place, rows[r], limit, list);
      }
    }
  }
  return true;
}

/* ---- Pairs in order ---- */

/* Writes the neighbours of particle i that have a higher index, and their squared distances; returns how many. */
static int gatherHigher(PairGrid* grid, const double* positions, int i, const Row* rows, int rowCount, Lanes limit) {
  const Lanes x = lanesOf((float)(positions[3 * i] - grid->low[0]));
  const Lanes y = lanesOf((float)(positions[3 * i + 1] - grid->low[1]));
  const Lanes z = lanesOf((float)(positions[3 * i + 2] - grid->low[2]));
  const IntLanes id = intLanesOf(i);
  const float* restrict xs = grid->x;
  const float* restrict ys = grid->y;
  const float* restrict zs = grid->z;
  const int* restrict ids = grid->ids;
  int* restrict higher = grid->higher;
  float* restrict distances = grid->distances;
  int count = 0;
  for (int r = 0; r < rowCount; r++) {
    for (int t = rows[r].first; t < rows[r].last; t += LANES) {
      const Lanes squared = squaredDistances(x, y, z, lanesLoad(xs + t), lanesLoad(ys + t), lanesLoad(zs + t));
      const IntLanes others = intLanesLoad(ids + t);
      const unsigned near = lanesAtMost(squared, limit) & intLanesBelow(id, others) & firstLanes(rows[r].last - t);
      intLanesStoreSome(higher + count, near, others);
      lanesStoreSome(distances + count, near, squared);
      count += bitCount(near);
    }
  }
  return count;
}

/* Appends the pairs of particle i with its gathered neighbours, sorted by setting bits and finding them again: one bit
 * for each particle, and one for each word of these that is not 0. */
static void addSorted(PairGrid* grid, int i, int count, PairList* list) {
  uint64_t* restrict bits = grid->bits;
  uint64_t* restrict words = grid->words;
  float* restrict byParticle = grid->byParticle;
  float* restrict distances = grid->distances;
  const int* restrict higher = grid->higher;
  for (int k = 0; k < count; k += LANES) {
    lanesStore(distances + k, lanesSquareRoot(lanesLoad(distances + k)));
  }
  for (int k = 0; k < count; k++) {
    const unsigned j = (unsigned)higher[k];
    bits[j / 64] |= (uint64_t)1 << (j % 64);
    words[j / 4096] |= (uint64_t)1 << (j / 64 % 64);
    byParticle[j] = distances[k];
  }
  int* restrict first = list->first;
  int* restrict second = list->second;
  double* restrict column = list->distances;
  int place = list->count;
  list->count += count;
  for (int w = i / 4096; place < list->count; w++) {
    for (; words[w] != 0; words[w] &= words[w] - 1) {
      const int b = 64 * w + lowestBit(words[w]);
      for (uint64_t left = bits[b]; left != 0; left &= left - 1) {
        const int j = 64 * b + lowestBit(left);
        first[place] = i;
        second[place] = j;
        column[place++] = (double)byParticle[j];
      }
      bits[b] = 0;
    }
  }
}

static bool findSorted(void* self, const double* positions, double cutoff, PairList* list) {
  PairGrid* grid = self;
  layOut(grid, positions, cutoff);
  fillCells(grid, positions);
  const Neighborhood hood = neighborhoodOf(grid, cutoff);
  const Lanes limit = lanesOf((float)(cutoff * cutoff));
  list->count = 0;
  for (int i = 0; i < grid->particleCount; i++) {
    Row rows[MOST_ROWS];
    const int rowCount = rowsAround(grid, &hood, grid->cells[i], false, rows);
    const int count = gatherHigher(grid, positions, i, rows, rowCount, limit);
    if (!pairListReserve(list, count)) {
      return false;
    }
    addSorted(grid, i, count, list);
  }
  return true;
}

const PairFinder CONTESTANT(pairFinderCells) = {.name = "cells",
                                                .idea = "a cell grid, many particles at a time",
                                                .order = pairsInAnyOrder,
                                                .make = make,
                                                .destroy = destroy,
                                                .find = findUnsorted};

const PairFinder CONTESTANT(pairFinderCellsSorted) = {.name = "cells-sorted",
                                                      .idea = "a cell grid, many particles at a time, pairs in order",
                                                      .order = pairsSorted,
                                                      .make = make,
                                                      .destroy = destroy,
                                                      .find = findSorted};
