#ifdef __x86_64__
#define CT_PATH_AVX2
#define KERNELS ctAvx2Kernels
#define KERNELS_NAME "avx2"
#include "kernels_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
