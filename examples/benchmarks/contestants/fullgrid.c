/* The paper's Grid (section 5): after each change, all particles are put into an empty grid, one after the other, each
 * tested against those that are there already. */
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#include "cells.h"

enum { ENTRIES_PER_PARTICLE = 4 };

typedef struct FullGrid {
  const Scene* scene;
  Cells cells;
  Sphere* spheres;
  Sphere* trial;
  Counts counts;
} FullGrid;

static void destroy(void* self) {
  FullGrid* grid = self;
  if (grid != NULL) {
    cellsFree(&grid->cells);
    free(grid->spheres);
    free(grid->trial);
    free(grid);
  }
}

static void* make(const Scene* scene) {
  FullGrid* grid = calloc(1, sizeof *grid);
  if (grid == NULL) {
    return NULL;
  }
  const size_t bytes = (size_t)scene->particleCount * sizeof(Sphere);
  grid->scene = scene;
  grid->spheres = malloc(bytes);
  grid->trial = malloc(bytes);
  if (!cellsInit(&grid->cells, scene, ENTRIES_PER_PARTICLE) || grid->spheres == NULL || grid->trial == NULL) {
    destroy(grid);
    return NULL;
  }
  memcpy(grid->spheres, scene->spheres, bytes);
  return grid;
}

static bool notExcluded(const void* scene, int i, int j) {
  return !sceneExcludes(scene, i, j);
}

static int anyClash(FullGrid* grid, const Sphere* spheres) {
  cellsClear(&grid->cells);
  for (int i = 0; i < grid->scene->particleCount; i++) {
    grid->counts.updates++;
    if (cellsMeet(&grid->cells, spheres, i, &spheres[i], notExcluded, grid->scene, &grid->counts.particleTests)) {
      return 1;
    }
    cellsInsert(&grid->cells, cellOf(&grid->cells, &spheres[i]), i);
  }
  return 0;
}

static int testAll(void* self) {
  FullGrid* grid = self;
  return anyClash(grid, grid->spheres);
}

static int test(void* self, int count, const Turn* turns) {
  FullGrid* grid = self;
  Bodies bodies;
  bodiesMove(grid->scene, grid->spheres, count, turns, &bodies);
  bodiesApply(&bodies, grid->spheres, grid->trial);
  return anyClash(grid, grid->trial);
}

static bool accept(void* self) {
  FullGrid* grid = self;
  Sphere* trial = grid->spheres;
  grid->spheres = grid->trial;
  grid->trial = trial;
  return true;
}

static void reject(void* self) {
  (void)self;
}

static Counts counts(const void* self) {
  return ((const FullGrid*)self)->counts;
}

static const Sphere* spheres(const void* self) {
  return ((const FullGrid*)self)->spheres;
}

const Contestant CONTESTANT(contestantFullGrid) = {.name = "fullgrid",
                                                   .idea = "the paper's Grid: a cell grid of all particles, made anew",
                                                   .make = make,
                                                   .destroy = destroy,
                                                   .test = test,
                                                   .accept = accept,
                                                   .reject = reject,
                                                   .testAll = testAll,
                                                   .counts = counts,
                                                   .spheres = spheres};
