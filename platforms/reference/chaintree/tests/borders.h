/* borders.h: values that arguments must not have, for tests that give each of them to each call. */
#ifndef BORDERS_H_
#define BORDERS_H_

#include <limits.h>
#include <math.h>

#include "chaintree.h"

static const int wrongCounts[] = {INT_MIN, -2, -1, CT_MOST_COUNT + 1, INT_MAX};
static const double notFinite[] = {NAN, INFINITY, -INFINITY};
static const double notPositive[] = {NAN, -INFINITY, -1, -5e-324, -0.0, 0};

/* The parentheses of a for loop over the indices of an array. */
#define EACH(i, values)                   \
  size_t i = 0;                           \
  i < sizeof(values) / sizeof(values)[0]; \
  i++

/* The calls made so far, which a test prints. */
static int callCount = 0;

#endif /* BORDERS_H_ */
