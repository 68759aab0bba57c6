#define _POSIX_C_SOURCE 200809L
#include "ourtree.h"

#include <string.h>

#include "memory.h"

void ourCheck(ctStatus status) {
  memoryOf(status == ctSuccess ? &status : NULL);
}

static ctChainTree* makeTree(const Scene* scene, int exclusionCount, const Energy* energy, ctEnergy** made, char* error,
                             size_t size) {
  const int particles = scene->particleCount;
  double* positions = allocate(3 * particles, sizeof(double));
  double* radii = allocate(particles, sizeof(double));
  int* parents = allocate(scene->linkCount, sizeof(int));
  uint8_t* joints = allocate(scene->linkCount, 1);
  int(*torsions)[4] = allocate(scene->linkCount, sizeof *torsions);
  for (int i = 0; i < particles; i++) {
    memcpy(positions + 3 * i, scene->spheres[i].x, sizeof scene->spheres[i].x);
    radii[i] = scene->spheres[i].radius;
  }
  for (int link = 0; link < scene->linkCount; link++) {
    parents[link] = scene->linkParents[link] < 0 ? CT_NULL : scene->linkParents[link];
    joints[link] = scene->linkParents[link] < 0 ? ctFreeJoint : ctTorsionJoint;
  }
  for (int t = 0; t < scene->torsionCount; t++) {
    for (int k = 0; k < 4; k++) {
      torsions[scene->torsions[t].link][k] = scene->torsions[t].axis[k / 2];
    }
  }
  const ctDefinition definition = {.particleCount = particles,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = scene->particleLinks,
                                   .linkCount = scene->linkCount,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions,
                                   .exclusionCount = exclusionCount,
                                   .exclusions = (const int(*)[2])scene->exclusions};
  ctChainTree* tree = NULL;
  ourCheck(ctCreate(&definition, &tree, error, size));
  if (energy != NULL) {
    const ctEnergyDefinition ofEnergy = {.scene = &definition,
                                         .nonbonded = &energy->nonbonded,
                                         .termSetCount = energy->setCount,
                                         .termSets = energy->sets};
    if (ctCreateEnergy(tree, &ofEnergy, made, error, size) != ctSuccess) {
      ctDestroy(tree);
      tree = NULL;
    }
  }
  free(positions);
  free(radii);
  free(parents);
  free(joints);
  free(torsions);
  return tree;
}

ctChainTree* ourTreeOf(const Scene* scene, int exclusionCount) {
  return makeTree(scene, exclusionCount, NULL, NULL, NULL, 0);
}

ctChainTree* ourTreeWith(const Scene* scene, const Energy* energy, const char* instructionSet, ctEnergy** made,
                         char* error, size_t size) {
  static const char* const variable = "CHAINTREE_SIMD";
  if (instructionSet == NULL) {
    return makeTree(scene, scene->exclusionCount, energy, made, error, size);
  }
  const char* before = getenv(variable);
  char* kept = before == NULL ? NULL : memoryOf(strdup(before));
  setenv(variable, instructionSet, 1);
  ctChainTree* tree = makeTree(scene, scene->exclusionCount, energy, made, error, size);
  if (kept == NULL) {
    unsetenv(variable);
  } else {
    setenv(variable, kept, 1);
  }
  free(kept);
  return tree;
}
