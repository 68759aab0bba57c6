/* A cell grid that is kept: only what moves relative to the largest rigid piece is looked up, and only an accepted
 * trial is written. A clash ends the search. A file that includes this is one contestant; before, it defines BATCHED as
 * 1 if particles are searched for some at a time, else 0, and, if it likes, SINGLE as 1: positions are kept in single
 * precision. */
#include <stdlib.h>
#include <string.h>

#include "bodies.h"

#ifndef SINGLE
#define SINGLE 0
#endif

#if BATCHED
#include "batchsearch.h"
#else
#include "plainsearch.h"
#endif

enum { ENTRIES_PER_PARTICLE = 8, RUN = 16, STRIDE = 8 };

/* Turns below, rad, are small. */
#define SMALL_ANGLE 0.3

typedef struct LazyGrid {
  const Scene* scene;
  Cells cells;
#if BATCHED
  Search search;
#endif
  int* entries; /* the cell of each particle */
  Sphere* spheres;
  Sphere* trial;         /* of particles that move */
  Sphere* seen;          /* the same, seen from another body that moves */
  unsigned char* bodies; /* of each particle during a test: its body + 1, or 0 if it rests; else 0 */
  Bodies motion;         /* of the trial */
  bool isSmall;          /* no torsion turns far */
  Counts counts;
} LazyGrid;

static void destroy(void* self) {
  LazyGrid* grid = self;
  if (grid != NULL) {
    cellsFree(&grid->cells);
    free(grid->entries);
    free(grid->spheres);
    free(grid->trial);
    free(grid->seen);
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
  grid->seen = malloc((count + 1) * sizeof(Sphere));
  grid->bodies = calloc(count + 1, 1);
  if (!cellsInit(&grid->cells, scene, ENTRIES_PER_PARTICLE) || grid->entries == NULL || grid->spheres == NULL ||
      grid->trial == NULL || grid->seen == NULL || grid->bodies == NULL) {
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
  const unsigned char* bodies; /* of each particle */
  unsigned char body;          /* + 1, or 0: what rests */
} Others;

static int isOther(const void* context, int j) {
  const Others* others = context;
  return others->bodies[j] == others->body;
}

static Sphere movedAndKept(const Rigid* motion, const Sphere* sphere) {
  Sphere moved = movedSphere(motion, sphere);
  for (int k = 0; k < 3 && SINGLE; k++) {
    moved.x[k] = (float)moved.x[k];
  }
  return moved;
}

/* Whether particles first ... last - 1, moved by `motion`, meet a body; `moved` takes where they are. */
static bool runMeets(LazyGrid* grid, int first, int last, const Rigid* motion, int body, Sphere* moved) {
  const Others others = {grid->bodies, (unsigned char)body};
  for (int i = first; i < last; i++) {
    moved[i] = movedAndKept(motion, &grid->spheres[i]);
#if BATCHED
    searchAdd(&grid->search, &grid->cells, i, &moved[i]);
  }
  return searchMeets(&grid->search, &grid->cells, grid->scene, grid->spheres, isOther, &others,
                     &grid->counts.particleTests);
#else
    if (cellsMeet(&grid->cells, grid->scene, grid->spheres, i, &moved[i], isOther, &others,
                  &grid->counts.particleTests)) {
      return true;
    }
  }
  return false;
#endif
}

/* The same of a segment. Its particles are taken run by run: after large turns from the joint on, near which
 * clashes are most likely; after small ones every so often along the segment, since far from the axis particles move
 * most, and neighbours move much alike. */
static bool meets(LazyGrid* grid, const Segment* segment, const Rigid* motion, int body, Sphere* moved) {
  const int runs = (segment->last - segment->first + RUN - 1) / RUN;
  const int stride = grid->isSmall ? STRIDE : 1;
  const bool backwards = (segment->first == 0) != grid->isSmall;
  for (int phase = 0; phase < stride; phase++) {
    for (int r = phase; r < runs; r += stride) {
      const int first = segment->first + RUN * (backwards ? runs - 1 - r : r);
      const int last = first + RUN < segment->last ? first + RUN : segment->last;
      if (runMeets(grid, first, last, motion, body, moved)) {
        return true;
      }
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
    if (motion->segments[s].body == small && meets(grid, &motion->segments[s], &relative, large + 1, grid->seen)) {
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
  grid->isSmall = true;
  for (int i = 0; i < count; i++) {
    grid->isSmall = grid->isSmall && fabs(turns[i].angle) < SMALL_ANGLE;
  }
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

#define LAZY_GRID(itsName, itsIdea)                                                                     \
  {                                                                                                     \
    .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .test = test, .accept = accept, \
    .reject = reject, .counts = counts, .spheres = spheres                                              \
  }
