/* The least distance to obstacles by the engine of this project. */
#include <stdlib.h>

#include "nearest.h"
#include "ourtree.h"

typedef struct OurNearest {
  const Scene* scene;
  ctChainTree* tree;
  int obstacleCount;
  int* particles; /* of the chain, then the obstacles */
} OurNearest;

static void destroy(void* self) {
  OurNearest* ours = self;
  if (ours != NULL) {
    ctDestroy(ours->tree);
    free(ours->particles);
    free(ours);
  }
}

static void* make(const Scene* scene, int obstacleCount, const double* obstacles) {
  OurNearest* ours = calloc(1, sizeof *ours);
  if (ours == NULL) {
    return NULL;
  }
  const int count = scene->particleCount + obstacleCount;
  ours->scene = scene;
  ours->tree = ourTreeOf(scene, 0, obstacleCount, obstacles);
  ours->obstacleCount = obstacleCount;
  ours->particles = malloc(((size_t)count + 1) * sizeof(int));
  if (ours->tree == NULL || ours->particles == NULL) {
    destroy(ours);
    return NULL;
  }
  for (int i = 0; i < count; i++) {
    ours->particles[i] = i;
  }
  return ours;
}

static bool turn(void* self, Turn turn) {
  OurNearest* ours = self;
  const ctChange change = {.link = ours->scene->torsions[turn.torsion].link, .angle = turn.angle};
  return ctPropose(ours->tree, 1, &change) == ctSuccess && ctCommit(ours->tree, NULL) == ctSuccess;
}

static bool find(void* self, Nearest* nearest) {
  OurNearest* ours = self;
  const int count = ours->scene->particleCount;
  int pair[2];
  if (ctGetMinimumDistance(ours->tree, count, ours->particles, ours->obstacleCount, ours->particles + count,
                           &nearest->distance, pair) != ctSuccess) {
    return false;
  }
  const bool chainFirst = pair[0] < count;
  nearest->particle = pair[chainFirst ? 0 : 1];
  nearest->obstacle = pair[chainFirst ? 1 : 0] - count;
  return true;
}

const NearestFinder nearestFinderOurs = {
    .name = "ours", .idea = "the engine of this project", .make = make, .destroy = destroy, .turn = turn, .find = find};
