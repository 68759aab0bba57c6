/* Names of what is compiled once for each instruction set: the set's name is their suffix. */
#ifndef CT_SET_H_
#define CT_SET_H_

#include "../wide.h"

#if defined(CT_PATH_AVX512)
#define CT_WIDE(name) name##Avx512
#define CT_SET_NAME "avx512"
#elif defined(CT_PATH_AVX2)
#define CT_WIDE(name) name##Avx2
#define CT_SET_NAME "avx2"
#else
#define CT_WIDE(name) name##Portable
#define CT_SET_NAME "portable"
#endif

#define CT_DECLARATION(result, name, parameters) result CT_WIDE(name) parameters;
CT_WIDE_FUNCTIONS(CT_DECLARATION)
#undef CT_DECLARATION

#endif /* CT_SET_H_ */
