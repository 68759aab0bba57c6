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
  int blockSize;       /* trials of one contestant before the next has its turn */
  double seconds;      /* the race ends with the block in which its contestants have taken that long together, */
                       /* and is incomplete unless that is the last one */
  bool readsPositions; /* all positions are worked out after each trial taken over, as part of its time */
  int laneCount;
  const Contestant* contestants[MOST_LANES];
  const Contestant* judge; /* keeps positions; asked where trials depend on them */
  FILE* record;            /* takes the scene and all trials; may be NULL */
} Race;

/* Of one contestant. The first block is not timed, but its trials count where tests and accepted trials are counted. */
typedef struct RaceResult {
  const char* instructionSet; /* NULL if the contestant does not choose it */
  int trials;                 /* that were timed: fewer than trialCount if the race is incomplete */
  double gyration[3];         /* radius of gyration, in the scene's unit: of the scene as it is, and before and after */
                              /* the trials that were timed */
  Quartiles microseconds;     /* per trial */
  double accepted;            /* share of trials */
  double volumeTests;         /* per trial, as the others */
  double particleTests;
  double updates;
  int64_t bytes; /* that destroying the contestant has freed after the race; -1: not known */
} RaceResult;

/* Fills results[laneCount]. False if that fails, or if contestants disagree about a trial; then `error`, of `size`
 * bytes, says why. */
bool raceRun(const Race* race, RaceResult* results, char* error, size_t size);

#endif /* RACE_H_ */
