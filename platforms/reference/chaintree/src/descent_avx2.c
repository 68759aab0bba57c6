#ifdef __x86_64__
#define CT_PATH_AVX2
#define CT_DESCENT ctDescentAvx2
#define CT_DESCENT_NAME "avx2"
#include "descent_body.h"
#else
typedef int NoDescentHere; /* a file must declare something */
#endif
