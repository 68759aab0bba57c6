/* The lazy grid for machines that compare many numbers at a time: the particles of a cell lie in blocks of as many as
 * there are lanes, coordinate by coordinate, in single precision. What these find near is tested in double. */
#include "cells.h"
#include "lanes.h"
#include "lazy.h"

enum { ENTRIES_PER_PARTICLE = 8, NO_BLOCK = -1 };

/* Coordinates of lanes without a particle: their squares are still numbers. */
#define FAR_AWAY 1e18f

/* What distances in single precision may be wrong by, as a part of the coordinates. */
#define SINGLE_ERROR 1e-6

typedef struct Block {
  float x[LANES];
  float y[LANES];
  float z[LANES];
  float radii[LANES];
  int particles[LANES];
  int count; /* of particles; only the first block of a cell is not full */
  int next;  /* the block behind it in its cell, or among the unused ones; NO_BLOCK: none */
} Block;

/* A particle that searches for others, in single precision. */
typedef struct Searcher {
  float x;
  float y;
  float z;
  float radius; /* larger by what may be rounded */
} Searcher;

/* The particles of a run as searchers, and the blocks around them. */
typedef struct BlockSearch {
  Searcher run[RUN];
  int count; /* of pairs of a searcher and a block */
  int searchers[RUN * MOST_CELLS_AROUND];
  int blocks[RUN * MOST_CELLS_AROUND];
} BlockSearch;

typedef struct SimdGrid {
  Lazy lazy;
  Cells cells;
  int* entries; /* the cell of each particle */
  int* places;  /* of each particle: its block, times LANES, and its lane */
  int blockCapacity;
  int blockCount; /* of those ever used */
  int unused;     /* the first of them that holds nothing; NO_BLOCK: none */
  Block* blocks;
  BlockSearch search;
} SimdGrid;

static void destroy(void* self) {
  SimdGrid* grid = self;
  cellsFree(&grid->cells);
  free(grid->entries);
  free(grid->places);
  free(grid->blocks);
  lazyDestroy(grid);
}

/* ---- Blocks ---- */

/* An empty block. */
static int takeBlock(SimdGrid* grid) {
  int block = grid->unused;
  if (block != NO_BLOCK) {
    grid->unused = grid->blocks[block].next;
  } else {
    if (grid->blockCount == grid->blockCapacity) {
      grid->blockCapacity += grid->blockCapacity / 2 + 64;
      grid->blocks = reallocate(grid->blocks, grid->blockCapacity, sizeof(Block));
    }
    block = grid->blockCount++;
    grid->blocks[block] = (Block){.count = 0};
    for (int lane = 0; lane < LANES; lane++) {
      grid->blocks[block].x[lane] = FAR_AWAY;
    }
  }
  grid->blocks[block].next = NO_BLOCK;
  return block;
}

static void setLane(SimdGrid* grid, int place, int particle, const Sphere* sphere) {
  Block* block = &grid->blocks[place / LANES];
  const int lane = place % LANES;
  block->x[lane] = (float)sphere->x[0];
  block->y[lane] = (float)sphere->x[1];
  block->z[lane] = (float)sphere->x[2];
  block->radii[lane] = (float)sphere->radius;
  block->particles[lane] = particle;
  grid->places[particle] = place;
}

static void insert(SimdGrid* grid, int entry, int particle, const Sphere* sphere) {
  int* head = &grid->cells.heads[entry];
  if (*head == NO_BLOCK || grid->blocks[*head].count == LANES) {
    const int block = takeBlock(grid);
    grid->blocks[block].next = *head;
    *head = block;
  }
  grid->entries[particle] = entry;
  setLane(grid, *head * LANES + grid->blocks[*head].count++, particle, sphere);
}

/* The last particle of the first block of its cell takes its place. */
static void takeOut(SimdGrid* grid, int particle) {
  int* head = &grid->cells.heads[grid->entries[particle]];
  Block* block = &grid->blocks[*head];
  const int last = --block->count;
  const int mover = block->particles[last];
  const int place = grid->places[particle];
  Block* hole = &grid->blocks[place / LANES];
  const int lane = place % LANES;
  hole->x[lane] = block->x[last];
  hole->y[lane] = block->y[last];
  hole->z[lane] = block->z[last];
  hole->radii[lane] = block->radii[last];
  hole->particles[lane] = mover;
  grid->places[mover] = place;
  block->x[last] = FAR_AWAY;
  if (last == 0) {
    const int emptied = *head;
    *head = block->next;
    block->next = grid->unused;
    grid->unused = emptied;
  }
}

static void* make(const Scene* scene) {
  SimdGrid* grid = lazyMake(scene, sizeof *grid);
  grid->unused = NO_BLOCK;
  grid->entries = allocate(scene->particleCount, sizeof(int));
  grid->places = allocate(scene->particleCount, sizeof(int));
  cellsInit(&grid->cells, scene, cellsReach(scene), ENTRIES_PER_PARTICLE, LANES);
  for (int i = 0; i < scene->particleCount; i++) {
    insert(grid, cellOf(&grid->cells, &scene->spheres[i]), i, &scene->spheres[i]);
  }
  return grid;
}

