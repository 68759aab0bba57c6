#include "tapegraph.h"

#include <math.h>
#include <stdlib.h>

#include "expression.h"
#include "trialleaves.h"

/* On what a result depends, as bits. */
enum { ON_FIRST = 1, ON_SECOND = 2, ON_DISTANCE = 4 };

enum { NO_NODE = -1 };

typedef struct Builder {
  TapeGraph* graph;
  const ctPairSet* set;
  int fixedCount;
  int particleCount;
  const double* numbers;
  unsigned char* dependsOn; /* per operation of the set, as the next two */
  bool* mayChange;          /* it depends on a parameter that is not fixed */
  int* nodeOf;              /* or NO_NODE */
  int distance;             /* nodes that are made if they are needed, or NO_NODE */
  int inverse;
} Builder;

/* ---- Nodes ---- */

static bool sameOperation(const ctOperation* a, const ctOperation* b) {
  return a->kind == b->kind && a->arguments[0] == b->arguments[0] && a->arguments[1] == b->arguments[1] &&
         a->arguments[2] == b->arguments[2] && a->constant == b->constant;
}

/* The node that does this, which may be there already. */
static int addNode(Builder* b, ctOperator kind, int first, int second, int third, double constant) {
  TapeGraph* graph = b->graph;
  const bool commutes = kind == ctAddOperator || kind == ctMultiplyOperator;
  const bool swaps = commutes && second < first;
  const ctOperation node = {kind, {swaps ? second : first, swaps ? first : second, third}, constant};
  for (int i = 0; i < graph->nodeCount; i++) {
    if (sameOperation(&graph->nodes[i], &node)) {
      return i;
    }
  }
  if (graph->failed || !ctReserveEntries((void**)&graph->nodes, &graph->nodeCapacity, (size_t)graph->nodeCount + 1,
                                         sizeof *graph->nodes)) {
    graph->failed = true;
    return 0;
  }
  graph->nodes[graph->nodeCount] = node;
  return graph->nodeCount++;
}

static int addConstant(Builder* b, double value) {
  return addNode(b, ctConstantOperator, 0, 0, 0, value);
}

static bool sameColumn(const TapeColumn* a, const TapeColumn* b) {
  return a->side == b->side && a->operation == b->operation && a->isRoot == b->isRoot && a->factor == b->factor;
}

static int addColumn(Builder* b, TapeColumn column) {
  TapeGraph* graph = b->graph;
  int i = 0;
  while (i < graph->columnCount && !sameColumn(&graph->columns[i], &column)) {
    i++;
  }
  if (i == graph->columnCount) {
    if (!ctReserveEntries((void**)&graph->columns, &graph->columnCapacity, (size_t)i + 1, sizeof *graph->columns)) {
      graph->failed = true;
      return 0;
    }
    graph->columns[graph->columnCount++] = column;
  }
  return addNode(b, ctParameterOperator, i, 0, 0, 0);
}

static int squaredNode(Builder* b) {
  return addNode(b, ctInputOperator, 0, 0, 0, 0);
}

static int distanceNode(Builder* b) {
  b->distance = addNode(b, ctSqrtOperator, squaredNode(b), 0, 0, 0);
  return b->distance;
}

static int inverseNode(Builder* b) {
  b->inverse = addNode(b, INVERSE_ROOT_OPERATOR, squaredNode(b), 0, 0, 0);
  return b->inverse;
}

static bool isKind(const Builder* b, int node, ctOperator kind) {
  return b->graph->nodes[node].kind == kind;
}

/* ---- Products and powers ---- */

/* True if a factor can go into a column that the node has as a factor, or into two that it is the sum of. */
static bool takesFactor(const Builder* b, int node) {
  const ctOperation* operation = &b->graph->nodes[node];
  const int* n = operation->arguments;
  switch (operation->kind) {
    case ctParameterOperator:
      return true;
    case ctAddOperator:
    case ctSubtractOperator:
      return isKind(b, n[0], ctParameterOperator) && isKind(b, n[1], ctParameterOperator);
    case ctMultiplyOperator:
      return takesFactor(b, n[0]) || takesFactor(b, n[1]);
    default:
      return false;
  }
}

/* A node that takes a factor, times that. */
static int scale(Builder* b, int node, double factor) {
  if (b->graph->failed) {
    return 0;
  }
  const ctOperation operation = b->graph->nodes[node];
  const int* n = operation.arguments;
  if (operation.kind == ctParameterOperator) {
    TapeColumn column = b->graph->columns[n[0]];
    column.factor *= factor;
    return addColumn(b, column);
  }
  if (operation.kind != ctMultiplyOperator) {
    const int first = scale(b, n[0], factor);
    return addNode(b, operation.kind, first, scale(b, n[1], factor), 0, 0);
  }
  const bool isFirst = takesFactor(b, n[0]);
  const int scaled = scale(b, n[isFirst ? 0 : 1], factor);
  return addNode(b, ctMultiplyOperator, scaled, n[isFirst ? 1 : 0], 0, 0);
}

