/* Finders of the least distance between a chain and obstacles, in turns. */
#ifndef NEARESTRACE_H_
#define NEARESTRACE_H_

#include "measure.h"
#include "nearest.h"

enum { MOST_NEAREST_FINDERS = 8 };

typedef struct NearestRace {
  const Scene* scene;
  int obstacleCount; /* at random in a cube beside the chain */
  uint64_t seed;
  int repeats; /* between them a torsion turns */
  int finderCount;
  const NearestFinder* finders[MOST_NEAREST_FINDERS];
} NearestRace;

/* Fills microseconds[finderCount], per question. False if that fails, or if finders disagree by more than rounding to
 * single precision explains; then `error`, of `size` bytes, says why. */
bool nearestRaceRun(const NearestRace* race, Quartiles* microseconds, char* error, size_t size);

#endif /* NEARESTRACE_H_ */
