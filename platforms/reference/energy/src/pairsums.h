/* A sum over all pairs of particles, kept by pairs of leaves, and by how much trials change it. What is summed is
 * another's. */
#ifndef CT_PAIRSUMS_H_
#define CT_PAIRSUMS_H_

#include "leafsums.h"
#include "trialleaves.h"

/* For each of some pairs of leaves the sum over their pairs of particles. */
typedef void LeafPairFunction(const void* model, int count, const FramedPair* pairs, double* sums);

/* The new sum of a pair of leaves that the trial changes. */
typedef struct StagedSum {
  int a;
  int b;
  int kept; /* where the sum of the state is; see ctLeafSumsFind */
  double sum;
} StagedSum;

typedef struct PairSums {
  TrialLeaves* leaves; /* shared with others */
  LeafPairFunction* function;
  const void* model;
  double cutoff; /* of the function: beyond it is 0; not above that of the leaves */
  LeafSums sums;
  LeafSums keptSums;
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

/* By how much the open trial changes pairs of leaves that are near, and those that are not. The first call has to come
 * first, once the leaves have opened the trial. Keeps the new sums until the next trial; accepting, once both were
 * asked for, makes them those of the state. Accepting is false if there is no memory. */
ctStatus ctPairSumsNearChange(PairSums* pairs, double* change);
ctStatus ctPairSumsOtherChange(PairSums* pairs, double* change);
bool ctPairSumsAccept(PairSums* pairs);

/* Keeps a copy of all sums, or makes the copy the sums. Keeping is false if there is no memory. */
bool ctPairSumsKeep(PairSums* pairs);
void ctPairSumsTakeBack(PairSums* pairs);

#endif /* CT_PAIRSUMS_H_ */
