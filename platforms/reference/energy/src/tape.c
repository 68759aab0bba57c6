#include "tape.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "expression.h"
#include "pairtable.h"

enum { UNUSED = -1 };

/* ---- Steps ---- */

/* True for a sum, difference or product of columns of both sides, which a step reads itself. */
static bool isOfColumns(const TapeGraph* graph, const ctOperation* node) {
  if (node->kind != ctAddOperator && node->kind != ctSubtractOperator && node->kind != ctMultiplyOperator) {
    return false;
  }
  const ctOperation* first = &graph->nodes[node->arguments[0]];
  const ctOperation* second = &graph->nodes[node->arguments[1]];
  return first->kind == ctParameterOperator && second->kind == ctParameterOperator &&
         graph->columns[first->arguments[0]].side != graph->columns[second->arguments[0]].side;
}

/* How many results of other steps a node needs. */
static int countResults(const TapeGraph* graph, const ctTable* tables, int i) {
  const ctOperation* node = &graph->nodes[i];
  return isOfColumns(graph, node) ? 0 : ctArgumentCount(node, tables);
}

/* The node of each node's last use, or UNUSED; the result is used after all, and so are squares of distances. */
static void findLastUses(const TapeGraph* graph, const ctTable* tables, int* lastUse) {
  for (int i = 0; i < graph->nodeCount; i++) {
    lastUse[i] = UNUSED;
  }
  lastUse[graph->root] = graph->nodeCount;
  for (int i = graph->nodeCount - 1; i >= 0; i--) {
    for (int k = 0; lastUse[i] != UNUSED && k < countResults(graph, tables, i); k++) {
      int* last = &lastUse[graph->nodes[i].arguments[k]];
      *last = *last == UNUSED ? i : *last;
    }
    if (graph->nodes[i].kind == ctInputOperator) {
      lastUse[i] = graph->nodeCount;
    }
  }
}

/* Lines of the scratch, of a number for each pair, that are given to nodes and taken back from them. */
typedef struct Lines {
  int firstBegin;
  int count;
  int freeCount;
  int* free;
} Lines;

static TapeValue takeLine(Lines* lines) {
  const int line = lines->freeCount > 0 ? lines->free[--lines->freeCount] : lines->count++;
  return (TapeValue){lines->firstBegin + line * MOST_LEAF_PAIRS, CT_LEAF_WIDTH};
}

static void giveBack(Lines* lines, TapeValue value) {
  if (value.step != 0) {
    lines->free[lines->freeCount++] = (value.begin - lines->firstBegin) / MOST_LEAF_PAIRS;
  }
}

/* The number of a column in the tape, which has those alone that are read. */
static int columnNumber(Tape* tape, const TapeColumn* column) {
  for (int i = 0; i < tape->columnCount; i++) {
    const TapeColumn* made = &tape->columnKinds[i];
    if (made->side == column->side && made->operation == column->operation && made->isRoot == column->isRoot &&
        made->factor == column->factor) {
      return i;
    }
  }
  tape->columnKinds[tape->columnCount] = *column;
  return tape->columnCount++;
}

static void addColumnsToStep(Tape* tape, const TapeGraph* graph, const ctOperation* node, TapeStep* step) {
  if (node->kind == ctParameterOperator) {
    const TapeColumn* column = &graph->columns[node->arguments[0]];
    step->side = column->side;
    step->columns[0] = columnNumber(tape, column);
  } else if (isOfColumns(graph, node)) {
    step->isOfColumns = true;
    for (int k = 0; k < 2; k++) {
      const TapeColumn* column = &graph->columns[graph->nodes[node->arguments[k]].arguments[0]];
      step->side = k == 0 ? column->side : step->side;
      step->columns[k] = columnNumber(tape, column);
    }
  }
}

