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

static bool isCalled(const char* itsName, const char* name, size_t length) {
  return strlen(itsName) == length && memcmp(itsName, name, length) == 0;
}

/* Ends a function with the entry of a roster that is called `name`, of `length`, or NULL. */
#define RETURN_NAMED(roster)                         \
  for (size_t i = 0; (roster)[i] != NULL; i++) {     \
    if (isCalled((roster)[i]->name, name, length)) { \
      return (roster)[i];                            \
    }                                                \
  }                                                  \
  return NULL

const Contestant* contestantFind(const InstructionSet* set, const char* name, size_t length) {
  RETURN_NAMED(set->contestants);
}

static const Contestant* findPrecision(const InstructionSet* set, const char* name, size_t length) {
  RETURN_NAMED(set->precisions);
}

const Contestant* precisionFind(const InstructionSet* set, const char* name, size_t length) {
  const Contestant* found = findPrecision(set, name, length);
  return found != NULL ? found : contestantFind(set, name, length);
}

const Kinematics* kinematicsFind(const InstructionSet* set, const char* name, size_t length) {
  RETURN_NAMED(set->kinematics);
}

const PairFinder* pairFinderFind(const InstructionSet* set, const char* name, size_t length) {
  RETURN_NAMED(set->pairFinders);
}

const NearestFinder* nearestFinderFind(const InstructionSet* set, const char* name, size_t length) {
  RETURN_NAMED(set->nearestFinders);
}
