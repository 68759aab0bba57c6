/* The energy of trials, by what they change: paths of the engine's library of energies on the same trials, in turns. */
#ifndef ENERGYRACE_H_
#define ENERGYRACE_H_

#include <stdio.h>

#include "energyfile.h"
#include "measure.h"
#include "moves.h"

enum { MOST_ENERGY_LANES = 8 };

typedef struct EnergyContestant {
  const char* name;
  const char* idea;
  const char* instructionSet; /* NULL: the best that there is */
  bool stops;                 /* at the part that refuses a trial; else it computes all parts of each */
} EnergyContestant;

/* In a roster that ends with one without a name. */
extern const EnergyContestant energyContestants[];

/* By name; NULL if there is none. */
const EnergyContestant* energyContestantFind(const char* name);

typedef struct EnergyRace {
  const Scene* scene;
  const Energy* energy;
  MoveRule rule;
  uint64_t seed;
  double temperature; /* K */
  int trialCount;
  int blockSize; /* trials of one contestant before the next has its turn */
  int laneCount;
  const EnergyContestant* contestants[MOST_ENERGY_LANES];
  FILE* record; /* takes the scene's names and the first trials without a clash; may be NULL */
  int recordCount;
} EnergyRace;

/* Of one contestant. Trials are decided part by part, as the integrator decides them: each part refuses by a random
 * number of its own. So those of the trajectory are the same for all. The first block counts nowhere.
 *
 * Times are those of trials without a clash: of ctComputeEnergyChange, and, if a trial is accepted, of
 * ctAcceptEnergyChange. Neither the test of hard spheres nor what ctAccept does counts. */
typedef struct EnergyResult {
  const char* instructionSet;
  int free;                      /* trials without a clash */
  int accepted;                  /* of these */
  double microseconds;           /* of all that was computed of a trial, the median over trials */
  double mean;                   /* microseconds a trial: the median over blocks of their means */
  double parts[CT_ENERGY_PARTS]; /* microseconds: medians over the trials that came to the part */
  int reached[CT_ENERGY_PARTS];  /* trials that came to this part */
  int refused[CT_ENERGY_PARTS];  /* of these */
  double energy;                 /* kJ/mol, of the last state, as it was added up */
  double drift;                  /* from that to the energy computed again */
} EnergyResult;

/* Fills results[laneCount]. False if that fails, or if contestants differ in a bit; then `error`, of `size` bytes, says
 * why. */
bool energyRaceRun(const EnergyRace* race, EnergyResult* results, char* error, size_t size);

#endif /* ENERGYRACE_H_ */