static void addStep(Tape* tape, const TapeGraph* graph, int i, const int* lastUse, TapeValue* values, Lines* lines) {
  const ctOperation* node = &graph->nodes[i];
  const int count = countResults(graph, tape->expression.tables, i);
  TapeStep* step = &tape->steps[tape->stepCount++];
  *step = (TapeStep){.kind = node->kind};
  addColumnsToStep(tape, graph, node, step);
  if (node->kind == ctTableOperator) {
    step->table = &tape->tables[(int)node->constant];
  }
  /* A result may take the place of what is used here for the last time. */
  for (int k = 0; k < count; k++) {
    const int argument = node->arguments[k];
    const bool isRepeated = (k > 0 && argument == node->arguments[0]) || (k > 1 && argument == node->arguments[1]);
    step->arguments[k] = values[argument];
    if (lastUse[argument] == i && !isRepeated) {
      giveBack(lines, values[argument]);
    }
  }
  values[i] = takeLine(lines);
  step->result = values[i].begin;
}

/* True if a number as a float is off by no more than its rounding. */
static bool isFloat(double value) {
  return value == 0 || (fabs(value) >= (double)FLT_MIN && fabs(value) <= (double)FLT_MAX);
}

static bool makeSteps(Tape* tape, const TapeGraph* graph) {
  const size_t count = (size_t)graph->nodeCount;
  int* lastUse = malloc(count * sizeof *lastUse);
  TapeValue* values = malloc(count * sizeof *values);
  Lines lines = {.free = malloc(count * sizeof *lines.free)};
  tape->steps = malloc(count * sizeof *tape->steps);
  tape->columnKinds = malloc(((size_t)graph->columnCount + 1) * sizeof *tape->columnKinds);
  bool isMade =
      lastUse != NULL && values != NULL && lines.free != NULL && tape->steps != NULL && tape->columnKinds != NULL;
  if (isMade) {
    findLastUses(graph, tape->expression.tables, lastUse);
    /* Constants come first. Squares of distances are there when the tape starts. */
    for (int i = 0; i < graph->nodeCount; i++) {
      if (graph->nodes[i].kind == ctConstantOperator && lastUse[i] != UNUSED) {
        values[i] = (TapeValue){lines.firstBegin, 0};
        lines.firstBegin += CT_LEAF_WIDTH;
      }
    }
    tape->squaredBegin = takeLine(&lines).begin;
    for (int i = 0; i < graph->nodeCount; i++) {
      if (graph->nodes[i].kind == ctInputOperator) {
        values[i] = (TapeValue){tape->squaredBegin, CT_LEAF_WIDTH};
      } else if (graph->nodes[i].kind != ctConstantOperator && lastUse[i] != UNUSED) {
        addStep(tape, graph, i, lastUse, values, &lines);
      }
    }
    tape->result = values[graph->root];
    /* Listing pairs may write a row beyond the end. */
    const size_t rows = (size_t)lines.count * CT_LEAF_WIDTH + 1;
    tape->scratch = calloc((size_t)lines.firstBegin + rows * CT_LEAF_WIDTH, sizeof *tape->scratch);
    isMade = tape->scratch != NULL;
  }
  for (int i = 0; isMade && i < graph->nodeCount; i++) {
    if (graph->nodes[i].kind == ctConstantOperator && lastUse[i] != UNUSED) {
      tape->constantsAreExact = tape->constantsAreExact || !isFloat(graph->nodes[i].constant);
      for (int k = 0; k < CT_LEAF_WIDTH; k++) {
        tape->scratch[values[i].begin + k] = (float)graph->nodes[i].constant;
      }
    }
  }
  free(lastUse);
  free(values);
  free(lines.free);
  return isMade;
}

/* ---- Columns ---- */

