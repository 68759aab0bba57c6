/* A cell grid that is kept. Particles are searched for some at a time, or one after the other; positions are kept in
 * double, or, to see what that costs, in single precision. */
#include "batchsearch.h"
#include "lazy.h"
#include "plainsearch.h"

enum { ENTRIES_PER_PARTICLE = 8 };

typedef struct LazyGrid {
  Lazy lazy;
  Cells cells;
  int* entries; /* the cell of each particle */
  Search search;
} LazyGrid;

static void destroy(void* self) {
  LazyGrid* grid = self;
  if (grid != NULL) {
    cellsFree(&grid->cells);
    free(grid->entries);
    lazyDestroy(grid);
  }
}

static void* make(const Scene* scene) {
  LazyGrid* grid = lazyMake(scene, sizeof *grid);
  if (grid == NULL) {
    return NULL;
  }
  grid->entries = malloc(((size_t)scene->particleCount + 1) * sizeof(int));
  if (!cellsInit(&grid->cells, scene, cellsReach(scene), ENTRIES_PER_PARTICLE, 1) || grid->entries == NULL) {
    destroy(grid);
    return NULL;
  }
  for (int i = 0; i < scene->particleCount; i++) {
    grid->entries[i] = cellOf(&grid->cells, &scene->spheres[i]);
    cellsInsert(&grid->cells, grid->entries[i], i);
  }
  return grid;
}

/* ---- Test ---- */

__attribute__((always_inline)) static inline bool runMeetsAt(Lazy* lazy, const Run* run, bool isSingle) {
  LazyGrid* grid = (LazyGrid*)lazy;
  Keeper* keeper = &lazy->keeper;
  Others others = lazyOthers(lazy, run);
  for (int i = run->first; i < run->last; i++) {
    run->moved[i] = movedSphere(run->motion, &keeper->spheres[i]);
    for (int k = 0; k < 3 && isSingle; k++) {
      run->moved[i].x[k] = (float)run->moved[i].x[k];
    }
    searchAdd(&grid->search, &grid->cells, i, &run->moved[i]);
  }
  return searchFind(&grid->search, &grid->cells, keeper->spheres, 0, isOther, otherIsClash, &others,
                    &keeper->counts.particleTests);
}

static bool runMeets(Lazy* lazy, const Run* run) {
  return runMeetsAt(lazy, run, false);
}

static bool runMeetsSingle(Lazy* lazy, const Run* run) {
  return runMeetsAt(lazy, run, true);
}

static bool runMeetsPlain(Lazy* lazy, const Run* run) {
  LazyGrid* grid = (LazyGrid*)lazy;
  Keeper* keeper = &lazy->keeper;
  Others others = lazyOthers(lazy, run);
  for (int i = run->first; i < run->last; i++) {
    run->moved[i] = movedSphere(run->motion, &keeper->spheres[i]);
    if (cellsMeet(&grid->cells, keeper->scene, keeper->spheres, i, &run->moved[i], isOther, &others,
                  &keeper->counts.particleTests)) {
      return true;
    }
  }
  return false;
}

static int test(void* self, int count, const Turn* turns) {
  return lazyTest(self, count, turns, runMeets);
}

static int testSingle(void* self, int count, const Turn* turns) {
  return lazyTest(self, count, turns, runMeetsSingle);
}

static int testPlain(void* self, int count, const Turn* turns) {
  return lazyTest(self, count, turns, runMeetsPlain);
}

/* ---- After the test ---- */

static bool accept(void* self) {
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
        keeper->counts.updates++;
      }
      keeper->spheres[i] = keeper->trial[i];
    }
  }
  return true;
}

#define LAZY_GRID(itsName, itsIdea, itsTest)                                                               \
  {                                                                                                        \
    .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .test = itsTest, .accept = accept, \
    .reject = keeperReject, .counts = keeperCounts, .spheres = keeperSpheres                               \
  }

const Contestant CONTESTANT(contestantLazyGrid) = LAZY_GRID("lazygrid", "a cell grid that moves only the shorter side",
                                                            test);
const Contestant CONTESTANT(contestantLazyGridPlain) =
    LAZY_GRID("lazygrid-plain", "the same as lazygrid, but searched for one particle after the other", testPlain);
const Contestant CONTESTANT(contestantLazyGridSingle) = LAZY_GRID("lazygrid-single",
                                                                  "the lazy grid with positions kept in single",
                                                                  testSingle);
