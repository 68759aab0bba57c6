#include "checks.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "expression.h"
#include "valueenergy.h"

bool ctInvalid(char* text, size_t size, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, size, format, arguments);
  va_end(arguments);
  return false;
}

static bool isIndex(int value, int count) {
  return value >= 0 && value < count;
}

/* ---- Operations ---- */

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
    return ctInvalid(text, size, "table %d of %s has %d dimensions", index, name, table->dimensions);
  }
  for (int d = 0; d < table->dimensions; d++) {
    if (table->sizes[d] < 1) {
      return ctInvalid(text, size, "table %d of %s has the size %d", index, name, table->sizes[d]);
    }
    if (!table->isDiscrete && !(table->minima[d] < table->maxima[d] && isfinite(table->maxima[d] - table->minima[d]))) {
      return ctInvalid(text, size, "table %d of %s has the range from %g to %g", index, name, table->minima[d],
                       table->maxima[d]);
    }
  }
  if (isTooLarge(table)) {
    return ctInvalid(text, size, "table %d of %s has too many values", index, name);
  }
  return table->values != NULL || ctInvalid(text, size, "table %d of %s has no values", index, name);
}

static bool operationIsValid(const Operations* o, int i, char* text, size_t size) {
  const ctOperation* operation = &o->operations[i];
  const int first = operation->arguments[0];
  if ((int)operation->kind < 0 || operation->kind > ctTableOperator) {
    return ctInvalid(text, size, "operation %d of %s has the unknown operator %d", i, o->name, (int)operation->kind);
  }
  if (operation->kind == ctInputOperator && !isIndex(first, o->inputCount)) {
    return ctInvalid(text, size, "operation %d of %s reads input %d; there are %d", i, o->name, first, o->inputCount);
  }
  if (operation->kind == ctParameterOperator && !isIndex(first, o->parameterCount)) {
    return ctInvalid(text, size, "operation %d of %s reads parameter %d; there are %d", i, o->name, first,
                     o->parameterCount);
  }
  if (operation->kind == ctTableOperator && !(operation->constant >= 0 && operation->constant < o->tableCount &&
                                              operation->constant == (int)operation->constant)) {
    return ctInvalid(text, size, "operation %d of %s reads table %g; there are %d", i, o->name, operation->constant,
                     o->tableCount);
  }
  if (operation->kind == ctImageLengthOperator && !o->isOfTerms) {
    return ctInvalid(text, size, "operation %d of %s is a length in nearest images, which only terms have", i, o->name);
  }
  for (int k = 0; k < ctArgumentCount(operation, o->tables); k++) {
    if (!isIndex(operation->arguments[k], i)) {
      return ctInvalid(text, size, "operation %d of %s needs the result of operation %d, which is not an earlier one",
                       i, o->name, operation->arguments[k]);
    }
  }
  return true;
}

bool ctOperationsAreValid(const Operations* o, char* text, size_t size) {
  if (o->operationCount < 1 || o->operationCount > CT_MOST_OPERATIONS || o->operations == NULL || o->tableCount < 0 ||
      o->tableCount > CT_MOST_COUNT || (o->tableCount > 0 && o->tables == NULL)) {
    return ctInvalid(text, size, "%s has %d operations%s and %d tables%s", o->name, o->operationCount,
                     o->operations == NULL ? ", which are NULL," : "", o->tableCount,
                     o->tableCount > 0 && o->tables == NULL ? ", which are NULL" : "");
  }
  for (int i = 0; i < o->tableCount; i++) {
    if (!tableIsValid(&o->tables[i], i, o->name, text, size)) {
      return false;
    }
  }
  for (int i = 0; i < o->operationCount; i++) {
    if (!operationIsValid(o, i, text, size)) {
      return false;
    }
  }
  return true;
}

/* ---- Pair sets ---- */

static bool pairCountsAreValid(const ctPairSet* set, int number, char* text, size_t size) {
  if (set->operationCount < 1 || set->tableCount < 0 || set->parametersPerParticle < 0 || set->exclusionCount < 0 ||
      set->groupCount < 0) {
    return ctInvalid(
        text, size, "pair set %d has %d operations, %d tables, %d parameters a particle, %d exclusions and %d groups",
        number, set->operationCount, set->tableCount, set->parametersPerParticle, set->exclusionCount, set->groupCount);
  }
  if (set->exclusionCount > CT_MOST_COUNT || set->groupCount > CT_MOST_COUNT) {
    return ctInvalid(text, size, "pair set %d has %d exclusions and %d groups", number, set->exclusionCount,
                     set->groupCount);
  }
  if (!(set->cutoff > 0)) {
    return ctInvalid(text, size, "the cutoff of pair set %d is %g nm, but has to be above 0", number, set->cutoff);
  }
  if (isfinite(set->cutoff) && !(set->switchingDistance > -INFINITY)) {
    return ctInvalid(text, size, "the switching distance of pair set %d is %g nm", number, set->switchingDistance);
  }
  return true;
}