void ctTapeSetParameters(Tape* tape, int particleCount, const int* slotOf, const double* parameters, int stride) {
  const size_t count = (size_t)tape->columnCount;
  tape->isExact = tape->constantsAreExact;
  for (int i = 0; i < particleCount; i++) {
    const double* ofParticle = parameters + (size_t)i * (size_t)stride;
    if (slotOf[i] == CT_NULL || count == 0) {
      continue;
    }
    ctPairExpressionEvaluate(&tape->expression, 1, ofParticle, ofParticle);
    float* columns = tape->columns + (size_t)(slotOf[i] / CT_LEAF_WIDTH) * count * CT_LEAF_WIDTH;
    for (size_t c = 0; c < count; c++) {
      const TapeColumn* kind = &tape->columnKinds[c];
      const double number = tape->expression.results[kind->operation];
      const double value = kind->factor * (kind->isRoot ? sqrt(number) : number);
      tape->isExact = tape->isExact || (isfinite(value) && !isFloat(value));
      columns[c * CT_LEAF_WIDTH + (size_t)(slotOf[i] % CT_LEAF_WIDTH)] = (float)value;
    }
  }
}

/* ---- Life ---- */

/* Whole numbers up to here are floats. */
enum { MOST_WHOLE_FLOAT = 1 << 24 };

/* Makes floats of the tables' values. */
static bool makeTables(Tape* tape) {
  const PairExpression* expression = &tape->expression;
  tape->tables = calloc((size_t)expression->tableCount + 1, sizeof *tape->tables);
  for (int i = 0; tape->tables != NULL && i < expression->tableCount; i++) {
    const ctTable* exact = &expression->tables[i];
    const size_t length = tableLength(exact);
    float* values = malloc(length * sizeof *values);
    if (values == NULL) {
      return false;
    }
    for (size_t k = 0; k < length; k++) {
      values[k] = (float)exact->values[k];
      tape->constantsAreExact = tape->constantsAreExact || (isfinite(exact->values[k]) && !isFloat(exact->values[k]));
    }
    tape->tables[i] = (TapeTable){*exact, values, length > MOST_WHOLE_FLOAT};
  }
  return tape->tables != NULL;
}

/* The results of all operations for each particle as both of a pair; NULL if there is no memory. */
static double* evaluateAlone(const Tape* tape, const ctPairSet* set, int particleCount) {
  const size_t operations = (size_t)set->operationCount;
  double* numbers = calloc(((size_t)particleCount + 1) * operations, sizeof *numbers);
  for (int i = 0; numbers != NULL && i < particleCount; i++) {
    const double* parameters = set->parameters + (size_t)i * (size_t)set->parametersPerParticle;
    ctPairExpressionEvaluate(&tape->expression, 1, parameters, parameters);
    memcpy(numbers + (size_t)i * operations, tape->expression.results, operations * sizeof *numbers);
  }
  return numbers;
}

static bool makeColumns(Tape* tape, int leafCount) {
  tape->columns = calloc((size_t)tape->columnCount * CT_LEAF_WIDTH * (size_t)leafCount + 1, sizeof *tape->columns);
  return tape->columns != NULL;
}

bool ctTapeCreate(Tape* tape, const ctPairSet* set, int fixedCount, int particleCount, int leafCount,
                  const int* slotOf) {
  TapeGraph graph;
  *tape = (Tape){0};
  double* numbers = NULL;
  if (ctPairExpressionCreate(&tape->expression, set) && makeTables(tape)) {
    numbers = evaluateAlone(tape, set, particleCount);
  }
  bool isMade = false;
  if (numbers != NULL && ctTapeGraphCreate(&graph, set, fixedCount, particleCount, numbers)) {
    isMade = makeSteps(tape, &graph) && makeColumns(tape, leafCount);
    ctTapeGraphFree(&graph);
  }
  free(numbers);
  if (isMade) {
    ctTapeSetParameters(tape, particleCount, slotOf, set->parameters, set->parametersPerParticle);
  } else {
    ctTapeFree(tape);
  }
  return isMade;
}

void ctTapeFree(Tape* tape) {
  for (int i = 0; tape->tables != NULL && i < tape->expression.tableCount; i++) {
    free(tape->tables[i].values);
  }
  free(tape->tables);
  ctPairExpressionFree(&tape->expression);
  free(tape->steps);
  free(tape->scratch);
  free(tape->columnKinds);
  free(tape->columns);
  *tape = (Tape){0};
}
