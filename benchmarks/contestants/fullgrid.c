/* The paper's Grid (section 5): after each change, all particles are put into an empty grid, one after the other, each
 * tested against those that are there already. Particles are searched for some at a time or, as in the paper, one after
 * the other. */
#include "batchsearch.h"
#include "keeper.h"
#include "plainsearch.h"

enum { ENTRIES_PER_PARTICLE = 8, RUN = 16 };

typedef struct FullGrid {
  Keeper keeper;
  Cells cells;
  bool isPlain; /* one after the other */
  Search search;
} FullGrid;

static void destroy(void* self) {
  FullGrid* grid = self;
  if (grid != NULL) {
    cellsFree(&grid->cells);
    keeperDestroy(grid);
  }
}

static void* make(const Scene* scene) {
  FullGrid* grid = keeperMake(scene, sizeof *grid);
  if (grid != NULL && !cellsInit(&grid->cells, scene, cellsReach(scene), ENTRIES_PER_PARTICLE, 1)) {
    destroy(grid);
    return NULL;
  }
  return grid;
}

static void* makePlain(const Scene* scene) {
  FullGrid* grid = make(scene);
  if (grid != NULL) {
    grid->isPlain = true;
  }
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

/* Puts particles first ... last - 1 in; false if one of them clashes. */
static bool insert(FullGrid* grid, const Sphere* spheres, int first, int last) {
  const Scene* scene = grid->keeper.scene;
  int64_t* tests = &grid->keeper.counts.particleTests;
  for (int i = first; i < last; i++) {
    if (!grid->isPlain) {
      searchAdd(&grid->search, &grid->cells, i, &spheres[i]);
    } else if (cellsMeet(&grid->cells, scene, spheres, i, &spheres[i], any, NULL, tests)) {
      return false;
    }
    cellsInsert(&grid->cells, cellOf(&grid->cells, &spheres[i]), i);
  }
  return grid->isPlain || !searchFind(&grid->search, &grid->cells, spheres, 0, any, isClash, (void*)scene, tests);
}

static int anyClash(FullGrid* grid, const Sphere* spheres) {
  const int count = grid->keeper.scene->particleCount;
  cellsClear(&grid->cells);
  for (int first = 0; first < count; first += RUN) {
    const int last = first + RUN < count ? first + RUN : count;
    grid->keeper.counts.updates += last - first;
    if (!insert(grid, spheres, first, last)) {
      return 1;
    }
  }
  return 0;
}

static int testAll(void* self) {
  return anyClash(self, ((Keeper*)self)->spheres);
}

static int test(void* self, int count, const Turn* turns) {
  Keeper* keeper = self;
  Bodies bodies;
  keeperMove(keeper, count, turns, &bodies);
  return anyClash(self, keeper->trial);
}

#define FULL_GRID(itsName, itsIdea, itsMake)                                                                     \
  {                                                                                                              \
    .name = itsName, .idea = itsIdea, .make = itsMake, .destroy = destroy, .test = test, .accept = keeperAccept, \
    .reject = keeperReject, .testAll = testAll, .counts = keeperCounts, .spheres = keeperSpheres                 \
  }

const Contestant CONTESTANT(contestantFullGrid) = FULL_GRID("fullgrid",
                                                            "the paper's Grid: a cell grid of all particles, made anew",
                                                            make);
const Contestant CONTESTANT(contestantFullGridPlain) =
    FULL_GRID("fullgrid-plain", "the same as fullgrid, but searched for one particle after the other", makePlain);
