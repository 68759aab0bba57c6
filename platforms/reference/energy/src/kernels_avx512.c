#ifdef __x86_64__
#define CT_PATH_AVX512
#define KERNELS ctAvx512Kernels
#define KERNELS_NAME "avx512"
#include "kernels_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
