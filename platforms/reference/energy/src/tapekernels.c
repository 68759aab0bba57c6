#include "tapekernels.h"

#include <string.h>

const TapeKernels* ctFindTapeKernels(const char* name) {
#ifdef __x86_64__
  if (strcmp(name, "avx512") == 0) {
    return &ctAvx512TapeKernels;
  }
  if (strcmp(name, "avx2") == 0) {
    return &ctAvx2TapeKernels;
  }
#endif
  (void)name;
  return &ctPortableTapeKernels;
}
