#ifdef __x86_64__
#define CT_PATH_AVX512
#define INSTRUCTION_SET ctAvx512
#define INSTRUCTION_SET_NAME "avx512"
#include "instructions_body.h"
#else
typedef int NothingHere; /* a file must declare something */
#endif
