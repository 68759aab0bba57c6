#include "pairsetchecks.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "expression.h"

static bool invalid(char* text, size_t size, const char* format, ...) __attribute__((format(printf, 3, 4)));

static bool invalid(char* text, size_t size, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, size, format, arguments);
  va_end(arguments);
  return false;
}

static bool isIndex(int value, int count) {
  return value >= 0 && value < count;
}

static bool countsAreValid(const ctPairSet* set, int number, char* text, size_t size) {
  if (set->operationCount < 1 || set->tableCount < 0 || set->parametersPerParticle < 0 || set->exclusionCount < 0 ||
      set->groupCount < 0) {
    return invalid(
        text, size, "pair set %d has %d operations, %d tables, %d parameters a particle, %d exclusions and %d groups",
        number, set->operationCount, set->tableCount, set->parametersPerParticle, set->exclusionCount, set->groupCount);
  }
  if (set->exclusionCount > CT_MOST_COUNT || set->groupCount > CT_MOST_COUNT) {
    return invalid(text, size, "pair set %d has %d exclusions and %d groups", number, set->exclusionCount,
                   set->groupCount);
  }
  if (!(set->cutoff > 0)) {
    return invalid(text, size, "the cutoff of pair set %d is %g nm, but has to be above 0", number, set->cutoff);
  }
  if (isfinite(set->cutoff) && !(set->switchingDistance > -INFINITY)) {
    return invalid(text, size, "the switching distance of pair set %d is %g nm", number, set->switchingDistance);
  }
  return true;
}

/* True if a table has too many values. */
static bool isTooLarge(const ctTable* table) {
  int64_t count = table->isDiscrete ? 1 : table->dimensions == 1 ? 4 : 16;
  for (int d = 0; d < table->dimensions && count <= CT_MOST_COUNT; d++) {
    count *= table->sizes[d];
  }
  return count > CT_MOST_COUNT;
}

static bool tableIsValid(const ctTable* table, int index, const char* name, char* text, size_t size) {
  if (table->dimensions < 1 || table->dimensions > (table->isDiscrete ? 3 : 2)) {
    return invalid(text, size, "table %d of %s has %d dimensions", index, name, table->dimensions);
  }
  for (int d = 0; d < table->dimensions; d++) {
    if (table->sizes[d] < 1) {
      return invalid(text, size, "table %d of %s has the size %d", index, name, table->sizes[d]);
    }
    if (!table->isDiscrete && !(table->minima[d] < table->maxima[d] && isfinite(table->maxima[d] - table->minima[d]))) {
      return invalid(text, size, "table %d of %s has the range from %g to %g", index, name, table->minima[d],
                     table->maxima[d]);
    }
  }
  if (isTooLarge(table)) {
    return invalid(text, size, "table %d of %s has too many values", index, name);
  }
  return table->values != NULL || invalid(text, size, "table %d of %s has no values", index, name);
}

/* What the operations of an expression can read. */
typedef struct Readable {
  const char* name; /* of the expression */
  bool hasDistance;
  int parameterCount;
} Readable;

static bool operationIsValid(const ctPairSet* set, int i, const Readable* readable, char* text, size_t size) {
  const ctOperation* operation = &set->operations[i];
  const char* name = readable->name;
  const int first = operation->arguments[0];
  if ((int)operation->kind < 0 || operation->kind > ctTableOperator) {
    return invalid(text, size, "operation %d of %s has the unknown operator %d", i, name, (int)operation->kind);
  }
  if (operation->kind == ctInputOperator && !(readable->hasDistance && first == 0)) {
    return invalid(text, size, "operation %d of %s reads input %d; there is %s", i, name, first,
                   readable->hasDistance ? "the distance alone, 0" : "none");
  }
  if (operation->kind == ctParameterOperator && !isIndex(first, readable->parameterCount)) {
    return invalid(text, size, "operation %d of %s reads parameter %d; there are %d", i, name, first,
                   readable->parameterCount);
  }
  if (operation->kind == ctTableOperator && !(operation->constant >= 0 && operation->constant < set->tableCount &&
                                              operation->constant == (int)operation->constant)) {
    return invalid(text, size, "operation %d of %s reads table %g; there are %d", i, name, operation->constant,
                   set->tableCount);
  }
  for (int k = 0; k < ctArgumentCount(operation, set->tables); k++) {
    if (!isIndex(operation->arguments[k], i)) {
      return invalid(text, size, "operation %d of %s needs the result of operation %d, which is not an earlier one", i,
                     name, operation->arguments[k]);
    }
  }
  return true;
}

