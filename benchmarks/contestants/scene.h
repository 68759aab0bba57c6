/* What the contestants move: spheres in rigid links that hang on each other by torsions.
 *
 * The particles stand in the order of a walk over the links, depth-first, the heaviest branch last. So what a torsion
 * moves is one interval of them, and for a chain that is all from some particle on. */
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

/* A link in the source of a scene. */
typedef struct SourceLink {
  int parent;  /* -1: at rest */
  int axis[2]; /* of the torsion that turns it: a particle of the parent, a particle of the link; -1: none */
  bool sideChain;
} SourceLink;

/* A scene as it comes from a generator or a file, in any order. */
typedef struct SceneSource {
  int particleCount;
  Sphere* spheres;
  int* particleLinks;
  int linkCount;
  SourceLink* links;
  int exclusionCount;
  int (*exclusions)[2];
} SceneSource;

/* Zeroed arrays for a source; false if there is no memory. */
bool sceneSourceInit(SceneSource* source, int particleCount, int linkCount, int exclusionCount);
void sceneSourceFree(SceneSource* source);

/* Checks and orders a source. NULL if that fails; then `error`, of `size` bytes, says why. */
Scene* sceneMake(const SceneSource* source, char* error, size_t size);
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
