/* All contestants, each compiled for several instruction sets. */
#ifndef ROSTER_H_
#define ROSTER_H_

#include "contestant.h"
#include "kinematics.h"
#include "nearest.h"
#include "pairfinder.h"

/* The contestants of one instruction set, in rosters that end with NULL. */
typedef struct InstructionSet {
  const char* name;
  const char* contestantsName; /* of the set that contestants are compiled for that choose none */
  const Contestant* const* contestants;
  const Contestant* const* precisions; /* contestants that differ in how exact they are */
  const Kinematics* const* kinematics;
  const PairFinder* const* pairFinders;
  const NearestFinder* const* nearestFinders;
} InstructionSet;

/* By name, or with NULL the best that this machine has. NULL if there is no such set, or not here. */
const InstructionSet* instructionSetFind(const char* name);

/* By name, of this length; NULL if there is none. */
const Contestant* contestantFind(const InstructionSet* set, const char* name, size_t length);
const Contestant* precisionFind(const InstructionSet* set, const char* name, size_t length); /* among all contestants */
const Kinematics* kinematicsFind(const InstructionSet* set, const char* name, size_t length);
const PairFinder* pairFinderFind(const InstructionSet* set, const char* name, size_t length);
const NearestFinder* nearestFinderFind(const InstructionSet* set, const char* name, size_t length);

#endif /* ROSTER_H_ */
