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

static bool isSum(const ctOperation* node) {
  return node->kind == ctAddOperator || node->kind == ctSubtractOperator || node->kind == ctMultiplyOperator;
}

/* Which nodes become steps, and which results they need. */
typedef struct Plan {
  const TapeGraph* graph;
  const ctTable* tables;
  int* uses;    /* of each node, by other nodes */
  int* first;   /* the node that is computed first in this one's step, or UNUSED */
  int* lastUse; /* the node whose step uses a result last, or UNUSED: it has no step */
} Plan;

/* The results of other steps that a node needs, and which arguments of its step they are. */
typedef struct Needs {
  int count;
  int nodes[3];
  int places[3];
} Needs;

static void addNeed(Needs* needs, int node, int place) {
  needs->nodes[needs->count] = node;
  needs->places[needs->count++] = place;
}

static int countArguments(const Plan* plan, const ctOperation* node) {
  if (isOfColumns(plan->graph, node)) {
    return 0;
  }
  return node->kind == INVERSE_ROOT_OPERATOR ? 1 : ctArgumentCount(node, plan->tables);
}

static Needs needsOf(const Plan* plan, int i) {
  Needs needs = {0};
  const ctOperation* node = &plan->graph->nodes[i];
  const int first = plan->first[i];
  const ctOperation* begin = first == UNUSED ? node : &plan->graph->nodes[first];
  const int count = countArguments(plan, begin);
  for (int k = 0; k < count; k++) {
    addNeed(&needs, begin->arguments[k], k);
  }
  if (first != UNUSED) {
    addNeed(&needs, node->arguments[node->arguments[0] == first ? 1 : 0], 2);
  }
  return needs;
}

static void countUses(const Plan* plan) {
  plan->uses[plan->graph->root] = 1;
  for (int i = plan->graph->nodeCount - 1; i >= 0; i--) {
    const Needs needs = needsOf(plan, i);
    for (int k = 0; plan->uses[i] > 0 && k < needs.count; k++) {
      plan->uses[needs.nodes[k]]++;
    }
  }
}

/* A result that is used once, by the next sum, difference or product, needs no place. */
static void joinNodes(const Plan* plan) {
  const TapeGraph* graph = plan->graph;
  for (int i = 0; i < graph->nodeCount; i++) {
    const ctOperation* node = &graph->nodes[i];
    for (int k = 0; k < 2 && plan->uses[i] > 0 && isSum(node) && !isOfColumns(graph, node); k++) {
      const int argument = node->arguments[k];
      if (plan->first[i] == UNUSED && plan->uses[argument] == 1 && isSum(&graph->nodes[argument]) &&
          plan->first[argument] == UNUSED) {
        plan->first[i] = argument;
      }
    }
  }
}

/* The result is used after all, and so are squares of distances. */
static void findLastUses(const Plan* plan) {
  const TapeGraph* graph = plan->graph;
  plan->lastUse[graph->root] = graph->nodeCount;
  for (int i = graph->nodeCount - 1; i >= 0; i--) {
    const Needs needs = needsOf(plan, i);
    for (int k = 0; plan->lastUse[i] != UNUSED && k < needs.count; k++) {
      int* last = &plan->lastUse[needs.nodes[k]];
      *last = *last == UNUSED ? i : *last;
    }
    if (graph->nodes[i].kind == ctInputOperator) {
      plan->lastUse[i] = graph->nodeCount;
    }
  }
}

/* False if there is no memory; to be freed all the same. */
static bool makePlan(Plan* plan, const TapeGraph* graph, const ctTable* tables) {
  const size_t count = (size_t)graph->nodeCount;
  *plan = (Plan){.graph = graph,
                 .tables = tables,
                 .uses = calloc(count, sizeof(int)),
                 .first = malloc(count * sizeof(int)),
                 .lastUse = malloc(count * sizeof(int))};
  if (plan->uses == NULL || plan->first == NULL || plan->lastUse == NULL) {
    return false;
  }
  for (size_t i = 0; i < count; i++) {
    plan->first[i] = UNUSED;
    plan->lastUse[i] = UNUSED;
  }
  countUses(plan);
  joinNodes(plan);
  findLastUses(plan);
  return true;
}

