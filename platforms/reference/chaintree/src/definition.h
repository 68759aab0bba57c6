/* Checks a definition before anything is built from it. */
#ifndef CT_DEFINITION_H_
#define CT_DEFINITION_H_

#include <math.h>

#include "chaintree.h"

/* Returns ctSuccess, or a status and a sentence that names the culprit. */
ctStatus ctDefinitionCheck(const ctDefinition* definition, char* errorText, size_t errorSize);

/* The end of the sentence about a length that is none. */
#define CT_NO_LENGTH "is not finite, or beyond 1e15 nm"

static inline bool isIndex(int value, int count) {
  return value >= 0 && value < count;
}

static inline bool isLength(double x) {
  return fabs(x) <= CT_MOST_LENGTH;
}

static inline bool areLengths(const double x[3]) {
  return isLength(x[0]) && isLength(x[1]) && isLength(x[2]);
}

/* True if the position of a free joint in its parent's frame is near enough: up to ten times the largest length, whose
 * square a float still holds (1e32 of 3e38). */
static inline bool isJointPosition(const double x[3]) {
  const double most = 10 * CT_MOST_LENGTH;
  return fabs(x[0]) <= most && fabs(x[1]) <= most && fabs(x[2]) <= most;
}

/* The first particle with a coordinate that is no length; CT_NULL if there is none. */
int ctFindBadPosition(int particleCount, const double* positions);

#endif /* CT_DEFINITION_H_ */