/* ---- Test ---- */

/* A particle of the run, and the cells around it that hold something. */
static void addSearcher(SimdGrid* grid, int searcher, const Sphere* sphere) {
  const CellsAround around = cellsAround(&grid->cells, sphere);
  const double farthest = fmax(fabs(sphere->x[0]), fmax(fabs(sphere->x[1]), fabs(sphere->x[2])));
  const double room = SINGLE_ERROR * (farthest + grid->cells.reach);
  grid->search.run[searcher] =
      (Searcher){(float)sphere->x[0], (float)sphere->x[1], (float)sphere->x[2], (float)(sphere->radius + room)};
  const int along = grid->cells.along;
  BlockSearch* search = &grid->search;
  int count = search->count;
  for (int z = 0; z < along; z++) {
    for (int y = 0; y < along; y++) {
      for (int x = 0; x < along; x++) {
        const int head = grid->cells.heads[around.parts[0][x] | around.parts[1][y] | around.parts[2][z]];
        search->searchers[count] = searcher;
        search->blocks[count] = head;
        count += head != NO_BLOCK;
      }
    }
  }
  search->count = count;
}

/* Which lanes of a block may touch a searcher; those of its own segment move with it. */
static inline unsigned lanesNear(const Block* block, const Segment* own, const Searcher* searcher) {
  const Lanes squared = squaredDistances(lanesOf(searcher->x), lanesOf(searcher->y), lanesOf(searcher->z),
                                         lanesLoad(block->x), lanesLoad(block->y), lanesLoad(block->z));
  const Lanes sum = lanesSum(lanesOf(searcher->radius), lanesLoad(block->radii));
  const IntLanes particles = intLanesLoad(block->particles);
  const unsigned moving =
      intLanesBelow(particles, intLanesOf(own->last)) & ~intLanesBelow(particles, intLanesOf(own->first));
  return lanesAtMost(squared, lanesSquare(sum)) & ~moving;
}

/* Whether one of the lanes of a mask is of the body asked about, overlaps particle i, and is not excluded. */
static bool lanesMeet(const Lazy* lazy, const Run* run, const Block* block, unsigned lanes, int i) {
  const Sphere* sphere = &run->moved[i];
  for (; lanes != 0; lanes &= lanes - 1) {
    const int j = block->particles[lowestBit(lanes)];
    const Sphere* other = &lazy->keeper.spheres[j];
    const double sum = sphere->radius + other->radius;
    if (lazy->bodies[j] == run->body && squaredDistance(sphere->x, other->x) < sum * sum &&
        !sceneExcludes(lazy->keeper.scene, i, j)) {
      return true;
    }
  }
  return false;
}

/* The cells around all particles of the run are looked up before any distance is computed, as batchsearch.h says. */
static bool runMeets(Lazy* lazy, const Run* run) {
  SimdGrid* grid = (SimdGrid*)lazy;
  BlockSearch* search = &grid->search;
  search->count = 0;
  for (int i = run->first; i < run->last; i++) {
    run->moved[i] = movedSphere(run->motion, &lazy->keeper.spheres[i]);
    addSearcher(grid, i - run->first, &run->moved[i]);
  }
  while (search->count > 0) {
    int left = 0;
    for (int k = 0; k < search->count; k++) {
      const int searcher = search->searchers[k];
      const Block* block = &grid->blocks[search->blocks[k]];
      search->searchers[left] = searcher;
      search->blocks[left] = block->next;
      left += block->next != NO_BLOCK;
      lazy->keeper.counts.particleTests += block->count;
      const unsigned lanes = lanesNear(block, run->segment, &search->run[searcher]);
      if (lanes != 0 && lanesMeet(lazy, run, block, lanes, run->first + searcher)) {
        return true;
      }
    }
    search->count = left;
  }
  return false;
}

static bool test(void* self, int count, const Turn* turns) {
  return lazyTest(self, count, turns, runMeets);
}

/* ---- After the test ---- */

static void accept(void* self) {
  SimdGrid* grid = self;
  Keeper* keeper = &grid->lazy.keeper;
  const Bodies* motion = &grid->lazy.motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    for (int i = segment->first; i < segment->last && segment->body != motion->resting; i++) {
      const Sphere* sphere = &keeper->trial[i];
      const int entry = cellOf(&grid->cells, sphere);
      keeper->spheres[i] = *sphere;
      if (entry == grid->entries[i]) {
        setLane(grid, grid->places[i], i, sphere);
        continue;
      }
      takeOut(grid, i);
      insert(grid, entry, i, sphere);
    }
  }
}

const Contestant CONTESTANT(contestantSimdGrid) = {.name = "simdgrid",
                                                   .idea = "the lazy grid, particles of a cell compared many at a time",
                                                   .make = make,
                                                   .destroy = destroy,
                                                   .test = test,
                                                   .accept = accept,
                                                   .reject = keeperReject,
                                                   .counts = keeperCounts,
                                                   .spheres = keeperSpheres};
