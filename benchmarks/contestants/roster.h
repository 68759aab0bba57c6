/* All contestants, each compiled for several instruction sets. */
#ifndef ROSTER_H_
#define ROSTER_H_

#include "contestant.h"
#include "pairfinder.h"

/* The contestants of one instruction set, in rosters that end with NULL. */
typedef struct InstructionSet {
  const char* name;
  const Contestant* const* contestants;
  const PairFinder* const* pairFinders;
} InstructionSet;

/* By name, or with NULL the best that this machine has. NULL if there is no such set, or not here. */
const InstructionSet* instructionSetFind(const char* name);

/* By name; NULL if there is none. */
const Contestant* contestantFind(const InstructionSet* set, const char* name);
const PairFinder* pairFinderFind(const InstructionSet* set, const char* name);

#endif /* ROSTER_H_ */
