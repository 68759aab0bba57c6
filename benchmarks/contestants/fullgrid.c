/* The paper's Grid (section 5): after each change, all particles are put into an empty grid, one after the other, each
 * tested against the particles already in it. Some particles are searched for at a time. */
#include "batchsearch.h"
#include "keeper.h"

enum { ENTRIES_PER_PARTICLE = 8, RUN = 16 };

typedef struct FullGrid {
  Keeper keeper;
  Cells cells;
  Search search;
} FullGrid;

static void destroy(void* self) {
  cellsFree(&((FullGrid*)self)->cells);
  keeperDestroy(self);
}

static void* make(const Scene* scene) {
  FullGrid* grid = keeperMake(scene, sizeof *grid);
  cellsInit(&grid->cells, scene, cellsReach(scene), ENTRIES_PER_PARTICLE, 1);
  return grid;
}

static int any(const void* context, int j) {
  (void)context;
  (void)j;
  return 1;
}

static bool isClash(void* context, int i, int j) {
  return !sceneExcludes(context, i, j);
}

static bool test(void* self, int count, const Turn* turns) {
  FullGrid* grid = self;
  Keeper* keeper = self;
  Bodies bodies;
  keeperMove(keeper, count, turns, &bodies);
  const int particles = keeper->scene->particleCount;
  cellsClear(&grid->cells);
  for (int first = 0; first < particles; first += RUN) {
    for (int i = first; i < first + RUN && i < particles; i++) {
      searchAdd(&grid->search, &grid->cells, i, &keeper->trial[i]);
      cellsInsert(&grid->cells, cellOf(&grid->cells, &keeper->trial[i]), i);
    }
    if (searchFind(&grid->search, &grid->cells, keeper->trial, 0, any, isClash, (void*)keeper->scene,
                   &keeper->counts.particleTests)) {
      return true;
    }
  }
  return false;
}

const Contestant CONTESTANT(contestantFullGrid) = {
    .name = "fullgrid",
    .idea = "the paper's Grid: a cell grid of all particles for each trial",
    .make = make,
    .destroy = destroy,
    .test = test,
    .accept = keeperAccept,
    .reject = keeperReject,
    .counts = keeperCounts,
    .spheres = keeperSpheres};
