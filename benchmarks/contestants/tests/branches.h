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
static inline void excludeOverlaps(Scene* scene) {
  scene->exclusionCount = 0;
  for (int i = 0; i < scene->particleCount; i++) {
    for (int j = i + 1; j < scene->particleCount; j++) {
      if (isTooNear(scene, i, j)) {
        scene->exclusions[scene->exclusionCount][0] = j;
        scene->exclusions[scene->exclusionCount++][1] = i;
      }
    }
  }
  sceneIndexExclusions(scene);
}

/* Spheres of radius 0.3 to 1, some two apart along a bond. Each link hangs on the one before it or on one that this
 * hangs on, up to `reach` - 1 links on. */
static inline Scene* makeBranches(int linkCount, int reach, uint64_t seed) {
  Random random = {seed};
  int firsts[MOST_BRANCH_LINKS + 1] = {0};
  for (int k = 0; k < linkCount; k++) {
    firsts[k + 1] = firsts[k] + 1 + randomInt(&random, MOST_LINK_PARTICLES);
  }
  const int particleCount = firsts[linkCount];
  Scene* scene = sceneAllocate(particleCount, linkCount, particleCount * particleCount);
  for (int k = 0; k < linkCount; k++) {
    int parent = k - 1;
    for (int up = randomInt(&random, reach); up > 0 && parent > 0; up--) {
      parent = scene->linkParents[parent];
    }
    const int near = k == 0 ? -1 : firsts[parent + 1] - 1;
    scene->linkParents[k] = parent;
    for (int i = firsts[k]; i < firsts[k + 1]; i++) {
      const int before = i > firsts[k] ? i - 1 : near;
      for (int c = 0; c < 3; c++) {
        const double from = before < 0 ? 0 : scene->spheres[before].x[c];
        scene->spheres[i].x[c] = from + 1.2 * randomGaussian(&random) + (c == 0 ? 0.5 : 0);
      }
      scene->spheres[i].radius = 0.3 + 0.7 * randomReal(&random);
      scene->particleLinks[i] = k;
      scene->particleNames[i] = i;
    }
    if (k > 0) {
      scene->torsions[scene->torsionCount++] =
          (Torsion){.axis = {near, firsts[k]}, .first = firsts[k], .link = k, .sideChain = randomInt(&random, 4) == 0};
    }
    /* The interval of each link that this one hangs on ends here, as far as is known. */
    for (int link = k; link > 0; link = scene->linkParents[link]) {
      scene->torsions[link - 1].last = firsts[k + 1];
    }
  }
  excludeOverlaps(scene);
  return scene;
}

#endif /* BRANCHES_H_ */
