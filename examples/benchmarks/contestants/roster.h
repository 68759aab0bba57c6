/* All contestants, each compiled for several instruction sets. */
#ifndef ROSTER_H_
#define ROSTER_H_

#include "contestant.h"

/* The contestants of one instruction set, ending with NULL. */
typedef const Contestant* const Roster[];

extern Roster rosterPortable;
extern Roster rosterAvx2;

typedef struct InstructionSet {
  const char* name;
  bool (*isHere)(void); /* whether this machine has it */
  const Contestant* const* roster;
} InstructionSet;

/* By name, or with NULL the best that this machine has. NULL if there is no such set, or not here. */
const InstructionSet* instructionSetFind(const char* name);

/* By name; NULL if there is none. */
const Contestant* rosterFind(const InstructionSet* set, const char* name, size_t nameLength);

#endif /* ROSTER_H_ */
