/* The instruction sets that this machine has. */
#ifndef SETS_H_
#define SETS_H_

#include "roster.h"

enum { MOST_SETS = 3 };

/* Returns how many there are. */
static inline int setsHere(const InstructionSet** sets) {
  static const char* const names[MOST_SETS] = {"avx512", "avx2", "portable"};
  int count = 0;
  for (int i = 0; i < MOST_SETS; i++) {
    const InstructionSet* set = instructionSetFind(names[i]);
    if (set != NULL) {
      sets[count++] = set;
    }
  }
  return count;
}

#endif /* SETS_H_ */
