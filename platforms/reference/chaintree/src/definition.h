/* Checks what the user described, before anything is built from it. */
#ifndef CT_DEFINITION_H_
#define CT_DEFINITION_H_

#include "chaintree.h"

/* ctSuccess, or a status and a sentence that names the culprit. */
ctStatus ctDefinitionCheck(const ctDefinition* definition, char* errorText, size_t errorSize);

/* The first coordinate that is not finite belongs to this particle; CT_NULL if there is none. */
int ctFindNonFinite(int particleCount, const double* positions);

#endif /* CT_DEFINITION_H_ */
