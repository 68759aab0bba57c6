/* What every test program of the contestants uses. A program returns 1 if a check has failed. */
#ifndef CHECK_H_
#define CHECK_H_

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static int checkFailures = 0;

/* One defect can fail thousands of checks: the first few tell what there is to know. */
static inline void reportFailure(const char* format, ...) __attribute__((format(printf, 1, 2)));

static inline void reportFailure(const char* format, ...) {
  if (checkFailures++ < 20) {
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
  }
}

#define CHECK(condition)                                                \
  do {                                                                  \
    if (!(condition)) {                                                 \
      reportFailure("%s:%d: not %s\n", __FILE__, __LINE__, #condition); \
    }                                                                   \
  } while (0)

static inline int checkResult(void) {
  return checkFailures > 0;
}

#endif /* CHECK_H_ */
