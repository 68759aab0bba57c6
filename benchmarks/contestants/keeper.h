/* What contestants that keep the positions of all particles have in common. It is their first member, so that its
 * functions can be theirs. */
#ifndef KEEPER_H_
#define KEEPER_H_

#include <string.h>

#include "bodies.h"

typedef struct Keeper {
  const Scene* scene;
  Sphere* spheres;
  Sphere* trial; /* the same in the trial */
  Counts counts;
} Keeper;

/* A contestant of this size, zeroed but for its keeper. */
static inline void* keeperMake(const Scene* scene, size_t size) {
  Keeper* keeper = allocate(1, size);
  keeper->scene = scene;
  keeper->spheres = allocate(scene->particleCount, sizeof(Sphere));
  keeper->trial = allocate(scene->particleCount, sizeof(Sphere));
  memcpy(keeper->spheres, scene->spheres, (size_t)scene->particleCount * sizeof(Sphere));
  return keeper;
}

static inline void keeperDestroy(void* self) {
  Keeper* keeper = self;
  free(keeper->spheres);
  free(keeper->trial);
  free(keeper);
}

/* Works out the trial: what moves together, and all particles. */
static inline void keeperMove(Keeper* keeper, int count, const Turn* turns, Bodies* bodies) {
  bodiesMove(keeper->scene, keeper->spheres, count, turns, bodies);
  bodiesApply(bodies, keeper->spheres, keeper->trial);
}

static inline void keeperAccept(void* self) {
  Keeper* keeper = self;
  Sphere* trial = keeper->spheres;
  keeper->spheres = keeper->trial;
  keeper->trial = trial;
}

static inline void keeperReject(void* self) {
  (void)self;
}

static inline Counts keeperCounts(const void* self) {
  return ((const Keeper*)self)->counts;
}

static inline const Sphere* keeperSpheres(const void* self) {
  return ((const Keeper*)self)->spheres;
}

#endif /* KEEPER_H_ */
