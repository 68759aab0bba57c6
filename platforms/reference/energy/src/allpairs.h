/* All pairs of an energy: pair sets, and Lennard-Jones and Coulomb or the stand-in in their place. */
#ifndef CT_ALLPAIRS_H_
#define CT_ALLPAIRS_H_

#include "nonbonded.h"
#include "pairset.h"
#include "pairsums.h"
#include "standin.h"
#include "wholeenergy.h"

typedef struct AllPairs {
  TrialLeaves leaves;
  int setCount;
  PairSet* sets;
  Nonbonded nonbonded;
  int sumCount;   /* setCount, or one more */
  PairSums* sums; /* of each pair set, then of nonbonded */
  bool hasStandIn;
  StandIn standIn;   /* instead of nonbonded */
  WholeEnergy whole; /* with a stand-in */
  double nearChange; /* of the last trial, without the stand-in's */
} AllPairs;

/* Pairs are all 0 before. On failure they have to be freed all the same, and errorText (not NULL) says why. */
ctStatus ctAllPairsCreate(AllPairs* pairs, ctChainTree* tree, const ctEnergyDefinition* d, const int* slotOf,
                          char* errorText, size_t errorSize);
void ctAllPairsFree(AllPairs* pairs);

/* Computes everything from the state. */
ctStatus ctAllPairsRefresh(AllPairs* pairs, ctCounts* counts);

/* The energy of the state: of a pair set, and of all other pairs. */
double ctAllPairsSetEnergy(const AllPairs* pairs, int set);
double ctAllPairsEnergy(const AllPairs* pairs);

/* The change of pairs of leaves that are near, then that of the others, see ctPairSumsChange; the first call opens the
 * trial. And the change of near pairs on the way back, see ctGetNearChangeBack. */
ctStatus ctAllPairsChange(AllPairs* pairs, bool near, double* change, ctCounts* counts);
double ctAllPairsNearChangeBack(const AllPairs* pairs);

/* Makes the values of the trial those of the state. False if there is no memory, as for the next two. */
bool ctAllPairsAccept(AllPairs* pairs);

/* Saves a copy of all values; restores it, for the state in which it was saved. */
bool ctAllPairsSave(AllPairs* pairs);
bool ctAllPairsRestore(AllPairs* pairs);

/* Makes the constants of the stand-in the Born sums over far particles in the state, unless one is not finite, given
 * pairs of this state. The pairs have to be refreshed then. On failure the constants are as before. */
ctStatus ctAllPairsRenewFar(AllPairs* pairs);

#endif /* CT_ALLPAIRS_H_ */
