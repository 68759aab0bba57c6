/* The paper's Grid (section 5): after each change, all particles are put into an empty grid, one after the other, each
 * tested against those that are there already. A file that includes this is one contestant; before, it defines BATCHED
 * as 1 if particles are searched for some at a time, else 0. */
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#if BATCHED
#include "batchsearch.h"
#else
#include "plainsearch.h"
#endif

enum { ENTRIES_PER_PARTICLE = 8, RUN = 16 };

typedef struct FullGrid {
  const Scene* scene;
  Cells cells;
#if BATCHED
  Search search;
#endif
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

static int any(const void* context, int j) {
  (void)context;
  (void)j;
  return 1;
}

/* Puts particles first ... last - 1 in; false if one of them clashes. */
static bool insert(FullGrid* grid, const Sphere* spheres, int first, int last) {
  for (int i = first; i < last; i++) {
#if BATCHED
    searchAdd(&grid->search, &grid->cells, i, &spheres[i]);
    cellsInsert(&grid->cells, cellOf(&grid->cells, &spheres[i]), i);
  }
  return !searchMeets(&grid->search, &grid->cells, grid->scene, spheres, any, NULL, &grid->counts.particleTests);
#else
    if (cellsMeet(&grid->cells, grid->scene, spheres, i, &spheres[i], any, NULL, &grid->counts.particleTests)) {
      return false;
    }
    cellsInsert(&grid->cells, cellOf(&grid->cells, &spheres[i]), i);
  }
  return true;
#endif
}

static int anyClash(FullGrid* grid, const Sphere* spheres) {
  const int count = grid->scene->particleCount;
  cellsClear(&grid->cells);
  for (int first = 0; first < count; first += RUN) {
    const int last = first + RUN < count ? first + RUN : count;
    grid->counts.updates += last - first;
    if (!insert(grid, spheres, first, last)) {
      return 1;
    }
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

#define FULL_GRID(itsName, itsIdea)                                                                     \
  {                                                                                                     \
    .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .test = test, .accept = accept, \
    .reject = reject, .testAll = testAll, .counts = counts, .spheres = spheres                          \
  }
