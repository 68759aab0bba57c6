/* Contestants on the same trials, in turns, so that what disturbs the machine disturbs all of them. */
#ifndef RACE_H_
#define RACE_H_

#include <stdio.h>

#include "measure.h"
#include "moves.h"

enum { MOST_LANES = 32 };

typedef struct Race {
  const Scene* scene;
  MoveRule rule;
  uint64_t seed;
  int trialCount;
  int blockSize; /* trials of one contestant before the next has its turn */
  int laneCount;
  const Contestant* contestants[MOST_LANES];
  const Contestant* judge; /* keeps positions; asked where trials depend on them */
  FILE* record;            /* takes the scene and all trials; may be NULL */
} Race;

/* Of one contestant. The first block is not timed, but its trials count where tests and accepted trials are counted. */
typedef struct RaceResult {
  const char* instructionSet; /* NULL if the contestant does not choose it */
  double microseconds;        /* per trial, the median over blocks */
  double accepted;            /* share of trials */
  double volumeTests;         /* per trial */
  double particleTests;
} RaceResult;

/* Fills results[laneCount]. False if that fails, or if contestants disagree about a trial; then `error`, of `size`
 * bytes, says why. */
bool raceRun(const Race* race, RaceResult* results, char* error, size_t size);

/* A race on file, for whoever wants to run the same trials: lines of JSON.
 *
 *   {"particles": [[x, y, z, radius], ...], "names": [number in the source of the scene, ...],
 *    "torsions": [[near, far, first, last], ...], "exclusions": [[i, j], ...]}
 *   {"turns": [[torsion, angle in rad], ...], "clash": false}             one for each trial, from the first on
 *
 * A torsion turns the particles first ... last - 1 about the line from particle near to particle far. */
void recordScene(FILE* file, const Scene* scene);
void recordTrial(FILE* file, int count, const Turn* turns, bool clash);

#endif /* RACE_H_ */
