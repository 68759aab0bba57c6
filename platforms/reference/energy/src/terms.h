/* Terms: functions of a few particles, each with what changes it and its value. */
#ifndef CT_TERMS_H_
#define CT_TERMS_H_

#include "trialview.h"

typedef struct Terms Terms;

/* Makes the terms of a checked scene; slotOf[particle] is its slot, or CT_NULL. On failure *terms is NULL and errorText
 * (which may not be NULL) says why. */
ctStatus ctTermsCreate(const ctDefinition* scene, int setCount, const ctTermSet* sets, const int* slotOf, Terms** terms,
                       char* errorText, size_t errorSize);

void ctTermsDestroy(Terms* terms);

/* Computes all values from the positions of leaves in the state. */
void ctTermsRefresh(Terms* terms, const ctChainTree* tree, const ctLeafPositions* state);

int ctTermsSetCount(const Terms* terms);

/* The sum of a set's values; how many of its terms some trial can change. */
double ctTermsSum(const Terms* terms, int set);
int ctTermsCountChangeable(const Terms* terms, int set);

/* By how much a trial changes the sum of all terms. Accepting makes the new values, which last until the next call,
 * those of the state. */
double ctTermsChange(Terms* terms, const TrialView* view);
void ctTermsAccept(Terms* terms);

/* Saves a copy of all values; false if there is no memory. And restores it. */
bool ctTermsSave(Terms* terms);
void ctTermsRestore(Terms* terms);

#endif /* CT_TERMS_H_ */
