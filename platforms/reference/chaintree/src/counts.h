/* Adds to the counts that a caller has given. */
#ifndef CT_COUNTS_H_
#define CT_COUNTS_H_

#include "chaintree.h"

/* Stays at the largest number: the caller may have begun with any. */
static inline void addCount(int64_t* count, int64_t more) {
  if (__builtin_add_overflow(*count, more, count)) {
    *count = INT64_MAX;
  }
}

/* Either number is at least 0. NULL: no counts are wanted. */
static inline void addTests(ctCounts* counts, int64_t volumeTests, int64_t particleTests) {
  if (counts != NULL) {
    addCount(&counts->volumeTests, volumeTests);
    addCount(&counts->particleTests, particleTests);
  }
}

#endif /* CT_COUNTS_H_ */
