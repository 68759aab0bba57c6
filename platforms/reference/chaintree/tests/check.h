/* check.h: what every test program of the engine and of the benchmark's contestants uses. A program returns 1 if a
 * check has failed. */
#ifndef CHECK_H_
#define CHECK_H_

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chaintree.h"

#define PI 3.14159265358979323846

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

#define CHECK_NEAR(value, expected, error)                                                             \
  do {                                                                                                 \
    const double value_ = (value), expected_ = (expected);                                             \
    if (!(fabs(value_ - expected_) <= (error))) {                                                      \
      reportFailure("%s:%d: %s is %.17g, not %.17g\n", __FILE__, __LINE__, #value, value_, expected_); \
    }                                                                                                  \
  } while (0)

#define CHECK_SUCCESS(call)                                                              \
  do {                                                                                   \
    const ctStatus status_ = (call);                                                     \
    if (status_ != ctSuccess) {                                                          \
      reportFailure("%s:%d: %s returned %d\n", __FILE__, __LINE__, #call, (int)status_); \
    }                                                                                    \
  } while (0)

/* A call on `tree` that must fail, with a text that holds `culprit`. */
#define CHECK_FAILURE(tree, expected, culprit, call)                                                                   \
  do {                                                                                                                 \
    const ctStatus status_ = (call);                                                                                   \
    if (status_ != (expected) || strstr(ctGetErrorText(tree), (culprit)) == NULL) {                                    \
      reportFailure("%s:%d: %s returned %d, \"%s\"\n", __FILE__, __LINE__, #call, (int)status_, ctGetErrorText(tree)); \
    }                                                                                                                  \
  } while (0)

static inline int checkResult(void) {
  return checkFailures > 0;
}

/* Makes a scene that must be right. */
static inline ctChainTree* checkedCreate(const ctDefinition* definition) {
  ctChainTree* tree = NULL;
  char text[256] = "";
  if (ctCreate(definition, &tree, text, sizeof text) != ctSuccess) {
    printf("ctCreate: %s\n", text);
    exit(1);
  }
  return tree;
}

/* Makes a selection that must be right. */
static inline ctSelection* checkedSelect(ctChainTree* tree, int count, const int* particles) {
  ctSelection* selection = NULL;
  if (ctSelect(tree, count, particles, &selection) != ctSuccess) {
    printf("ctSelect: %s\n", ctGetErrorText(tree));
    exit(1);
  }
  return selection;
}

/* The least distance between two sets, and the pair. */
static inline ctStatus minimumDistance(ctChainTree* tree, int count1, const int* particles1, int count2,
                                       const int* particles2, double* distance, int pair[2]) {
  ctSelection* first = checkedSelect(tree, count1, particles1);
  ctSelection* second = checkedSelect(tree, count2, particles2);
  const ctStatus status = ctGetMinimumDistance(tree, first, second, distance, pair, NULL);
  ctFreeSelection(first);
  ctFreeSelection(second);
  return status;
}

/* The number of pairs that a query calls back with, and the last of them. */
typedef struct PairCount {
  int count;
  int pair[2];
  double value;
} PairCount;

static inline bool countPair(void* context, int particle1, int particle2, double value) {
  PairCount* pairs = context;
  pairs->count++;
  pairs->pair[0] = particle1;
  pairs->pair[1] = particle2;
  pairs->value = value;
  return true;
}

#endif /* CHECK_H_ */
