/* K-OBBTree (section 5): after each change, a tree of boxes of each rigid piece, tested against those of the others. */
#include "obbtree.h"

typedef struct KObbTree {
  const Scene* scene;
  Sphere* spheres;
  Sphere* trial;
  ObbForest forest;
  Counts counts;
} KObbTree;

static void destroy(void* self) {
  KObbTree* tree = self;
  if (tree != NULL) {
    obbForestFree(&tree->forest);
    free(tree->spheres);
    free(tree->trial);
    free(tree);
  }
}

static void* make(const Scene* scene) {
  KObbTree* tree = calloc(1, sizeof *tree);
  if (tree == NULL) {
    return NULL;
  }
  const size_t bytes = (size_t)scene->particleCount * sizeof(Sphere);
  tree->scene = scene;
  tree->spheres = malloc(bytes);
  tree->trial = malloc(bytes);
  if (!obbForestInit(&tree->forest, scene->particleCount) || tree->spheres == NULL || tree->trial == NULL) {
    destroy(tree);
    return NULL;
  }
  memcpy(tree->spheres, scene->spheres, bytes);
  return tree;
}

/* Makes the tree of the particles of one body, as they are in the trial, behind `first` spheres of other trees. */
static int makeTree(KObbTree* tree, const Bodies* bodies, int body, int first) {
  int count = 0;
  for (int s = 0; s < bodies->segmentCount; s++) {
    const Segment* segment = &bodies->segments[s];
    for (int i = segment->first; i < segment->last && segment->body == body; i++) {
      tree->forest.spheres[first + count] = tree->trial[i];
      tree->forest.particles[first + count++] = i;
    }
  }
  return obbTreeMake(&tree->forest, first, count);
}

static int test(void* self, int count, const Turn* turns) {
  KObbTree* tree = self;
  Bodies bodies;
  bodiesMove(tree->scene, tree->spheres, count, turns, &bodies);
  bodiesApply(&bodies, tree->spheres, tree->trial);
  int roots[MOST_TURNS + 1];
  int rootCount = 0;
  int first = 0;
  tree->forest.nodeCount = 0;
  for (int body = 0; body < bodies.bodyCount; body++) {
    if (bodies.sizes[body] > 0) {
      roots[rootCount++] = makeTree(tree, &bodies, body, first);
      first += bodies.sizes[body];
    }
  }
  tree->counts.updates += tree->forest.nodeCount;
  for (int a = 0; a < rootCount; a++) {
    for (int b = 0; b < a; b++) {
      if (obbNodesClash(&tree->forest, tree->scene, roots[a], roots[b], &tree->counts)) {
        return 1;
      }
    }
  }
  return 0;
}

static bool accept(void* self) {
  KObbTree* tree = self;
  Sphere* trial = tree->spheres;
  tree->spheres = tree->trial;
  tree->trial = trial;
  return true;
}

static void reject(void* self) {
  (void)self;
}

static Counts counts(const void* self) {
  return ((const KObbTree*)self)->counts;
}

static const Sphere* spheres(const void* self) {
  return ((const KObbTree*)self)->spheres;
}

const Contestant CONTESTANT(contestantKObbTree) = {
    .name = "kobbtree",
    .idea = "the paper's K-OBBTree: a tree of boxes of each rigid piece, made anew",
    .make = make,
    .destroy = destroy,
    .test = test,
    .accept = accept,
    .reject = reject,
    .counts = counts,
    .spheres = spheres};
