#define _POSIX_C_SOURCE 200809L
#include "ourtree.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Arrays {
  double* positions;
  double* radii;
  int* particleLinks;
  int* parents;
  uint8_t* joints;
  int (*torsions)[4];
} Arrays;

static void arraysFree(Arrays* arrays) {
  free(arrays->positions);
  free(arrays->radii);
  free(arrays->particleLinks);
  free(arrays->parents);
  free(arrays->joints);
  free(arrays->torsions);
}

static bool arraysInit(Arrays* arrays, size_t particles, size_t links) {
  arrays->positions = calloc(3 * particles + 1, sizeof(double));
  arrays->radii = calloc(particles + 1, sizeof(double));
  arrays->particleLinks = calloc(particles + 1, sizeof(int));
  arrays->parents = calloc(links, sizeof(int));
  arrays->joints = calloc(links, 1);
  arrays->torsions = calloc(links, sizeof *arrays->torsions);
  return arrays->positions != NULL && arrays->radii != NULL && arrays->particleLinks != NULL &&
         arrays->parents != NULL && arrays->joints != NULL && arrays->torsions != NULL;
}

static void fillScene(Arrays* arrays, const Scene* scene) {
  for (int i = 0; i < scene->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      arrays->positions[3 * i + k] = scene->spheres[i].x[k];
    }
    arrays->radii[i] = scene->spheres[i].radius;
    arrays->particleLinks[i] = scene->particleLinks[i];
  }
  for (int link = 0; link < scene->linkCount; link++) {
    arrays->parents[link] = scene->linkParents[link] < 0 ? CT_NULL : scene->linkParents[link];
    arrays->joints[link] = scene->linkParents[link] < 0 ? ctFreeJoint : ctTorsionJoint;
  }
  for (int t = 0; t < scene->torsionCount; t++) {
    const Torsion* torsion = &scene->torsions[t];
    for (int k = 0; k < 4; k++) {
      arrays->torsions[torsion->link][k] = torsion->axis[k / 2];
    }
  }
}

static void fillObstacles(Arrays* arrays, const Scene* scene, int obstacleCount, const double* obstacles) {
  const double radius = sceneLargestRadius(scene);
  for (int i = 0; i < obstacleCount; i++) {
    const int particle = scene->particleCount + i;
    for (int k = 0; k < 3; k++) {
      arrays->positions[3 * particle + k] = obstacles[3 * i + k];
    }
    arrays->radii[particle] = radius;
    arrays->particleLinks[particle] = scene->linkCount;
  }
  arrays->parents[scene->linkCount] = CT_NULL;
  arrays->joints[scene->linkCount] = ctFixedJoint;
}

/* What the functions below make. */
typedef struct Wanted {
  int exclusionCount;
  int obstacleCount;
  const double* obstacles;
  const Energy* energy; /* NULL: none */
  ctEnergy** made;
  char* error; /* of `size` bytes, or NULL */
  size_t size;
} Wanted;

static void makeEnergy(ctChainTree** tree, const ctDefinition* definition, const Wanted* wanted) {
  const ctEnergyDefinition energy = {.scene = definition,
                                     .nonbonded = &wanted->energy->nonbonded,
                                     .termSetCount = wanted->energy->setCount,
                                     .termSets = wanted->energy->sets};
  if (ctCreateEnergy(*tree, &energy, wanted->made, wanted->error, wanted->size) != ctSuccess) {
    ctDestroy(*tree);
    *tree = NULL;
  }
}

static ctChainTree* makeTree(const Scene* scene, const Wanted* wanted) {
  Arrays arrays = {0};
  ctChainTree* tree = NULL;
  const int particles = scene->particleCount + wanted->obstacleCount;
  const int links = scene->linkCount + (wanted->obstacleCount > 0);
  if (arraysInit(&arrays, (size_t)particles, (size_t)links + 1)) {
    fillScene(&arrays, scene);
    fillObstacles(&arrays, scene, wanted->obstacleCount, wanted->obstacles);
    const ctDefinition definition = {.particleCount = particles,
                                     .positions = arrays.positions,
                                     .radii = arrays.radii,
                                     .particleLinks = arrays.particleLinks,
                                     .linkCount = links,
                                     .linkParents = arrays.parents,
                                     .linkJoints = arrays.joints,
                                     .linkTorsions = (const int(*)[4])arrays.torsions,
                                     .exclusionCount = wanted->exclusionCount,
                                     .exclusions = (const int(*)[2])scene->exclusions};
    ctCreate(&definition, &tree, wanted->error, wanted->size);
    if (tree != NULL && wanted->energy != NULL) {
      makeEnergy(&tree, &definition, wanted);
    }
  }
  arraysFree(&arrays);
  return tree;
}

ctChainTree* ourTreeOf(const Scene* scene, int exclusionCount, int obstacleCount, const double* obstacles) {
  const Wanted wanted = {.exclusionCount = exclusionCount, .obstacleCount = obstacleCount, .obstacles = obstacles};
  return makeTree(scene, &wanted);
}

static ctChainTree* makeTreeWith(const Scene* scene, const char* variable, const char* value, const Wanted* wanted) {
  const char* before = getenv(variable);
  char* kept = before == NULL ? NULL : strdup(before);
  ctChainTree* tree = NULL;
  if ((before == NULL || kept != NULL) && setenv(variable, value, 1) == 0) {
    tree = makeTree(scene, wanted);
    if (kept == NULL) {
      unsetenv(variable);
    } else if (setenv(variable, kept, 1) != 0) {
      if (wanted->made != NULL) {
        ctDestroyEnergy(*wanted->made);
        *wanted->made = NULL;
      }
      ctDestroy(tree);
      tree = NULL;
    }
  }
  free(kept);
  return tree;
}

ctChainTree* ourTreeWith(const Scene* scene, const char* variable, const char* value) {
  const Wanted wanted = {.exclusionCount = scene->exclusionCount};
  return makeTreeWith(scene, variable, value, &wanted);
}

ctChainTree* ourTreeWithEnergy(const Scene* scene, const Energy* energy, const char* instructionSet, ctEnergy** made,
                               char* error, size_t size) {
  const Wanted wanted = {
      .exclusionCount = scene->exclusionCount, .energy = energy, .made = made, .error = error, .size = size};
  *made = NULL;
  snprintf(error, size, "not enough memory");
  return instructionSet == NULL ? makeTree(scene, &wanted)
                                : makeTreeWith(scene, "CHAINTREE_SIMD", instructionSet, &wanted);
}