static int multiply(Builder* b, int x, int y) {
  if (x == y && x == b->distance) {
    return squaredNode(b);
  }
  if (isKind(b, x, ctConstantOperator)) {
    const int other = x;
    x = y;
    y = other;
  }
  if (isKind(b, y, ctConstantOperator)) {
    const double factor = b->graph->nodes[y].constant;
    if (factor == 1) {
      return x;
    }
    if (takesFactor(b, x)) {
      return scale(b, x, factor);
    }
  }
  return addNode(b, ctMultiplyOperator, x, y, 0, 0);
}

/* True for powers of the distance, whose reciprocals are those of its inverse. */
static bool isDistancePower(const Builder* b, int node) {
  const ctOperation* operation = &b->graph->nodes[node];
  return node == b->distance || operation->kind == ctInputOperator ||
         (operation->kind == ctMultiplyOperator && isDistancePower(b, operation->arguments[0]) &&
          isDistancePower(b, operation->arguments[1]));
}

static int reciprocal(Builder* b, int node) {
  if (b->graph->failed) {
    return 0;
  }
  if (!isDistancePower(b, node)) {
    return addNode(b, ctDivideOperator, addConstant(b, 1), node, 0, 0);
  }
  if (node == b->distance) {
    return inverseNode(b);
  }
  if (isKind(b, node, ctInputOperator)) {
    const int inverse = inverseNode(b);
    return multiply(b, inverse, inverse);
  }
  const int first = b->graph->nodes[node].arguments[0];
  const int second = b->graph->nodes[node].arguments[1];
  const int inverseOfFirst = reciprocal(b, first);
  return multiply(b, inverseOfFirst, reciprocal(b, second));
}

static int divide(Builder* b, int x, int y) {
  const double divisor = b->graph->nodes[y].constant;
  if (isKind(b, y, ctConstantOperator) && isnormal(divisor) && isnormal(1 / divisor)) {
    return multiply(b, x, addConstant(b, 1 / divisor));
  }
  return isDistancePower(b, y) ? multiply(b, x, reciprocal(b, y)) : addNode(b, ctDivideOperator, x, y, 0, 0);
}

/* x^n for n >= 1. An even power is a square, so that x^12 and x^6 share factors. */
static int wholePower(Builder* b, int x, int n) {
  if (n == 1 || b->graph->failed) {
    return x;
  }
  if (n % 2 == 0) {
    const int half = wholePower(b, x, n / 2);
    return multiply(b, half, half);
  }
  return multiply(b, x, wholePower(b, x, n - 1));
}

/* By products up to these exponents, whose roundings add up. */
enum { MOST_POWER = 64, MOST_ROOT_POWER = 15 };

static int power(Builder* b, int x, double exponent) {
  if (exponent == 0) {
    return addConstant(b, 1);
  }
  const double twice = 2 * fabs(exponent);
  if (fabs(exponent) <= MOST_POWER && exponent == (int)exponent) {
    return wholePower(b, exponent < 0 ? reciprocal(b, x) : x, abs((int)exponent));
  }
  if (twice <= MOST_ROOT_POWER && twice == (int)twice) {
    const int root = addNode(b, ctSqrtOperator, x, 0, 0, 0);
    return wholePower(b, exponent < 0 ? reciprocal(b, root) : root, (int)twice);
  }
  return addNode(b, ctPowerOperator, x, addConstant(b, exponent), 0, 0);
}

/* ---- Operations ---- */

static double numberOf(const Builder* b, int particle, int operation) {
  return b->numbers[(size_t)particle * (size_t)b->set->operationCount + (size_t)operation];
}

static TapeColumn columnOf(const Builder* b, int operation, bool isRoot) {
  return (TapeColumn){b->dependsOn[operation] == ON_FIRST ? 0 : 1, operation, isRoot, 1};
}

/* The node of an operation that was added, or that depends on no distance and not on both particles. */
static int nodeOf(Builder* b, int operation) {
  const int dependsOn = b->dependsOn[operation];
  if (b->nodeOf[operation] == NO_NODE) {
    b->nodeOf[operation] =
        dependsOn == 0 ? addConstant(b, numberOf(b, 0, operation)) : addColumn(b, columnOf(b, operation, false));
  }
  return b->nodeOf[operation];
}

static bool isNeverNegative(const Builder* b, int operation) {
  if (b->mayChange[operation]) {
    return false;
  }
  for (int i = 0; i < b->particleCount; i++) {
    if (!(numberOf(b, i, operation) >= 0)) {
      return false;
    }
  }
  return true;
}

/* The root of a product of what belongs to one particle and what belongs to the other is the product of roots. */
static int squareRoot(Builder* b, int argument) {
  const ctOperation* product = &b->set->operations[argument];
  if (product->kind == ctMultiplyOperator) {
    const int first = product->arguments[0];
    const int second = product->arguments[1];
    const int both = b->dependsOn[first] | b->dependsOn[second] << 4;
    if ((both == (ON_FIRST | ON_SECOND << 4) || both == (ON_SECOND | ON_FIRST << 4)) && isNeverNegative(b, first) &&
        isNeverNegative(b, second)) {
      const int rootOfFirst = addColumn(b, columnOf(b, first, true));
      return multiply(b, rootOfFirst, addColumn(b, columnOf(b, second, true)));
    }
  }
  return addNode(b, ctSqrtOperator, nodeOf(b, argument), 0, 0, 0);
}

