/* A cell grid that is kept: only what moves relative to the largest rigid piece is looked up, and only an accepted
 * trial is written. A clash ends the search, which begins at the joint, where clashes are most likely. */
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#include "cells.h"

enum { ENTRIES_PER_PARTICLE = 4 };

typedef struct LazyGrid {
  const Scene* scene;
  Cells cells;
  int* entries; /* the cell of each particle */
  Sphere* spheres;
  Sphere* trial;         /* of particles that move */
  unsigned char* bodies; /* of each particle during a test: its body + 1, or 0 if it rests; else 0 */
  Bodies motion;         /* of the trial */
  Counts counts;
} LazyGrid;

static void destroy(void* self) {
  LazyGrid* grid = self;
  if (grid != NULL) {
    cellsFree(&grid->cells);
    free(grid->entries);
    free(grid->spheres);
    free(grid->trial);
    free(grid->bodies);
    free(grid);
  }
}

static void* make(const Scene* scene) {
  LazyGrid* grid = calloc(1, sizeof *grid);
  if (grid == NULL) {
    return NULL;
  }
  const size_t count = (size_t)scene->particleCount;
  grid->scene = scene;
  grid->entries = malloc((count + 1) * sizeof(int));
  grid->spheres = malloc((count + 1) * sizeof(Sphere));
  grid->trial = malloc((count + 1) * sizeof(Sphere));
  grid->bodies = calloc(count + 1, 1);
  if (!cellsInit(&grid->cells, scene, ENTRIES_PER_PARTICLE) || grid->entries == NULL || grid->spheres == NULL ||
      grid->trial == NULL || grid->bodies == NULL) {
    destroy(grid);
    return NULL;
  }
  memcpy(grid->spheres, scene->spheres, count * sizeof(Sphere));
  for (int i = 0; i < scene->particleCount; i++) {
    grid->entries[i] = cellOf(&grid->cells, &grid->spheres[i]);
    cellsInsert(&grid->cells, grid->entries[i], i);
  }
  return grid;
}

/* ---- Test ---- */

/* What a particle is tested against: those of one body, where they were before the trial. */
typedef struct Others {
  const LazyGrid* grid;
  unsigned char body; /* + 1, or 0: what rests */
} Others;

static bool isOther(const void* context, int i, int j) {
  const Others* others = context;
  return others->grid->bodies[j] == others->body && !sceneExcludes(others->grid->scene, i, j);
}

/* Whether particles of a segment, moved by `motion`, meet a body. If `moved` is not NULL, it takes where they are. */
static bool meets(LazyGrid* grid, const Segment* segment, const Rigid* motion, int body, Sphere* moved) {
  const Others others = {grid, (unsigned char)body};
  const bool backwards = segment->first == 0;
  const int count = segment->last - segment->first;
  for (int k = 0; k < count; k++) {
    const int i = backwards ? segment->last - 1 - k : segment->first + k;
    const Sphere sphere = movedSphere(motion, &grid->spheres[i]);
    if (moved != NULL) {
      moved[i] = sphere;
    }
    if (cellsMeet(&grid->cells, grid->spheres, i, &sphere, isOther, &others, &grid->counts.particleTests)) {
      return true;
    }
  }
  return false;
}

/* The smaller of two bodies that move is looked up where the other has not moved. */
static bool bodiesMeet(LazyGrid* grid, int a, int b) {
  const Bodies* motion = &grid->motion;
  const int small = motion->sizes[a] < motion->sizes[b] ? a : b;
  const int large = small == a ? b : a;
  const Rigid back = rigidInvert(&motion->motions[large]);
  const Rigid relative = rigidCompose(&back, &motion->motions[small]);
  for (int s = 0; s < motion->segmentCount; s++) {
    if (motion->segments[s].body == small && meets(grid, &motion->segments[s], &relative, large + 1, NULL)) {
      return true;
    }
  }
  return false;
}

static bool clashes(LazyGrid* grid) {
  const Bodies* motion = &grid->motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    if (segment->body != motion->resting && meets(grid, segment, &motion->motions[segment->body], 0, grid->trial)) {
      return true;
    }
  }
  for (int a = 0; a < motion->bodyCount; a++) {
    for (int b = 0; b < a; b++) {
      if (a != motion->resting && b != motion->resting && bodiesMeet(grid, a, b)) {
        return true;
      }
    }
  }
  return false;
}

static void markBodies(LazyGrid* grid, bool marked) {
  const Bodies* motion = &grid->motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    if (segment->body != motion->resting) {
      memset(grid->bodies + segment->first, marked ? segment->body + 1 : 0, (size_t)(segment->last - segment->first));
    }
  }
}

static int test(void* self, int count, const Turn* turns) {
  LazyGrid* grid = self;
  bodiesMove(grid->scene, grid->spheres, count, turns, &grid->motion);
  markBodies(grid, true);
  const bool clash = clashes(grid);
  markBodies(grid, false);
  return clash;
}

/* ---- After the test ---- */

static bool accept(void* self) {
  LazyGrid* grid = self;
  for (int s = 0; s < grid->motion.segmentCount; s++) {
    const Segment* segment = &grid->motion.segments[s];
    for (int i = segment->first; i < segment->last && segment->body != grid->motion.resting; i++) {
      const int entry = cellOf(&grid->cells, &grid->trial[i]);
      if (entry != grid->entries[i]) {
        cellsRemove(&grid->cells, grid->entries[i], i);
        cellsInsert(&grid->cells, entry, i);
        grid->entries[i] = entry;
        grid->counts.updates++;
      }
      grid->spheres[i] = grid->trial[i];
    }
  }
  return true;
}

static void reject(void* self) {
  (void)self;
}

static Counts counts(const void* self) {
  return ((const LazyGrid*)self)->counts;
}

static const Sphere* spheres(const void* self) {
  return ((const LazyGrid*)self)->spheres;
}

const Contestant CONTESTANT(contestantLazyGrid) = {.name = "lazygrid",
                                                   .idea = "a cell grid that moves only the shorter side",
                                                   .make = make,
                                                   .destroy = destroy,
                                                   .test = test,
                                                   .accept = accept,
                                                   .reject = reject,
                                                   .counts = counts,
                                                   .spheres = spheres};
