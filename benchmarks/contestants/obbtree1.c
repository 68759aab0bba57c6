/* 1-OBBTree (section 5): after each change, one tree of boxes of all spheres, tested against itself. */
#include "obbtree.h"

typedef struct ObbTree1 {
  const Scene* scene;
  Sphere* spheres;
  Sphere* trial;
  ObbForest forest;
  Counts counts;
} ObbTree1;

static void destroy(void* self) {
  ObbTree1* tree = self;
  if (tree != NULL) {
    obbForestFree(&tree->forest);
    free(tree->spheres);
    free(tree->trial);
    free(tree);
  }
}

static void* make(const Scene* scene) {
  ObbTree1* tree = calloc(1, sizeof *tree);
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

static bool clashesWithItself(ObbTree1* tree, int node) {
  const int second = tree->forest.nodes[node].second;
  if (second == 0) {
    return rangesClash(&tree->forest, tree->scene, &tree->forest.nodes[node], &tree->forest.nodes[node], &tree->counts);
  }
  return clashesWithItself(tree, node + 1) || clashesWithItself(tree, second) ||
         obbNodesClash(&tree->forest, tree->scene, node + 1, second, &tree->counts);
}

static int anyClash(ObbTree1* tree, const Sphere* spheres) {
  const int particles = tree->scene->particleCount;
  memcpy(tree->forest.spheres, spheres, (size_t)particles * sizeof(Sphere));
  for (int i = 0; i < particles; i++) {
    tree->forest.particles[i] = i;
  }
  tree->forest.nodeCount = 0;
  const int root = obbTreeMake(&tree->forest, 0, particles);
  tree->counts.updates += tree->forest.nodeCount;
  return clashesWithItself(tree, root);
}

static int testAll(void* self) {
  ObbTree1* tree = self;
  return anyClash(tree, tree->spheres);
}

static int test(void* self, int count, const Turn* turns) {
  ObbTree1* tree = self;
  Bodies bodies;
  bodiesMove(tree->scene, tree->spheres, count, turns, &bodies);
  bodiesApply(&bodies, tree->spheres, tree->trial);
  return anyClash(tree, tree->trial);
}

static bool accept(void* self) {
  ObbTree1* tree = self;
  Sphere* trial = tree->spheres;
  tree->spheres = tree->trial;
  tree->trial = trial;
  return true;
}

static void reject(void* self) {
  (void)self;
}

static Counts counts(const void* self) {
  return ((const ObbTree1*)self)->counts;
}

static const Sphere* spheres(const void* self) {
  return ((const ObbTree1*)self)->spheres;
}

const Contestant CONTESTANT(contestantObbTree1) = {.name = "obbtree1",
                                                   .idea = "the paper's 1-OBBTree: one tree of boxes, made anew",
                                                   .make = make,
                                                   .destroy = destroy,
                                                   .test = test,
                                                   .accept = accept,
                                                   .reject = reject,
                                                   .testAll = testAll,
                                                   .counts = counts,
                                                   .spheres = spheres};
