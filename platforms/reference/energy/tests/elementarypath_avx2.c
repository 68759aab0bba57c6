#ifdef __x86_64__
#define CT_PATH_AVX2
#define PATH avx2Path
#include "elementarypath_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
