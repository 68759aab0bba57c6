/* fuzzTarget.h: the random programs of tests/programs, chosen by the bytes of a fuzzer instead of a seed. */
#ifndef FUZZ_TARGET_H_
#define FUZZ_TARGET_H_

#include <stddef.h>
#include <stdint.h>

/* What libFuzzer calls, the first of them once. They return 0; a failure prints what is wrong and ends the process. At
 * the end of the process it is printed what has been compared. */
int LLVMFuzzerInitialize(int* argumentCount, char*** arguments);
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count);

#endif /* FUZZ_TARGET_H_ */
