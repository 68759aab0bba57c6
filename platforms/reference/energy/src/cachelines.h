/* Arrays that begin where a line of the processor's cache does, so that sixteen floats of theirs lie in one. */
#ifndef CT_CACHELINES_H_
#define CT_CACHELINES_H_

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { CACHE_LINE = 64 }; /* bytes */

/* A zeroed array, or NULL if there is no memory. */
static inline void* allocateLines(size_t count, size_t size) {
  char* memory = calloc(count * size / CACHE_LINE + 2, CACHE_LINE);
  if (memory == NULL) {
    return NULL;
  }
  /* What calloc returns is never so near before a line that a pointer would not fit between them. */
  char* lines = memory + CACHE_LINE - (uintptr_t)memory % CACHE_LINE;
  memcpy(lines - sizeof memory, &memory, sizeof memory);
  return lines;
}

/* NULL is ignored. */
static inline void freeLines(void* lines) {
  if (lines != NULL) {
    void* memory;
    memcpy(&memory, (char*)lines - sizeof memory, sizeof memory);
    free(memory);
  }
}

/* Makes an array of `count` entries, which may be 0, longer. False, and nothing changed, if there is no memory. */
static inline bool growLines(void** lines, size_t count, size_t newCount, size_t size) {
  void* grown = allocateLines(newCount, size);
  if (grown == NULL) {
    return false;
  }
  if (count > 0) {
    memcpy(grown, *lines, count * size);
  }
  freeLines(*lines);
  *lines = grown;
  return true;
}

#endif /* CT_CACHELINES_H_ */
