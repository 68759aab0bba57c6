/* Finders of pairs on the same positions, in turns. */
#ifndef PAIRRACE_H_
#define PAIRRACE_H_

#include "measure.h"
#include "pairfinder.h"

enum { MOST_PAIR_FINDERS = 8 };

typedef struct PairRace {
  const Scene* scene;
  double cutoff;
  uint64_t seed;
  int repeats; /* each time the particles of the scene are put a little beside where they were */
  int finderCount;
  const PairFinder* finders[MOST_PAIR_FINDERS];
} PairRace;

typedef struct PairResult {
  double microseconds; /* median over lists */
  int pairCount;       /* of the last */
} PairResult;

/* Fills results[finderCount]. False if finders disagree by more than rounding to single precision explains; then
 * `error`, of `size` bytes, says which. */
bool pairRaceRun(const PairRace* race, PairResult* results, char* error, size_t size);

#endif /* PAIRRACE_H_ */
