/* What has to hold of the description of a value energy. */
#ifndef CT_VALUECHECKS_H_
#define CT_VALUECHECKS_H_

#include "ctenergy.h"

/* The expression as a pair set, of which only operations, tables and the count of parameters are set: these are the
 * numbers that it can read of a particle. */
ctPairSet ctValuePairSet(const ctValueEnergy* d, const ctValueExpression* expression);

/* How many numbers each particle has: parameters, values and coordinates. */
int ctCountNumbers(const ctValueEnergy* d);

/* True if nothing is wrong with value energy `number`; else text, of `size` bytes, says what is. */
bool ctValueEnergyIsValid(const ctValueEnergy* d, int number, int particleCount, char* text, size_t size);

#endif /* CT_VALUECHECKS_H_ */
