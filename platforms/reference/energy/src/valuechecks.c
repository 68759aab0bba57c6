#include "valuechecks.h"

#include <math.h>
#include <stdio.h>

#include "pairsetchecks.h"

enum { COORDINATES = 3 };

int ctCountNumbers(const ctValueEnergy* d) {
  return d->parametersPerParticle + d->valueCount + COORDINATES;
}

ctPairSet ctValuePairSet(const ctValueEnergy* d, const ctValueExpression* expression) {
  const int withCoordinates = expression->extent == ctOfParticles ? COORDINATES : 0;
  return (ctPairSet){.operationCount = expression->operationCount,
                     .operations = expression->operations,
                     .tableCount = expression->tableCount,
                     .tables = expression->tables,
                     .parametersPerParticle = d->parametersPerParticle + d->valueCount + withCoordinates};
}

/* False also if numbers of a particle, of two, or of all are too many. */
static bool countsAreValid(const ctValueEnergy* d, int number, int particleCount, char* text, size_t size) {
  const int64_t numbers = (int64_t)d->parametersPerParticle + d->valueCount + COORDINATES;
  if (d->parametersPerParticle < 0 || d->valueCount < 0 || d->termCount < 0 || d->exclusionCount < 0 ||
      d->termCount > CT_MOST_COUNT || d->exclusionCount > CT_MOST_COUNT || numbers > CT_MOST_COUNT ||
      numbers * particleCount > CT_MOST_COUNT) {
    snprintf(text, size, "value energy %d has %d parameters a particle, %d values, %d terms and %d exclusions", number,
             d->parametersPerParticle, d->valueCount, d->termCount, d->exclusionCount);
    return false;
  }
  if ((d->valueCount > 0 && d->values == NULL) || (d->termCount > 0 && d->terms == NULL)) {
    snprintf(text, size, "the values or the terms of value energy %d are NULL", number);
    return false;
  }
  if (!(d->cutoff > 0)) {
    snprintf(text, size, "the cutoff of value energy %d is %g nm, but has to be above 0", number, d->cutoff);
    return false;
  }
  return true;
}

/* Of an expression that can read `valueCount` values. */
static bool expressionIsValid(const ctValueEnergy* d, const ctValueExpression* expression, int valueCount,
                              const char* name, char* text, size_t size) {
  const ctPairSet set = ctValuePairSet(d, expression);
  const bool isOfPairs = expression->extent != ctOfParticles;
  const int each = set.parametersPerParticle;
  if ((int)expression->extent < 0 || expression->extent > ctOfAllPairs) {
    snprintf(text, size, "%s has the unknown extent %d", name, (int)expression->extent);
    return false;
  }
  if (!ctOperationsAreValid(&set, isOfPairs, isOfPairs ? 2 * each : each, name, text, size)) {
    return false;
  }
  for (int i = 0; i < expression->operationCount; i++) {
    const ctOperation* operation = &expression->operations[i];
    if (operation->kind == ctParameterOperator) {
      const int value = operation->arguments[0] % each - d->parametersPerParticle;
      if (value >= valueCount && value < d->valueCount) {
        snprintf(text, size, "operation %d of %s reads value %d, which is not an earlier one", i, name, value);
        return false;
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
    snprintf(text, size, "the parameters or the exclusions of value energy %d are NULL", number);
    return false;
  }
  for (size_t i = 0; i < (size_t)particleCount * each; i++) {
    if (!isfinite(d->parameters[i])) {
      snprintf(text, size, "parameter %d of particle %d of value energy %d is %g", (int)(i % each), (int)(i / each),
               number, d->parameters[i]);
      return false;
    }
  }
  for (int i = 0; i < d->exclusionCount; i++) {
    for (int k = 0; k < 2; k++) {
      const int particle = d->exclusions[i][k];
      if (particle < 0 || particle >= particleCount) {
        snprintf(text, size, "exclusion %d of value energy %d names particle %d, but there are %d particles", i, number,
                 particle, particleCount);
        return false;
      }
    }
  }
  return true;
}

bool ctValueEnergyIsValid(const ctValueEnergy* d, int number, int particleCount, char* text, size_t size) {
  return countsAreValid(d, number, particleCount, text, size) && expressionsAreValid(d, number, text, size) &&
         particlesAreValid(d, number, particleCount, text, size);
}
