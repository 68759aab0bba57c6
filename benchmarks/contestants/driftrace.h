/* What becomes of positions after many turns, by several ways of keeping them: how far they are from where long double
 * sees them after the same turns, and, where a way keeps the angles that its torsions have turned, after those angles.
 */
#ifndef DRIFTRACE_H_
#define DRIFTRACE_H_

#include "errors.h"
#include "kinematics.h"
#include "measure.h"
#include "moves.h"

enum { MOST_DRIFT_LANES = 32, MOST_STATIONS = 10, FIRST_STATION = 1000 };

/* Every path is looked at after 1,000 turns, 10,000 and so on, up to `turnCount`. It goes on to the next station as
 * long as that, by the time it has taken so far, is within its share of the time: it and its fellows share alike. */
typedef struct DriftRace {
  const Scene* scene; /* a chain without branches */
  MoveRule rule;      /* of one torsion */
  uint64_t seed;
  int turnCount;
  double seconds; /* of processor time, for all together */
  int laneCount;
  const Kinematics* paths[MOST_DRIFT_LANES];
} DriftRace;

typedef struct Station {
  int turns;
  double size;     /* of the chain, nm */
  Errors ofTurns;  /* from where exact turns lead */
  Errors ofAngles; /* from where the path's own angles put particles exactly */
  uint64_t bits;   /* a hash of all coordinates */
} Station;

typedef struct DriftResult {
  const char* instructionSet; /* NULL if the path does not choose it */
  Quartiles microseconds;     /* of a turn, with what a search for clashes would need */
  bool keepsAngles;
  int stationCount;
  Station stations[MOST_STATIONS];
} DriftResult;

/* Fills results[laneCount]. False if that fails; then `error`, of `size` bytes, says why. */
bool driftRaceRun(const DriftRace* race, DriftResult* results, char* error, size_t size);

#endif /* DRIFTRACE_H_ */
