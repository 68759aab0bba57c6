#include "roster.h"

#include <string.h>

extern Roster contestantsPortable;
extern Roster precisionsPortable;
extern KinematicsRoster kinematicsPortable;
extern PairFinders pairFindersPortable;
extern NearestFinders nearestFindersPortable;

static bool always(void) {
  return true;
}

#ifdef ROSTER_X86
extern Roster contestantsAvx2;
extern Roster precisionsAvx2;
extern KinematicsRoster kinematicsAvx2;
extern PairFinders pairFindersAvx2;
extern NearestFinders nearestFindersAvx2;
extern PairFinders pairFindersAvx512;
extern NearestFinders nearestFindersAvx512;

static bool hasAvx2(void) {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");
}

static bool hasAvx512(void) {
  return hasAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#endif

/* The best first. */
static const InstructionSet sets[] = {
#ifdef ROSTER_X86
    /* What gcc makes of contestants that name no instructions is slower with AVX-512 than with AVX2. */
    {"avx512", hasAvx512, contestantsAvx2, precisionsAvx2, kinematicsAvx2, "avx2", pairFindersAvx512,
     nearestFindersAvx512},
    {"avx2", hasAvx2, contestantsAvx2, precisionsAvx2, kinematicsAvx2, "avx2", pairFindersAvx2, nearestFindersAvx2},
#endif
    {"portable", always, contestantsPortable, precisionsPortable, kinematicsPortable, "portable", pairFindersPortable,
     nearestFindersPortable}};

const InstructionSet* instructionSetFind(const char* name) {
  for (size_t i = 0; i < sizeof sets / sizeof sets[0]; i++) {
    if ((name == NULL || strcmp(name, sets[i].name) == 0) && sets[i].isHere()) {
      return &sets[i];
    }
  }
  return NULL;
}

static bool isCalled(const char* itsName, const char* name, size_t length) {
  return strlen(itsName) == length && memcmp(itsName, name, length) == 0;
}

static const Contestant* findIn(const Contestant* const* roster, const char* name, size_t length) {
  const Contestant* const* c = roster;
  while (*c != NULL && !isCalled((*c)->name, name, length)) {
    c++;
  }
  return *c;
}

const Contestant* contestantFind(const InstructionSet* set, const char* name, size_t length) {
  return findIn(set->contestants, name, length);
}

const Contestant* precisionFind(const InstructionSet* set, const char* name, size_t length) {
  const Contestant* found = findIn(set->precisions, name, length);
  return found != NULL ? found : contestantFind(set, name, length);
}

const Kinematics* kinematicsFind(const InstructionSet* set, const char* name, size_t length) {
  const Kinematics* const* c = set->kinematics;
  while (*c != NULL && !isCalled((*c)->name, name, length)) {
    c++;
  }
  return *c;
}

const PairFinder* pairFinderFind(const InstructionSet* set, const char* name, size_t length) {
  const PairFinder* const* c = set->pairFinders;
  while (*c != NULL && !isCalled((*c)->name, name, length)) {
    c++;
  }
  return *c;
}

const NearestFinder* nearestFinderFind(const InstructionSet* set, const char* name, size_t length) {
  const NearestFinder* const* c = set->nearestFinders;
  while (*c != NULL && !isCalled((*c)->name, name, length)) {
    c++;
  }
  return *c;
}