static int addOperation(Builder* b, const ctOperation* operation) {
  const int count = ctArgumentCount(operation, b->set->tables);
  int n[3] = {0, 0, 0};
  for (int i = 0; i < count; i++) {
    n[i] = nodeOf(b, operation->arguments[i]);
  }
  if (b->graph->failed) {
    return 0;
  }
  switch (operation->kind) {
    case ctInputOperator:
      return distanceNode(b);
    case ctMultiplyOperator:
      return multiply(b, n[0], n[1]);
    case ctDivideOperator:
      return divide(b, n[0], n[1]);
    case ctPowerOperator:
      return isKind(b, n[1], ctConstantOperator) ? power(b, n[0], b->graph->nodes[n[1]].constant)
                                                 : addNode(b, ctPowerOperator, n[0], n[1], 0, 0);
    case ctPowerConstantOperator:
      return power(b, n[0], operation->constant);
    case ctNegateOperator:
      return multiply(b, n[0], addConstant(b, -1));
    case ctSqrtOperator:
      return squareRoot(b, operation->arguments[0]);
    case ctSecOperator:
      return reciprocal(b, addNode(b, ctCosOperator, n[0], 0, 0, 0));
    case ctCscOperator:
      return reciprocal(b, addNode(b, ctSinOperator, n[0], 0, 0, 0));
    case ctCotOperator:
      return reciprocal(b, addNode(b, ctTanOperator, n[0], 0, 0, 0));
    case ctSquareOperator:
      return multiply(b, n[0], n[0]);
    case ctCubeOperator:
      return wholePower(b, n[0], 3);
    case ctReciprocalOperator:
      return reciprocal(b, n[0]);
    case ctAddConstantOperator:
      return addNode(b, ctAddOperator, n[0], addConstant(b, operation->constant), 0, 0);
    case ctMultiplyConstantOperator:
      return multiply(b, n[0], addConstant(b, operation->constant));
    default:
      return addNode(b, operation->kind, n[0], n[1], n[2],
                     operation->kind == ctTableOperator ? operation->constant : 0);
  }
}

/* ---- The whole ---- */

static int dependenceOf(const Builder* b, const ctOperation* operation) {
  if (operation->kind == ctInputOperator) {
    return ON_DISTANCE;
  }
  if (operation->kind == ctParameterOperator) {
    return operation->arguments[0] < b->set->parametersPerParticle ? ON_FIRST : ON_SECOND;
  }
  int dependsOn = 0;
  for (int i = 0; i < ctArgumentCount(operation, b->set->tables); i++) {
    dependsOn |= b->dependsOn[operation->arguments[i]];
  }
  return dependsOn;
}

static bool canChange(const Builder* b, const ctOperation* operation) {
  if (operation->kind == ctParameterOperator) {
    return operation->arguments[0] % b->set->parametersPerParticle >= b->fixedCount;
  }
  bool mayChange = false;
  for (int i = 0; i < ctArgumentCount(operation, b->set->tables); i++) {
    mayChange = mayChange || b->mayChange[operation->arguments[i]];
  }
  return mayChange;
}

static void addAll(Builder* b) {
  const int count = b->set->operationCount;
  for (int i = 0; i < count; i++) {
    const int dependsOn = dependenceOf(b, &b->set->operations[i]);
    b->dependsOn[i] = (unsigned char)dependsOn;
    b->mayChange[i] = canChange(b, &b->set->operations[i]);
    b->nodeOf[i] = NO_NODE;
    if ((dependsOn & ON_DISTANCE) != 0 || dependsOn == (ON_FIRST | ON_SECOND)) {
      b->nodeOf[i] = addOperation(b, &b->set->operations[i]);
    }
  }
  b->graph->root = nodeOf(b, count - 1);
}

bool ctTapeGraphCreate(TapeGraph* graph, const ctPairSet* set, int fixedCount, int particleCount,
                       const double* numbers) {
  const size_t count = (size_t)set->operationCount;
  *graph = (TapeGraph){0};
  Builder builder = {.graph = graph,
                     .set = set,
                     .fixedCount = fixedCount,
                     .particleCount = particleCount,
                     .numbers = numbers,
                     .dependsOn = malloc(count),
                     .mayChange = malloc(count * sizeof(bool)),
                     .nodeOf = malloc(count * sizeof(int)),
                     .distance = NO_NODE,
                     .inverse = NO_NODE};
  graph->failed = builder.dependsOn == NULL || builder.mayChange == NULL || builder.nodeOf == NULL;
  if (!graph->failed) {
    addAll(&builder);
  }
  free(builder.dependsOn);
  free(builder.mayChange);
  free(builder.nodeOf);
  if (graph->failed) {
    ctTapeGraphFree(graph);
    return false;
  }
  return true;
}

void ctTapeGraphFree(TapeGraph* graph) {
  free(graph->nodes);
  free(graph->columns);
  *graph = (TapeGraph){0};
}
