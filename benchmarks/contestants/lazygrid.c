/* A cell grid that is kept. Some particles are searched for at a time. */
#include "batchsearch.h"
#include "lazy.h"

enum { ENTRIES_PER_PARTICLE = 8 };

typedef struct LazyGrid {
  Lazy lazy;
  Cells cells;
  int* entries; /* the cell of each particle */
  Search search;
} LazyGrid;

static void destroy(void* self) {
  LazyGrid* grid = self;
  cellsFree(&grid->cells);
  free(grid->entries);
  lazyDestroy(grid);
}

static void* make(const Scene* scene) {
  LazyGrid* grid = lazyMake(scene, sizeof *grid);
  grid->entries = allocate(scene->particleCount, sizeof(int));
  cellsInit(&grid->cells, scene, cellsReach(scene), ENTRIES_PER_PARTICLE, 1);
  for (int i = 0; i < scene->particleCount; i++) {
    grid->entries[i] = cellOf(&grid->cells, &scene->spheres[i]);
    cellsInsert(&grid->cells, grid->entries[i], i);
  }
  return grid;
}

static bool runMeets(Lazy* lazy, const Run* run) {
  LazyGrid* grid = (LazyGrid*)lazy;
  Keeper* keeper = &lazy->keeper;
  Others others = lazyOthers(lazy, run);
  for (int i = run->first; i < run->last; i++) {
    run->moved[i] = movedSphere(run->motion, &keeper->spheres[i]);
    searchAdd(&grid->search, &grid->cells, i, &run->moved[i]);
  }
  return searchFind(&grid->search, &grid->cells, keeper->spheres, 0, isOther, otherIsClash, &others,
                    &keeper->counts.particleTests);
}

static bool test(void* self, int count, const Turn* turns) {
  return lazyTest(self, count, turns, runMeets);
}

static void accept(void* self) {
  LazyGrid* grid = self;
  Keeper* keeper = &grid->lazy.keeper;
  const Bodies* motion = &grid->lazy.motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    for (int i = segment->first; i < segment->last && segment->body != motion->resting; i++) {
      const int entry = cellOf(&grid->cells, &keeper->trial[i]);
      if (entry != grid->entries[i]) {
        cellsRemove(&grid->cells, grid->entries[i], i);
        cellsInsert(&grid->cells, entry, i);
        grid->entries[i] = entry;
      }
      keeper->spheres[i] = keeper->trial[i];
    }
  }
}

const Contestant CONTESTANT(contestantLazyGrid) = {.name = "lazygrid",
                                                   .idea = "a cell grid that moves only the shorter side",
                                                   .make = make,
                                                   .destroy = destroy,
                                                   .test = test,
                                                   .accept = accept,
                                                   .reject = keeperReject,
                                                   .counts = keeperCounts,
                                                   .spheres = keeperSpheres};
