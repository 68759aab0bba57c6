/* All pair sets of an energy, and the sums that are kept of them. */
#ifndef CT_PAIRSETS_H_
#define CT_PAIRSETS_H_

#include "gridsums.h"
#include "pairsums.h"

typedef struct PairSets {
  int count;
  PairSet* sets;
  bool* areOnGrid; /* of each: which of the two below it has */
  GridSums* gridSums;
  PairSums* sums;
  bool hasGrids;
  TrialGrids grids;
} PairSets;

/* The leaves are found up to the greatest cutoff of the sets. On failure there is nothing to free, and errorText (which
 * may not be NULL) says why. */
ctStatus ctPairSetsCreate(PairSets* sets, TrialLeaves* leaves, const ctDefinition* scene, int count,
                          const ctPairSet* descriptions, const int* slotOf, char* errorText, size_t errorSize);
void ctPairSetsFree(PairSets* sets);

/* As for PairSums, of all sets. */
ctStatus ctPairSetsRefresh(PairSets* sets, size_t count, const ctLeafPair* near);
ctStatus ctPairSetsNearChange(PairSets* sets, double* change);
ctStatus ctPairSetsOtherChange(PairSets* sets, double* change);
/* To be called once the leaves know that the trial is accepted. */
bool ctPairSetsAccept(PairSets* sets);
bool ctPairSetsKeep(PairSets* sets);
void ctPairSetsTakeBack(PairSets* sets);

/* The energy of a set as it is kept. */
double ctPairSetsEnergy(const PairSets* sets, int number);

#endif /* CT_PAIRSETS_H_ */
