/* A pair expression as fewer and cheaper operations that give the same number. What depends
 * on one particle alone is taken out, since it never changes. */
#ifndef CT_TAPEGRAPH_H_
#define CT_TAPEGRAPH_H_

#include "ctenergy.h"

/* A number of each particle: the result of an operation of the expression, or the root of it, times a factor, for the
 * first or the second particle of a pair. */
typedef struct TapeColumn {
  int side; /* 0 or 1 */
  int operation;
  bool isRoot;
  double factor;
} TapeColumn;

/* 1 / sqrt(a), which no expression has. */
#define INVERSE_ROOT_OPERATOR ((ctOperator)(ctTableOperator + 1))

/* The operations of a graph are those of an expression with these exceptions: the one input is the square of the
 * distance; a parameter is a column; there are no squares, cubes, reciprocals, negations, additions or products with
 * a constant, no secants and their kind, and no constant powers; these are made of others. The reciprocal of the
 * distance is an operation. None is there twice. */
typedef struct TapeGraph {
  int nodeCount;
  int nodeCapacity;
  ctOperation* nodes;
  int columnCount;
  int columnCapacity;
  TapeColumn* columns;
  int root; /* the node that is the result */
  bool failed;
} TapeGraph;

/* Makes the graph of a valid pair set, of which all parameters of a particle but the first `fixedCount` may change;
 * `numbers` are the results of all operations for each particle as both of a pair, one particle after another. False,
 * and nothing to free, if there is no memory. */
bool ctTapeGraphCreate(TapeGraph* graph, const ctPairSet* set, int fixedCount, int particleCount,
                       const double* numbers);
void ctTapeGraphFree(TapeGraph* graph);

#endif /* CT_TAPEGRAPH_H_ */
