/* A sum over all pairs of particles, stored by pairs of leaves, and its change in trials. The summed function is the
 * caller's. */
#ifndef CT_PAIRSUMS_H_
#define CT_PAIRSUMS_H_

#include "leafsums.h"
#include "trialleaves.h"

/* For each of some pairs of leaves the sum over their pairs of particles. */
typedef void LeafPairFunction(const void* model, int count, const FramedPair* pairs, double* sums);

/* The new sum of a pair of leaves that the trial changes. */
typedef struct StagedSum {
  int a;
  int place; /* of the sum of the state, see ctLeafSumsFind */
  LeafKey key;
  double sum;
} StagedSum;

typedef struct PairSums {
  TrialLeaves* leaves; /* shared with others */
  LeafPairFunction* function;
  const void* model;
  double cutoff; /* beyond it, the function is 0; not above the cutoff of the leaves */
  LeafSums sums;
  LeafSums savedSums;
  int stagedCount;
  int stagedCapacity;
  StagedSum* staged;
} PairSums;

/* False if there is no memory. */
bool ctPairSumsCreate(PairSums* pairs, TrialLeaves* leaves, double cutoff, LeafPairFunction* function,
                      const void* model);
void ctPairSumsFree(PairSums* pairs);

/* Computes all sums, given the pairs of leaves that are near in the state. */
ctStatus ctPairSumsRefresh(PairSums* pairs, size_t count, const ctLeafPair* near);

/* By how much the open trial changes pairs of leaves that are near, to be called first, once the leaves have opened the
 * trial; then the change of the others. */
ctStatus ctPairSumsChange(PairSums* pairs, bool near, double* change);

/* Makes the new sums, once both changes were computed, those of the state. False if there is no memory. */
bool ctPairSumsAccept(PairSums* pairs);

/* Saves a copy of all sums; false if there is no memory. And restores it. */
bool ctPairSumsSave(PairSums* pairs);
void ctPairSumsRestore(PairSums* pairs);

#endif /* CT_PAIRSUMS_H_ */
