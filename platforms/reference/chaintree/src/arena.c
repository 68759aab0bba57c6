#include "arena.h"

#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <malloc.h>
#endif

enum { ALIGNMENT = 64 };

/* Windows has no aligned_alloc, and another function that frees such memory. */
static void* allocateAligned(size_t bytes) {
#ifdef _WIN32
  return _aligned_malloc(bytes, ALIGNMENT);
#else
  return aligned_alloc(ALIGNMENT, bytes);
#endif
}

static void freeAligned(void* block) {
#ifdef _WIN32
  _aligned_free(block);
#else
  free(block);
#endif
}

bool ctReserve(void** array, int* capacity, int count, size_t size) {
  if (count <= *capacity) {
    return true;
  }
  int grown = count;
  if (*capacity <= INT_MAX / 2 && 2 * *capacity > count) {
    grown = 2 * *capacity;
  }
  void* moved = realloc(*array, (size_t)grown * size);
  if (moved == NULL) {
    return false;
  }
  *array = moved;
  *capacity = grown;
  return true;
}

void* ctArenaAllocate(Arena* arena, size_t count, size_t size) {
  if (arena->failed || !ctReserve((void**)&arena->blocks, &arena->capacity, arena->count + 1, sizeof(void*)) ||
      count > (SIZE_MAX - ALIGNMENT) / size) {
    arena->failed = true;
    return NULL;
  }
  const size_t bytes = (count * size / ALIGNMENT + 1) * ALIGNMENT;
  void* block = allocateAligned(bytes);
  if (block == NULL) {
    arena->failed = true;
    return NULL;
  }
  memset(block, 0, bytes);
  arena->blocks[arena->count++] = block;
  return block;
}

void ctArenaFree(Arena* arena) {
  for (int i = 0; i < arena->count; i++) {
    freeAligned(arena->blocks[i]);
  }
  free(arena->blocks);
  *arena = (Arena){0};
}
