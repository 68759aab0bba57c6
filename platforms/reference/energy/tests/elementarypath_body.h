/* Compiled once for each instruction set by the file that includes this. It defines PATH before. */
#include "elementary.h"
#include "elementarypath.h"

#define DEFINE_FUNCTION(name)                            \
  static void name##All(const float* x, float* result) { \
    store16(result, name##16(load16(x)));                \
  }

DEFINE_FUNCTION(exp)
DEFINE_FUNCTION(log)

const ElementaryPath PATH = {.exp = expAll, .log = logAll};
