#include "roster.h"

#include <string.h>

static bool always(void) {
  return true;
}

#ifdef ROSTER_X86
static bool hasAvx2(void) {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");
}
#endif

/* The best first. */
static const InstructionSet sets[] = {
#ifdef ROSTER_X86
    {"avx2", hasAvx2, rosterAvx2},
#endif
    {"portable", always, rosterPortable}};

const InstructionSet* instructionSetFind(const char* name) {
  for (size_t i = 0; i < sizeof sets / sizeof sets[0]; i++) {
    if ((name == NULL || strcmp(name, sets[i].name) == 0) && sets[i].isHere()) {
      return &sets[i];
    }
  }
  return NULL;
}

const Contestant* rosterFind(const InstructionSet* set, const char* name, size_t nameLength) {
  for (const Contestant* const* c = set->roster; *c != NULL; c++) {
    if (strlen((*c)->name) == nameLength && memcmp((*c)->name, name, nameLength) == 0) {
      return *c;
    }
  }
  return NULL;
}
