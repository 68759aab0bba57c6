/* What has to hold of the description of a pair set. */
#ifndef CT_PAIRSETCHECKS_H_
#define CT_PAIRSETCHECKS_H_

#include "ctenergy.h"

/* True if nothing is wrong with pair set `number`; else text, of `size` bytes, says what is. slotOf[particle] is its
 * slot, or CT_NULL. */
bool ctPairSetIsValid(const ctPairSet* set, int number, int particleCount, const int* slotOf, char* text, size_t size);

/* The same of its operations and tables alone, which are those of `name`, as text has it. Input 0 is the only one if
 * `hasDistance`, else there is none; operations read `parameterCount` parameters. */
bool ctOperationsAreValid(const ctPairSet* set, bool hasDistance, int parameterCount, const char* name, char* text,
                          size_t size);

#endif /* CT_PAIRSETCHECKS_H_ */
