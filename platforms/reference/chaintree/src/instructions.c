#include "instructions.h"

#include <stdlib.h>
#include <string.h>

const InstructionSet* ctChooseInstructions(void) {
#ifdef __x86_64__
  const char* wanted = getenv("CHAINTREE_SIMD");
  const bool any = wanted == NULL;
  if ((any || strcmp(wanted, ctAvx512.name) == 0) && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512bw")) {
    return &ctAvx512;
  }
  if ((any || strcmp(wanted, ctPortable.name) != 0) && __builtin_cpu_supports("avx2")) {
    return &ctAvx2;
  }
#endif
  return &ctPortable;
}
