#define TAPE_KERNELS ctPortableTapeKernels
#include "tapekernels_body.h"
