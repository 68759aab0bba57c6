/* Arrays that are made together and freed together. */
#ifndef CT_ARENA_H_
#define CT_ARENA_H_

#include <stdbool.h>
#include <stddef.h>

typedef struct Arena {
  void** blocks;
  int count;
  int capacity;
  bool failed; /* an allocation has failed */
} Arena;

/* A zeroed array, aligned for any SIMD path; NULL, and `failed` set, if there is no memory. */
void* ctArenaAllocate(Arena* arena, size_t count, size_t size);

void ctArenaFree(Arena* arena);

/* Makes room for `count` elements in a growing array; false, and nothing changed, if there is no memory. */
bool ctReserve(void** array, int* capacity, int count, size_t size);

#endif /* CT_ARENA_H_ */
