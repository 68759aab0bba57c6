#include "tapekernels.h"

#include <string.h>

TapeKernel* ctFindTapeKernel(const char* name) {
#ifdef __x86_64__
  if (strcmp(name, "avx512") == 0) {
    return ctAvx512TapeEnergy;
  }
  if (strcmp(name, "avx2") == 0) {
    return ctAvx2TapeEnergy;
  }
#endif
  (void)name;
  return ctPortableTapeEnergy;
}
