/* Names of what is compiled once for each instruction set: the set's name is their suffix. The compiler's command line
 * defines CT_PATH_AVX512, CT_PATH_AVX2 or neither. */
#ifndef CT_INSTRUCTIONSET_H_
#define CT_INSTRUCTIONSET_H_

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

#endif /* CT_INSTRUCTIONSET_H_ */
