#include "kernels.h"

#include <string.h>

const Kernels* ctFindKernels(const char* name) {
#ifdef __x86_64__
  if (strcmp(name, ctAvx512Kernels.name) == 0) {
    return &ctAvx512Kernels;
  }
  if (strcmp(name, ctAvx2Kernels.name) == 0) {
    return &ctAvx2Kernels;
  }
#endif
  (void)name;
  return &ctPortableKernels;
}
