#include "roster.h"

#include <string.h>

extern const InstructionSet instructionSetPortable;

static bool always(void) {
  return true;
}

#ifdef ROSTER_X86
extern const InstructionSet instructionSetAvx2;
extern const InstructionSet instructionSetAvx512;

static bool hasAvx2(void) {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");
}

static bool hasAvx512(void) {
  return hasAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#endif

typedef struct Candidate {
  const InstructionSet* set;
  bool (*isHere)(void); /* whether this machine has it */
} Candidate;

/* The best first. */
static const Candidate candidates[] = {
#ifdef ROSTER_X86
    {.set = &instructionSetAvx512, .isHere = hasAvx512},
    {.set = &instructionSetAvx2, .isHere = hasAvx2},
#endif
    {.set = &instructionSetPortable, .isHere = always}};

const InstructionSet* instructionSetFind(const char* name) {
  for (size_t i = 0; i < sizeof candidates / sizeof candidates[0]; i++) {
    const Candidate* candidate = &candidates[i];
    if ((name == NULL || strcmp(name, candidate->set->name) == 0) && candidate->isHere()) {
      return candidate->set;
    }
  }
  return NULL;
}

const Contestant* contestantFind(const InstructionSet* set, const char* name) {
  const Contestant* const* c = set->contestants;
  while (*c != NULL && strcmp((*c)->name, name) != 0) {
    c++;
  }
  return *c;
}

const PairFinder* pairFinderFind(const InstructionSet* set, const char* name) {
  const PairFinder* const* f = set->pairFinders;
  while (*f != NULL && strcmp((*f)->name, name) != 0) {
    f++;
  }
  return *f;
}