bool ctOperationsAreValid(const ctPairSet* set, bool hasDistance, int parameterCount, const char* name, char* text,
                          size_t size) {
  const Readable readable = {name, hasDistance, parameterCount};
  if (set->operationCount < 1 || set->operationCount > CT_MOST_OPERATIONS || set->operations == NULL ||
      set->tableCount < 0 || set->tableCount > CT_MOST_COUNT || (set->tableCount > 0 && set->tables == NULL)) {
    return invalid(text, size, "%s has %d operations%s and %d tables%s", name, set->operationCount,
                   set->operations == NULL ? ", which are NULL," : "", set->tableCount,
                   set->tableCount > 0 && set->tables == NULL ? ", which are NULL" : "");
  }
  for (int i = 0; i < set->tableCount; i++) {
    if (!tableIsValid(&set->tables[i], i, name, text, size)) {
      return false;
    }
  }
  for (int i = 0; i < set->operationCount; i++) {
    if (!operationIsValid(set, i, &readable, text, size)) {
      return false;
    }
  }
  return true;
}

static bool parametersAreValid(const ctPairSet* set, int number, int particleCount, char* text, size_t size) {
  if (particleCount > 0 && set->parametersPerParticle > 0 && set->parameters == NULL) {
    return invalid(text, size, "the parameters of pair set %d are NULL", number);
  }
  for (int i = 0; i < particleCount; i++) {
    for (int p = 0; p < set->parametersPerParticle; p++) {
      const double value = set->parameters[(size_t)i * (size_t)set->parametersPerParticle + (size_t)p];
      if (!isfinite(value)) {
        return invalid(text, size, "parameter %d of particle %d of pair set %d is %g", p, i, number, value);
      }
    }
  }
  return true;
}

static bool exclusionsAreValid(const ctPairSet* set, int number, int particleCount, char* text, size_t size) {
  if (set->exclusionCount > 0 && set->exclusions == NULL) {
    return invalid(text, size, "the exclusions of pair set %d are NULL", number);
  }
  for (int i = 0; i < set->exclusionCount; i++) {
    for (int k = 0; k < 2; k++) {
      if (!isIndex(set->exclusions[i][k], particleCount)) {
        return invalid(text, size, "exclusion %d of pair set %d names particle %d, but there are %d particles", i,
                       number, set->exclusions[i][k], particleCount);
      }
    }
  }
  return true;
}

static bool groupIsValid(const ctInteractionGroup* group, int index, int number, int particleCount, const int* slotOf,
                         char* text, size_t size) {
  for (int k = 0; k < 2; k++) {
    if (group->counts[k] < 0 || group->counts[k] > CT_MOST_COUNT ||
        (group->counts[k] > 0 && group->particles[k] == NULL)) {
      return invalid(text, size, "group %d of pair set %d has a set of %d particles%s", index, number, group->counts[k],
                     group->particles[k] == NULL ? ", which is NULL" : "");
    }
    for (int i = 0; i < group->counts[k]; i++) {
      const int particle = group->particles[k][i];
      if (!isIndex(particle, particleCount)) {
        return invalid(text, size, "group %d of pair set %d names particle %d, but there are %d particles", index,
                       number, particle, particleCount);
      }
      if (slotOf[particle] == CT_NULL) {
        return invalid(text, size, "particle %d, which is in group %d of pair set %d, stands in no leaf", particle,
                       index, number);
      }
    }
  }
  return true;
}

bool ctPairSetIsValid(const ctPairSet* set, int number, int particleCount, const int* slotOf, char* text, size_t size) {
  if (!countsAreValid(set, number, text, size)) {
    return false;
  }
  if ((int64_t)set->parametersPerParticle * (particleCount > 2 ? particleCount : 2) > CT_MOST_COUNT) {
    return invalid(text, size, "pair set %d has %d parameters a particle, which are too many", number,
                   set->parametersPerParticle);
  }
  char name[40];
  snprintf(name, sizeof name, "pair set %d", number);
  if (!ctOperationsAreValid(set, true, 2 * set->parametersPerParticle, name, text, size)) {
    return false;
  }
  for (int i = 0; set->groupCount == 0 && i < particleCount; i++) {
    if (slotOf[i] == CT_NULL) {
      return invalid(text, size, "particle %d stands in no leaf", i);
    }
  }
  if (set->groupCount > 0 && set->groups == NULL) {
    return invalid(text, size, "the groups of pair set %d are NULL", number);
  }
  for (int i = 0; i < set->groupCount; i++) {
    if (!groupIsValid(&set->groups[i], i, number, particleCount, slotOf, text, size)) {
      return false;
    }
  }
  return parametersAreValid(set, number, particleCount, text, size) &&
         exclusionsAreValid(set, number, particleCount, text, size);
}
