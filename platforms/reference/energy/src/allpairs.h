/* All pairs of an energy: Lennard-Jones and Coulomb, or the stand-in in their place, and pair sets. */
#ifndef CT_ALLPAIRS_H_
#define CT_ALLPAIRS_H_

#include "nonbonded.h"
#include "pairsets.h"
#include "standin.h"
#include "wholeenergy.h"

typedef struct AllPairs {
  TrialLeaves leaves;
  bool hasNonbonded;
  Nonbonded nonbonded;
  PairSums sums; /* of nonbonded */
  bool hasStandIn;
  StandIn standIn;   /* instead of nonbonded */
  WholeEnergy whole; /* with a stand-in */
  PairSets sets;
  double nearChange; /* of the last trial, but for that of the stand-in */
} AllPairs;

/* Pairs are all 0 before. On failure they have to be freed all the same, and errorText (not NULL) says why. */
ctStatus ctAllPairsCreate(AllPairs* pairs, ctChainTree* tree, const ctEnergyDefinition* d, const int* slotOf,
                          char* errorText, size_t errorSize);
void ctAllPairsFree(AllPairs* pairs);

/* Computes everything from the state. */
ctStatus ctAllPairsRefresh(AllPairs* pairs, ctCounts* counts);

/* The energy of the state, but for pair sets. */
double ctAllPairsEnergy(const AllPairs* pairs);

/* As in PairSums; the first call opens the trial. And the change of near pairs on the way back, see
 * ctGetNearChangeBack. */
ctStatus ctAllPairsNearChange(AllPairs* pairs, double* change, ctCounts* counts);
ctStatus ctAllPairsOtherChange(AllPairs* pairs, double* change);
double ctAllPairsNearChangeBack(const AllPairs* pairs);
bool ctAllPairsAccept(AllPairs* pairs);

/* Keeps a copy of all values, and makes them the values of a state that has become that of then. False if there is no
 * memory. */
bool ctAllPairsKeep(AllPairs* pairs);
bool ctAllPairsTakeBack(AllPairs* pairs);

/* Makes the constants of the stand-in what the state has far away, unless that is not finite, given pairs that are of
 * this state. The others are of no state then. On failure the constants are as before. */
ctStatus ctAllPairsRenewFar(AllPairs* pairs);

#endif /* CT_ALLPAIRS_H_ */
