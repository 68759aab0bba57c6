#include "set.h"

#define CT_ROW(result, name, parameters) .name = CT_WIDE(name),
const Wide CT_WIDE(ctWideEnergy) = {.name = CT_SET_NAME, CT_WIDE_FUNCTIONS(CT_ROW)};
#undef CT_ROW
