/* Checks what the user described, before anything is built from it. */
#ifndef CT_DEFINITION_H_
#define CT_DEFINITION_H_

#include <math.h>

#include "chaintree.h"

/* ctSuccess, or a status and a sentence that names the culprit. */
ctStatus ctDefinitionCheck(const ctDefinition* definition, char* errorText, size_t errorSize);

/* What is wrong with a length that is none. */
#define CT_NO_LENGTH "is not finite, or beyond 1e15 nm"

static inline bool isLength(double x) {
  return fabs(x) <= CT_MOST_LENGTH;
}

static inline bool areLengths(const double x[3]) {
  return isLength(x[0]) && isLength(x[1]) && isLength(x[2]);
}

/* How far a free joint may come to lie from its parent's origin: farther than positions can be given, nearer than
 * squares of a float reach. */
static inline bool isJointPosition(const double x[3]) {
  const double most = 10 * CT_MOST_LENGTH;
  return fabs(x[0]) <= most && fabs(x[1]) <= most && fabs(x[2]) <= most;
}

/* The first coordinate that is no length belongs to this particle; CT_NULL if there is none. */
int ctFindBadPosition(int particleCount, const double* positions);

#endif /* CT_DEFINITION_H_ */
