#ifdef __x86_64__
#define CT_PATH_AVX2
#define INSTRUCTION_SET ctAvx2
#define INSTRUCTION_SET_NAME "avx2"
#include "instructions_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