static void freePlan(Plan* plan) {
  free(plan->uses);
  free(plan->first);
  free(plan->lastUse);
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
  return (TapeValue){lines->firstBegin + line * MOST_BATCH, CT_LEAF_WIDTH};
}

static void giveBack(Lines* lines, TapeValue value) {
  if (value.step != 0) {
    lines->free[lines->freeCount++] = (value.begin - lines->firstBegin) / MOST_BATCH;
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

static TapeSequel sequelOf(const ctOperation* node, bool isFirst) {
  switch (node->kind) {
    case ctAddOperator:
      return THEN_ADD;
    case ctMultiplyOperator:
      return THEN_MULTIPLY;
    default:
      return isFirst ? THEN_SUBTRACT : THEN_SUBTRACT_FROM;
  }
}

static void addStep(Tape* tape, const Plan* plan, int i, TapeValue* values, Lines* lines) {
  const ctOperation* node = &plan->graph->nodes[i];
  const int first = plan->first[i];
  const ctOperation* begin = first == UNUSED ? node : &plan->graph->nodes[first];
  const Needs needs = needsOf(plan, i);
  TapeStep* step = &tape->steps[tape->stepCount++];
  *step = (TapeStep){.kind = begin->kind};
  step->sequel = first == UNUSED ? NO_SEQUEL : sequelOf(node, node->arguments[0] == first);
  addColumnsToStep(tape, plan->graph, begin, step);
  if (node->kind == ctTableOperator) {
    step->table = &tape->tables[(int)node->constant];
  }
  /* A result may take the place of what is used here for the last time. */
  for (int k = 0; k < needs.count; k++) {
    const int need = needs.nodes[k];
    const bool isRepeated = (k > 0 && need == needs.nodes[0]) || (k > 1 && need == needs.nodes[1]);
    step->arguments[needs.places[k]] = values[need];
    if (plan->lastUse[need] == i && !isRepeated) {
      giveBack(lines, values[need]);
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
  Plan plan;
  const bool isPlanned = makePlan(&plan, graph, tape->expression.tables);
  const int* lastUse = plan.lastUse;
  TapeValue* values = malloc(count * sizeof *values);
  Lines lines = {.free = malloc(count * sizeof *lines.free)};
  tape->steps = malloc(count * sizeof *tape->steps);
  tape->columnKinds = malloc(((size_t)graph->columnCount + 1) * sizeof *tape->columnKinds);
  bool isMade = isPlanned && values != NULL && lines.free != NULL && tape->steps != NULL && tape->columnKinds != NULL;
  if (isMade) {
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
        addStep(tape, &plan, i, values, &lines);
      }
    }
    tape->result = values[graph->root];
    /* Listing pairs may write a row beyond the end. */
    const size_t size = (size_t)lines.firstBegin + (size_t)lines.count * MOST_BATCH + CT_LEAF_WIDTH;
    tape->scratch = allocateLines(size, sizeof *tape->scratch);
    tape->batch = allocateLines(1, sizeof *tape->batch);
    isMade = tape->scratch != NULL && tape->batch != NULL;
  }
  for (int i = 0; isMade && i < graph->nodeCount; i++) {
    if (graph->nodes[i].kind == ctConstantOperator && lastUse[i] != UNUSED) {
      tape->constantsAreExact = tape->constantsAreExact || !isFloat(graph->nodes[i].constant);
      for (int k = 0; k < CT_LEAF_WIDTH; k++) {
        tape->scratch[values[i].begin + k] = (float)graph->nodes[i].constant;
      }
    }
  }
  freePlan(&plan);
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
  const size_t count = (size_t)tape->columnCount * CT_LEAF_WIDTH * (size_t)leafCount;
  tape->columns = allocateLines(count, sizeof *tape->columns);
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
  freeLines(tape->scratch);
  freeLines(tape->batch);
  free(tape->columnKinds);
  freeLines(tape->columns);
  *tape = (Tape){0};
}
