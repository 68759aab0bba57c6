/* Compiled once for each instruction set. */
#include "../elementarypath.h"

#include "elementary.h"
#include "instructionset.h"

#define DEFINE_OF_ONE(name)                                                \
  static void name##OfAll(const float* x, const float* y, float* result) { \
    (void)y;                                                               \
    store16(result, name##16(load16(x)));                                  \
  }

#define DEFINE_OF_TWO(name)                                                \
  static void name##OfAll(const float* x, const float* y, float* result) { \
    store16(result, name##16(load16(x), load16(y)));                       \
  }

DEFINE_OF_ONE(exp)
DEFINE_OF_ONE(log)
DEFINE_OF_ONE(sin)
DEFINE_OF_ONE(cos)
DEFINE_OF_ONE(tan)
DEFINE_OF_ONE(asin)
DEFINE_OF_ONE(acos)
DEFINE_OF_ONE(atan)
DEFINE_OF_ONE(sinh)
DEFINE_OF_ONE(cosh)
DEFINE_OF_ONE(tanh)
DEFINE_OF_ONE(erf)
DEFINE_OF_ONE(erfc)
DEFINE_OF_ONE(floor)
DEFINE_OF_ONE(ceil)
DEFINE_OF_ONE(inverseRoot)
DEFINE_OF_TWO(pow)
DEFINE_OF_TWO(atan2)

const ElementaryPath CT_WIDE(elementary) = {.exp = expOfAll,
                                            .log = logOfAll,
                                            .sin = sinOfAll,
                                            .cos = cosOfAll,
                                            .tan = tanOfAll,
                                            .asin = asinOfAll,
                                            .acos = acosOfAll,
                                            .atan = atanOfAll,
                                            .sinh = sinhOfAll,
                                            .cosh = coshOfAll,
                                            .tanh = tanhOfAll,
                                            .erf = erfOfAll,
                                            .erfc = erfcOfAll,
                                            .floor = floorOfAll,
                                            .ceil = ceilOfAll,
                                            .inverseRoot = inverseRootOfAll,
                                            .pow = powOfAll,
                                            .atan2 = atan2OfAll};
