#include "wide.h"

#include <stdlib.h>
#include <string.h>

extern const Wide ctWidePortable;
#ifdef __x86_64__
extern const Wide ctWideAvx2;
extern const Wide ctWideAvx512;
#endif

const Wide* ctChooseWide(void) {
#ifdef __x86_64__
  const char* wanted = getenv("CHAINTREE_SIMD");
  const bool any = wanted == NULL;
  if ((any || strcmp(wanted, ctWideAvx512.name) == 0) && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512bw")) {
    return &ctWideAvx512;
  }
  if ((any || strcmp(wanted, ctWidePortable.name) != 0) && __builtin_cpu_supports("avx2")) {
    return &ctWideAvx2;
  }
#endif
  return &ctWidePortable;
}
