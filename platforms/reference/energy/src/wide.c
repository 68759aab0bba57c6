#include "wide.h"

#include <string.h>

extern const Wide ctWideEnergyPortable;
#ifdef __x86_64__
extern const Wide ctWideEnergyAvx2;
extern const Wide ctWideEnergyAvx512;
#endif

const Wide* ctFindWide(const char* name) {
#ifdef __x86_64__
  if (strcmp(name, ctWideEnergyAvx512.name) == 0) {
    return &ctWideEnergyAvx512;
  }
  if (strcmp(name, ctWideEnergyAvx2.name) == 0) {
    return &ctWideEnergyAvx2;
  }
#endif
  (void)name;
  return &ctWideEnergyPortable;
}
