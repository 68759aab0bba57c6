/* allocator.h: whether the C library's own allocator is the program's. */
#ifndef ALLOCATOR_H_
#define ALLOCATOR_H_

#include <stdlib.h> /* defines __GLIBC__ */

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED
#endif
#if defined(__GLIBC__) && !defined(SANITIZED)
#define HAS_GLIBC_ALLOCATOR
#endif

#endif /* ALLOCATOR_H_ */
