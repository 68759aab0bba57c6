#ifdef __x86_64__
#define CT_PATH_AVX512
#define CT_DESCENT ctDescentAvx512
#define CT_DESCENT_NAME "avx512"
#include "descent_body.h"
#else
typedef int NoDescentHere; /* a file must declare something */
#endif
