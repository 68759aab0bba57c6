/* An expression of one particle or of two, in double, by the C library's functions. */
#ifndef CT_PAIREXPRESSION_H_
#define CT_PAIREXPRESSION_H_

#include "ctenergy.h"

/* A copy of an expression with its tables. */
typedef struct PairExpression {
  int operationCount;
  ctOperation* operations;
  int parametersPerParticle;
  int tableCount;
  ctTable* tables; /* with copies of their values */
  double* results; /* of each operation in the last evaluation */
} PairExpression;

/* Copies the expression of a valid pair set. False, and nothing to free, if there is no memory. */
bool ctPairExpressionCreate(PairExpression* expression, const ctPairSet* set);
void ctPairExpressionFree(PairExpression* expression);

/* The value for a distance and the parameters of two particles; of one particle, that is both. */
double ctPairExpressionEvaluate(const PairExpression* expression, double distance, const double* first,
                                const double* second);

#endif /* CT_PAIREXPRESSION_H_ */
