/* All pair sets of an energy, and the sums that are kept of them. */
#ifndef CT_PAIRSETS_H_
#define CT_PAIRSETS_H_

#include "pairset.h"
#include "pairsums.h"

typedef struct PairSets {
  int count;
  PairSet* sets;
  PairSums* sums; /* of each */
} PairSets;

/* The leaves are found up to the greatest cutoff of the sets. On failure there is nothing to free, and errorText (which
 * may not be NULL) says why. */
ctStatus ctPairSetsCreate(PairSets* sets, TrialLeaves* leaves, int particleCount, int count,
                          const ctPairSet* descriptions, const int* slotOf, char* errorText, size_t errorSize);
void ctPairSetsFree(PairSets* sets);

/* As for PairSums, of all sets. */
ctStatus ctPairSetsRefresh(PairSets* sets, size_t count, const ctLeafPair* near);
ctStatus ctPairSetsNearChange(PairSets* sets, double* change);
ctStatus ctPairSetsOtherChange(PairSets* sets, double* change);
bool ctPairSetsAccept(PairSets* sets);
bool ctPairSetsKeep(PairSets* sets);
void ctPairSetsTakeBack(PairSets* sets);

#endif /* CT_PAIRSETS_H_ */
