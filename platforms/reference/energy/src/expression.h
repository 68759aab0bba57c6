/* Expressions: a tape of operations on what is measured of a term's particles. */
#ifndef CT_EXPRESSION_H_
#define CT_EXPRESSION_H_

#include <stdbool.h>
#include <stddef.h>

#include "ctenergy.h"
#include "periodicbox.h"

/* A copy of a ctExpression. */
typedef struct Expression {
  int inputCount;
  ctInput* inputs;
  int operationCount;
  ctOperation* operations;
} Expression;

/* The number of particles that a measure is of. */
int ctMeasureWidth(ctMeasure measure);

/* How many results of earlier operations an operation takes: for a table, as many as its dimensions. */
int ctArgumentCount(const ctOperation* operation, const ctTable* tables);

/* Copies valid operations, with 0 for the arguments that they do not take. NULL if there is no memory. */
ctOperation* ctCopyOperations(const ctOperation* from, int count, const ctTable* tables);

/* The result of an operation on these by the C library's functions; not for inputs, parameters and tables. */
double ctOperate(const ctOperation* operation, double a, double b, double c);

/* True if the expression, called `name`, can be evaluated for terms with these numbers of particles and parameters;
 * else text, of `size` bytes, says what is wrong with it. */
bool ctExpressionIsValid(const ctExpression* expression, const char* name, int particlesPerTerm, int parametersPerTerm,
                         char* text, size_t size);

/* Copies a valid expression. False, and nothing copied, if there is no memory. */
bool ctExpressionCopy(const ctExpression* from, Expression* to);

void ctExpressionFree(Expression* expression);

/* True if some input is a coordinate: a motion of the whole term changes its value. */
bool ctExpressionHasCoordinate(const ctExpression* expression);

/* The value for the particles and parameters of a term, of nearest images unless `box` is NULL; *isLong: see Term.
 * `results` is scratch for one number an operation, none of which may be uninitialized. */
double ctExpressionEvaluate(const Expression* expression, const double (*positions)[3], const PeriodicBox* box,
                            const double* parameters, double* results, bool* isLong);

#endif /* CT_EXPRESSION_H_ */
