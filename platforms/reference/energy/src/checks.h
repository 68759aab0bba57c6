/* What has to hold of descriptions. Each check is true if nothing is wrong; else text, of `size` bytes, says what is.
 */
#ifndef CT_CHECKS_H_
#define CT_CHECKS_H_

#include "ctenergy.h"

/* Writes the text and returns false. */
bool ctInvalid(char* text, size_t size, const char* format, ...) __attribute__((format(printf, 3, 4)));

/* The operations of an expression, and how much they can read. */
typedef struct Operations {
  const char* name; /* of the expression, for the text */
  int operationCount;
  const ctOperation* operations;
  int inputCount;
  int parameterCount;
  int tableCount;
  const ctTable* tables;
  bool isOfTerms;
} Operations;

bool ctOperationsAreValid(const Operations* operations, char* text, size_t size);

/* Pair set and value energy `number`; slotOf[particle] is its slot, or CT_NULL. */
bool ctPairSetIsValid(const ctPairSet* set, int number, int particleCount, const int* slotOf, char* text, size_t size);
bool ctValueEnergyIsValid(const ctValueEnergy* energy, int number, int particleCount, char* text, size_t size);

#endif /* CT_CHECKS_H_ */
