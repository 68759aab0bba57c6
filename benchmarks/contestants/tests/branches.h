/* A tree of links with branches, of several particles each, in any order: what no generator of chains makes. */
#ifndef BRANCHES_H_
#define BRANCHES_H_

#include <string.h>

#include "check.h"
#include "random.h"
#include "scene.h"

enum { MOST_BRANCH_LINKS = 60, MOST_LINK_PARTICLES = 3, MOST_BRANCH_PARTICLES = 3 * MOST_BRANCH_LINKS };

static inline bool isTooNear(const Scene* scene, int i, int j) {
  double squared = 0;
  for (int k = 0; k < 3; k++) {
    const double d = scene->spheres[i].x[k] - scene->spheres[j].x[k];
    squared += d * d;
  }
  const double sum = scene->spheres[i].radius + scene->spheres[j].radius;
  return squared < sum * sum;
}

/* Pairs that overlap are excluded, so that the scene begins without a clash. */
static inline void excludeOverlaps(SceneSource* source) {
  const Scene all = {.spheres = source->spheres};
  source->exclusionCount = 0;
  for (int i = 0; i < source->particleCount; i++) {
    for (int j = i + 1; j < source->particleCount; j++) {
      if (isTooNear(&all, i, j)) {
        source->exclusions[source->exclusionCount][0] = j;
        source->exclusions[source->exclusionCount++][1] = i;
      }
    }
  }
}

/* Spheres of radius 0.3 to 1, some two apart along a bond. Link k hangs on one of the `reach` links before it; links
 * and particles are numbered at random. */
static inline Scene* makeBranches(int linkCount, int reach, uint64_t seed) {
  Random random = {seed};
  int linkNames[MOST_BRANCH_LINKS];
  int particleNames[MOST_BRANCH_PARTICLES];
  int firstParticles[MOST_BRANCH_LINKS + 1] = {0};
  for (int k = 0; k < linkCount; k++) {
    firstParticles[k + 1] = firstParticles[k] + 1 + randomInt(&random, MOST_LINK_PARTICLES);
  }
  const int particleCount = firstParticles[linkCount];
  for (int i = 0; i < linkCount; i++) {
    const int other = randomInt(&random, i + 1);
    linkNames[i] = linkNames[other];
    linkNames[other] = i;
  }
  for (int i = 0; i < particleCount; i++) {
    const int other = randomInt(&random, i + 1);
    particleNames[i] = particleNames[other];
    particleNames[other] = i;
  }
  SceneSource source;
  if (!sceneSourceInit(&source, particleCount, linkCount, particleCount * particleCount)) {
    exit(1);
  }
  for (int k = 0; k < linkCount; k++) {
    const int parent = k == 0 ? -1 : k - 1 - randomInt(&random, k < reach ? k : reach);
    const int near = k == 0 ? -1 : firstParticles[parent + 1] - 1;
    SourceLink* link = &source.links[linkNames[k]];
    *link = (SourceLink){.parent = -1, .axis = {-1, -1}, .sideChain = randomInt(&random, 4) == 0};
    if (k > 0) {
      link->parent = linkNames[parent];
      link->axis[0] = particleNames[near];
      link->axis[1] = particleNames[firstParticles[k]];
    }
    for (int i = firstParticles[k]; i < firstParticles[k + 1]; i++) {
      const int before = i > firstParticles[k] ? i - 1 : near;
      Sphere* sphere = &source.spheres[particleNames[i]];
      for (int c = 0; c < 3; c++) {
        const double from = before < 0 ? 0 : source.spheres[particleNames[before]].x[c];
        sphere->x[c] = from + 1.2 * randomGaussian(&random) + (c == 0 ? 0.5 : 0);
      }
      sphere->radius = 0.3 + 0.7 * randomReal(&random);
      source.particleLinks[particleNames[i]] = linkNames[k];
    }
  }
  excludeOverlaps(&source);
  char error[256] = "";
  Scene* scene = sceneMake(&source, error, sizeof error);
  if (scene == NULL) {
    printf("sceneMake: %s\n", error);
    exit(1);
  }
  sceneSourceFree(&source);
  return scene;
}

#endif /* BRANCHES_H_ */
