#ifdef __x86_64__
#define CT_PATH_AVX512
#define TAPE_KERNELS ctAvx512TapeKernels
#include "tapekernels_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
