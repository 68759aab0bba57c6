#ifdef __x86_64__
#define CT_PATH_AVX2
#define TAPE_KERNELS ctAvx2TapeKernels
#include "tapekernels_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
