/* Pairs: Lennard-Jones and Coulomb of all pairs of particles, summed by pairs of leaves. */
#ifndef CT_PAIRS_H_
#define CT_PAIRS_H_

#include "trialview.h"

typedef struct Pairs Pairs;

/* Makes the pairs of a scene from a checked description; slotOf[particle] is its slot. On failure *pairs is NULL and
 * errorText (which may not be NULL) says why. */
ctStatus ctPairsCreate(ctChainTree* tree, int particleCount, const ctNonbonded* nonbonded, const int* slotOf,
                       Pairs** pairs, char* errorText, size_t errorSize);

void ctPairsDestroy(Pairs* pairs);

/* Computes all sums from the state of the scene. Errors: no memory; the sums are of no state then. */
ctStatus ctPairsRefresh(Pairs* pairs, ctCounts* counts);

/* The sum of all pairs. */
double ctPairsSum(const Pairs* pairs);

/* By how much the open trial changes the pairs of leaves that are near, and those that are not. The first call has to
 * come first. Keeps the new sums until the next trial; accepting, once both were asked for and the scene has committed
 * the trial, makes them those of the state. */
ctStatus ctPairsNearChange(Pairs* pairs, double* change, ctCounts* counts);
double ctPairsOtherChange(Pairs* pairs);
ctStatus ctPairsAccept(Pairs* pairs);

#endif /* CT_PAIRS_H_ */
