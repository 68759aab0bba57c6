#define TAPE_ENERGY ctPortableTapeEnergy
#include "tapekernels_body.h"
