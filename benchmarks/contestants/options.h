/* The command line of the driver. */
#ifndef OPTIONS_H_
#define OPTIONS_H_

#include "moves.h"
#include "roster.h"

typedef enum Measure { measureTrials, measurePairs, measureEnergy } Measure;

typedef struct Options {
  Measure measure;
  const char* chain;
  int count; /* of spheres */
  const char* moves;
  MoveRule rule;
  int seed;
  int trialCount;
  int blockSize;
  double cutoff;
  const char* contestants; /* names with commas between them */
  const InstructionSet* set;
  const char* record; /* a file, or NULL */
  int recordCount;    /* trials with their energies that are written there */
  const char* energy; /* a file, or NULL */
  double temperature; /* K */
  bool help;
  bool about;
} Options;

extern const char* const optionsUsage;

/* False if the command line is wrong; then `error`, of `size` bytes, says what is. */
bool optionsParse(int argc, char** argv, Options* options, char* error, size_t size);

#endif /* OPTIONS_H_ */