static bool parametersAreValid(const ctPairSet* set, int number, int particleCount, char* text, size_t size) {
  if (particleCount > 0 && set->parametersPerParticle > 0 && set->parameters == NULL) {
    return ctInvalid(text, size, "the parameters of pair set %d are NULL", number);
  }
  for (int i = 0; i < particleCount; i++) {
    for (int p = 0; p < set->parametersPerParticle; p++) {
      const double value = set->parameters[(size_t)i * (size_t)set->parametersPerParticle + (size_t)p];
      if (!isfinite(value)) {
        return ctInvalid(text, size, "parameter %d of particle %d of pair set %d is %g", p, i, number, value);
      }
    }
  }
  return true;
}

static bool exclusionsAreValid(const ctPairSet* set, int number, int particleCount, char* text, size_t size) {
  if (set->exclusionCount > 0 && set->exclusions == NULL) {
    return ctInvalid(text, size, "the exclusions of pair set %d are NULL", number);
  }
  for (int i = 0; i < set->exclusionCount; i++) {
    for (int k = 0; k < 2; k++) {
      if (!isIndex(set->exclusions[i][k], particleCount)) {
        return ctInvalid(text, size, "exclusion %d of pair set %d names particle %d, but there are %d particles", i,
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
      return ctInvalid(text, size, "group %d of pair set %d has a set of %d particles%s", index, number,
                       group->counts[k], group->particles[k] == NULL ? ", which is NULL" : "");
    }
    for (int i = 0; i < group->counts[k]; i++) {
      const int particle = group->particles[k][i];
      if (!isIndex(particle, particleCount)) {
        return ctInvalid(text, size, "group %d of pair set %d names particle %d, but there are %d particles", index,
                         number, particle, particleCount);
      }
      if (slotOf[particle] == CT_NULL) {
        return ctInvalid(text, size, "particle %d, which is in group %d of pair set %d, stands in no leaf", particle,
                         index, number);
      }
    }
  }
  return true;
}

bool ctPairSetIsValid(const ctPairSet* set, int number, int particleCount, const int* slotOf, char* text, size_t size) {
  if (!pairCountsAreValid(set, number, text, size)) {
    return false;
  }
  if ((int64_t)set->parametersPerParticle * (particleCount > 2 ? particleCount : 2) > CT_MOST_COUNT) {
    return ctInvalid(text, size, "pair set %d has %d parameters a particle, which are too many", number,
                     set->parametersPerParticle);
  }
  char name[40];
  snprintf(name, sizeof name, "pair set %d", number);
  const Operations operations = {.name = name,
                                 .operationCount = set->operationCount,
                                 .operations = set->operations,
                                 .inputCount = 1,
                                 .parameterCount = 2 * set->parametersPerParticle,
                                 .tableCount = set->tableCount,
                                 .tables = set->tables};
  if (!ctOperationsAreValid(&operations, text, size)) {
    return false;
  }
  for (int i = 0; set->groupCount == 0 && i < particleCount; i++) {
    if (slotOf[i] == CT_NULL) {
      return ctInvalid(text, size, "particle %d stands in no leaf", i);
    }
  }
  if (set->groupCount > 0 && set->groups == NULL) {
    return ctInvalid(text, size, "the groups of pair set %d are NULL", number);
  }
  for (int i = 0; i < set->groupCount; i++) {
    if (!groupIsValid(&set->groups[i], i, number, particleCount, slotOf, text, size)) {
      return false;
    }
  }
  return parametersAreValid(set, number, particleCount, text, size) &&
         exclusionsAreValid(set, number, particleCount, text, size);
}

/* ---- Value energies ---- */

/* False also if numbers of a particle, of two, or of all are too many. */
static bool valueCountsAreValid(const ctValueEnergy* d, int number, int particleCount, char* text, size_t size) {
  const int64_t numbers = (int64_t)d->parametersPerParticle + d->valueCount + COORDINATES;
  if (d->parametersPerParticle < 0 || d->valueCount < 0 || d->termCount < 0 || d->exclusionCount < 0 ||
      d->termCount > CT_MOST_COUNT || d->exclusionCount > CT_MOST_COUNT || numbers > CT_MOST_COUNT ||
      numbers * particleCount > CT_MOST_COUNT) {
    return ctInvalid(text, size, "value energy %d has %d parameters a particle, %d values, %d terms and %d exclusions",
                     number, d->parametersPerParticle, d->valueCount, d->termCount, d->exclusionCount);
  }
  if ((d->valueCount > 0 && d->values == NULL) || (d->termCount > 0 && d->terms == NULL)) {
    return ctInvalid(text, size, "the values or the terms of value energy %d are NULL", number);
  }
  if (!(d->cutoff > 0)) {
    return ctInvalid(text, size, "the cutoff of value energy %d is %g nm, but has to be above 0", number, d->cutoff);
  }
  return true;
}

/* Of an expression that can read `valueCount` values. */
static bool expressionIsValid(const ctValueEnergy* d, const ctValueExpression* expression, int valueCount,
                              const char* name, char* text, size_t size) {
  const bool isOfPairs = expression->extent != ctOfParticles;
  const int each = countReadable(d, expression->extent);
  if ((int)expression->extent < 0 || expression->extent > ctOfAllPairs) {
    return ctInvalid(text, size, "%s has the unknown extent %d", name, (int)expression->extent);
  }
  const Operations operations = {.name = name,
                                 .operationCount = expression->operationCount,
                                 .operations = expression->operations,
                                 .inputCount = isOfPairs ? 1 : 0,
                                 .parameterCount = isOfPairs ? 2 * each : each,
                                 .tableCount = expression->tableCount,
                                 .tables = expression->tables};
  if (!ctOperationsAreValid(&operations, text, size)) {
    return false;
  }
  for (int i = 0; i < expression->operationCount; i++) {
    const ctOperation* operation = &expression->operations[i];
    if (operation->kind == ctParameterOperator) {
      const int value = operation->arguments[0] % each - d->parametersPerParticle;
      if (value >= valueCount && value < d->valueCount) {
        return ctInvalid(text, size, "operation %d of %s reads value %d, which is not an earlier one", i, name, value);
      }
    }
  }
  return true;
}

static bool expressionsAreValid(const ctValueEnergy* d, int number, char* text, size_t size) {
  char name[60];
  for (int i = 0; i < d->valueCount; i++) {
    snprintf(name, sizeof name, "value %d of value energy %d", i, number);
    if (!expressionIsValid(d, &d->values[i], i, name, text, size)) {
      return false;
    }
  }
  for (int i = 0; i < d->termCount; i++) {
    snprintf(name, sizeof name, "term %d of value energy %d", i, number);
    if (!expressionIsValid(d, &d->terms[i], d->valueCount, name, text, size)) {
      return false;
    }
  }
  return true;
}

static bool particlesAreValid(const ctValueEnergy* d, int number, int particleCount, char* text, size_t size) {
  const size_t each = (size_t)d->parametersPerParticle;
  if ((particleCount > 0 && each > 0 && d->parameters == NULL) || (d->exclusionCount > 0 && d->exclusions == NULL)) {
    return ctInvalid(text, size, "the parameters or the exclusions of value energy %d are NULL", number);
  }
  for (size_t i = 0; i < (size_t)particleCount * each; i++) {
    if (!isfinite(d->parameters[i])) {
      return ctInvalid(text, size, "parameter %d of particle %d of value energy %d is %g", (int)(i % each),
                       (int)(i / each), number, d->parameters[i]);
    }
  }
  for (int i = 0; i < d->exclusionCount; i++) {
    for (int k = 0; k < 2; k++) {
      const int particle = d->exclusions[i][k];
      if (particle < 0 || particle >= particleCount) {
        return ctInvalid(text, size, "exclusion %d of value energy %d names particle %d, but there are %d particles", i,
                         number, particle, particleCount);
      }
    }
  }
  return true;
}

bool ctValueEnergyIsValid(const ctValueEnergy* d, int number, int particleCount, char* text, size_t size) {
  return valueCountsAreValid(d, number, particleCount, text, size) && expressionsAreValid(d, number, text, size) &&
         particlesAreValid(d, number, particleCount, text, size);
}
