#ifdef __x86_64__
#define CT_PATH_AVX512
#define PATH avx512Path
#include "elementarypath_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
