/* Contestants on trials that stop where particles come to touch: just before it, or just after. What is a clash is what
 * long double says; who says otherwise misses a clash or invents one. */
#ifndef TOUCHRACE_H_
#define TOUCHRACE_H_

#include "contacts.h"
#include "measure.h"

enum { MOST_TOUCH_LANES = 32 };

/* Overlaps and gaps, nm, that trials stop at, evenly by their logarithms; nobody is asked within the least one. */
#define LEAST_TOUCH 1e-9
#define MOST_TOUCH 1e-3

typedef struct TouchRace {
  const Scene* scene;
  uint64_t seed;
  int trialCount;
  double seconds; /* of processor time, with the search for contacts; the race ends with the contact after that */
  int laneCount;
  const Contestant* contestants[MOST_TOUCH_LANES];
  const Contestant* judge; /* finds contacts, and states to look for them in */
} TouchRace;

typedef struct TouchResult {
  const char* instructionSet; /* NULL if the contestant does not choose it */
  Quartiles microseconds;     /* of a trial that is taken back */
  int clashes;                /* trials with overlap, */
  int missed;                 /* and those of them that it calls free */
  double largestMissed;       /* overlap, nm */
  int gaps;                   /* trials with a gap, */
  int invented;               /* and those of them that it calls a clash */
  double largestInvented;     /* gap, nm */
} TouchResult;

/* Fills results[laneCount]. False if that fails; then `error`, of `size` bytes, says why. */
bool touchRaceRun(const TouchRace* race, TouchResult* results, char* error, size_t size);

#endif /* TOUCHRACE_H_ */
