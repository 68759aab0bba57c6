/* failingallocator.h: the program's own functions before the C library's allocator, which fail on request. To be
 * included by one file of a program; where it cannot be done, HAS_GLIBC_ALLOCATOR is not defined. */
#ifndef FAILINGALLOCATOR_H_
#define FAILINGALLOCATOR_H_

#include <stdbool.h>

#include "allocator.h"

#ifdef HAS_GLIBC_ALLOCATOR

extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* old, size_t size);
extern void* __libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void* memory);

static int allocationsLeft = -1; /* until one fails; negative: none does */
static bool hasFailed = false;   /* one has */
static int live = 0;             /* blocks that are not freed */
static int asked = 0;            /* allocations so far */

static bool mayAllocate(void) {
  asked++;
  if (allocationsLeft == 0) {
    allocationsLeft = -1;
    hasFailed = true;
    return false;
  }
  allocationsLeft -= allocationsLeft > 0;
  return true;
}

static void failAllocation(int number) {
  hasFailed = false;
  allocationsLeft = number;
}

static void* counted(void* memory) {
  live += memory != NULL;
  return memory;
}

void* malloc(size_t size) {
  return mayAllocate() ? counted(__libc_malloc(size)) : NULL;
}

void* calloc(size_t count, size_t size) {
  return mayAllocate() ? counted(__libc_calloc(count, size)) : NULL;
}

void* aligned_alloc(size_t alignment, size_t size) {
  return mayAllocate() ? counted(__libc_memalign(alignment, size)) : NULL;
}

void* realloc(void* old, size_t size) {
  if (!mayAllocate()) {
    return NULL;
  }
  void* memory = __libc_realloc(old, size);
  live += old == NULL && memory != NULL;
  return memory;
}

void free(void* memory) {
  live -= memory != NULL;
  __libc_free(memory);
}

#endif /* HAS_GLIBC_ALLOCATOR */

#endif /* FAILINGALLOCATOR_H_ */
