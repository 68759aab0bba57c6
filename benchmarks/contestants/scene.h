/* What the contestants move: spheres in rigid links that hang on each other by torsions.
 *
 * The particles stand in the order of a walk over the links, depth-first. So what a torsion moves is one interval of
 * them, and for a chain that is all from some particle on. */
#ifndef SCENE_H_
#define SCENE_H_

#include <stdbool.h>
#include <stddef.h>

/* A position and a radius; the size of a vector register. */
typedef struct Sphere {
  double x[3];
  double radius;
} Sphere;

/* A turn about the line from particle axis[0] to axis[1] of the particles first ... last - 1, axis[1] among them. */
typedef struct Torsion {
  int axis[2];
  int first;
  int last;
  int link;       /* that it turns, with all that hangs on it */
  bool sideChain; /* it belongs to no backbone */
} Torsion;

typedef struct Scene {
  int particleCount;
  Sphere* spheres;
  int* particleLinks;
  int* particleNames; /* the number of each particle in the source of the scene */

  int linkCount;
  int* linkParents; /* -1: at rest */

  int torsionCount; /* sorted by `first` */
  Torsion* torsions;

  int exclusionCount;
  int (*exclusions)[2];
  int* exclusionBegin; /* particleCount + 1: particle i is excluded from excluded[exclusionBegin[i]] ... */
  int* excluded;
} Scene;

/* With room for these numbers of particles, links and exclusions, and without torsions. */
Scene* sceneAllocate(int particleCount, int linkCount, int exclusionCount);

/* Fills what exclusions are looked up by. */
void sceneIndexExclusions(Scene* scene);

/* A scene from a text file: words and numbers with white space between them, indices from 0.
 *
 *   chaintree-scene 2
 *   particles N links L exclusions E
 *   x y z radius link name         N times: the particle, its link, and its number in the source
 *   parent near far first last side  L times: of each link its parent, the particle of the parent and its own particle
 *                                  on the axis that turns it, the interval that it turns, and 1 if it belongs to a side
 *                                  chain, else 0; of a link at rest, parent is -1, and the others do not matter
 *   i j                            E times: pairs that never clash
 *
 * NULL if that fails; then `error`, of `size` bytes, says why. */
Scene* sceneRead(const char* path, char* error, size_t size);

void sceneFree(Scene* scene);

/* Whether two particles never clash. */
static inline bool sceneExcludes(const Scene* scene, int i, int j) {
  for (int k = scene->exclusionBegin[i]; k < scene->exclusionBegin[i + 1]; k++) {
    if (scene->excluded[k] == j) {
      return true;
    }
  }
  return false;
}

double sceneLargestRadius(const Scene* scene);

#endif /* SCENE_H_ */
