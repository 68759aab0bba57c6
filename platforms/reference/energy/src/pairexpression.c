#include "pairexpression.h"

#include <stdlib.h>
#include <string.h>

#include "expression.h"
#include "pairtable.h"

/* ---- Life ---- */

static bool copyTables(PairExpression* expression, const ctPairSet* set) {
  expression->tables = calloc((size_t)set->tableCount + 1, sizeof *expression->tables);
  if (expression->tables == NULL) {
    return false;
  }
  for (int i = 0; i < set->tableCount; i++) {
    const size_t size = tableLength(&set->tables[i]) * sizeof(double);
    double* values = malloc(size);
    if (values == NULL) {
      return false;
    }
    memcpy(values, set->tables[i].values, size);
    expression->tables[i] = set->tables[i];
    expression->tables[i].values = values;
    expression->tableCount++;
  }
  return true;
}

bool ctPairExpressionCreate(PairExpression* expression, const ctPairSet* set) {
  *expression = (PairExpression){
      .operationCount = set->operationCount,
      .operations = ctCopyOperations(set->operations, set->operationCount, set->tables),
      .parametersPerParticle = set->parametersPerParticle,
      .results = calloc((size_t)set->operationCount, sizeof *expression->results),
  };
  if (expression->operations == NULL || expression->results == NULL || !copyTables(expression, set)) {
    ctPairExpressionFree(expression);
    return false;
  }
  return true;
}

void ctPairExpressionFree(PairExpression* expression) {
  for (int i = 0; i < expression->tableCount; i++) {
    free((void*)expression->tables[i].values);
  }
  free(expression->tables);
  free(expression->operations);
  free(expression->results);
  *expression = (PairExpression){0};
}

/* ---- Evaluation ---- */

double ctPairExpressionEvaluate(const PairExpression* expression, double distance, const double* first,
                                const double* second) {
  const int each = expression->parametersPerParticle;
  double* results = expression->results;
  for (int i = 0; i < expression->operationCount; i++) {
    const ctOperation* operation = &expression->operations[i];
    const int* n = operation->arguments;
    if (operation->kind == ctInputOperator) {
      results[i] = distance;
    } else if (operation->kind == ctParameterOperator) {
      results[i] = n[0] < each ? first[n[0]] : second[n[0] - each];
    } else if (operation->kind == ctTableOperator) {
      const ctTable* table = &expression->tables[(int)operation->constant];
      results[i] = tableValue(table, results[n[0]], results[n[1]], results[n[2]]);
    } else {
      results[i] = ctOperate(operation, results[n[0]], results[n[1]], results[n[2]]);
    }
  }
  return results[expression->operationCount - 1];
}
