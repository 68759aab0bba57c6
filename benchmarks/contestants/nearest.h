/* What the driver sees of a contestant that finds how near a chain comes to obstacles. */
#ifndef NEAREST_H_
#define NEAREST_H_

#include "contestant.h"

typedef struct Nearest {
  double distance; /* centre to centre */
  int particle;    /* of the chain */
  int obstacle;
} Nearest;

typedef struct NearestFinder {
  const char* name;
  const char* idea; /* one line about it */

  /* With 3 * obstacleCount coordinates of obstacles. NULL if there is no memory. The scene must outlive it. */
  void* (*make)(const Scene* scene, int obstacleCount, const double* obstacles);
  void (*destroy)(void* self);

  /* Turns a torsion; what it does not move stays at rest, and clashes do not matter. False if there is no memory. */
  bool (*turn)(void* self, Turn turn);

  /* False if there is no memory. */
  bool (*find)(void* self, Nearest* nearest);
} NearestFinder;

#endif /* NEAREST_H_ */
