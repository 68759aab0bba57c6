/* Memory that is there: without any, the program ends. */
#ifndef MEMORY_H_
#define MEMORY_H_

#include <stdio.h>
#include <stdlib.h>

static inline void* memoryOf(void* memory) {
  if (memory == NULL) {
    fputs("openmm-chaintree-contestants: not enough memory\n", stderr);
    exit(1);
  }
  return memory;
}

/* Zeroed; `count` may be 0. */
static inline void* allocate(int count, size_t size) {
  return memoryOf(calloc(count > 0 ? (size_t)count : 1, size));
}

static inline void* reallocate(void* memory, int count, size_t size) {
  return memoryOf(realloc(memory, (size_t)count * size));
}

#endif /* MEMORY_H_ */
