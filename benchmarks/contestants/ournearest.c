/* The least distance to obstacles by the engine of this project. */
#include <stdlib.h>

#include "nearest.h"
#include "ourtree.h"

typedef struct OurNearest {
  const Scene* scene;
  ctChainTree* tree;
  ctSelection* chain;
  ctSelection* obstacles;
} OurNearest;

static void destroy(void* self) {
  OurNearest* ours = self;
  if (ours != NULL) {
    ctFreeSelection(ours->chain);
    ctFreeSelection(ours->obstacles);
    ctDestroy(ours->tree);
    free(ours);
  }
}

/* Particles first ... first + count - 1; NULL if there is no memory. */
static ctSelection* selectRun(ctChainTree* tree, int first, int count) {
  ctSelection* selection = NULL;
  int* particles = malloc(((size_t)count + 1) * sizeof(int));
  for (int i = 0; particles != NULL && i < count; i++) {
    particles[i] = first + i;
  }
  if (particles != NULL) {
    ctSelect(tree, count, particles, &selection);
  }
  free(particles);
  return selection;
}

static void* make(const Scene* scene, int obstacleCount, const double* obstacles) {
  OurNearest* ours = calloc(1, sizeof *ours);
  if (ours == NULL) {
    return NULL;
  }
  ours->scene = scene;
  ours->tree = ourTreeOf(scene, 0, obstacleCount, obstacles);
  ours->chain = ours->tree == NULL ? NULL : selectRun(ours->tree, 0, scene->particleCount);
  ours->obstacles = ours->tree == NULL ? NULL : selectRun(ours->tree, scene->particleCount, obstacleCount);
  if (ours->chain == NULL || ours->obstacles == NULL) {
    destroy(ours);
    return NULL;
  }
  return ours;
}

static bool turn(void* self, Turn turn) {
  OurNearest* ours = self;
  const ctChange change = {.link = ours->scene->torsions[turn.torsion].link, .angle = turn.angle};
  return ctPropose(ours->tree, 1, &change) == ctSuccess && ctAccept(ours->tree, NULL) == ctSuccess;
}

static bool find(void* self, Nearest* nearest) {
  OurNearest* ours = self;
  int pair[2];
  if (ctGetMinimumDistance(ours->tree, ours->chain, ours->obstacles, &nearest->distance, pair, NULL) != ctSuccess) {
    return false;
  }
  nearest->particle = pair[0];
  nearest->obstacle = pair[1] - ours->scene->particleCount;
  return true;
}

const NearestFinder nearestFinderOurs = {
    .name = "ours", .idea = "the engine of this project", .make = make, .destroy = destroy, .turn = turn, .find = find};
