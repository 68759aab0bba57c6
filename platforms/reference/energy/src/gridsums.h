/* The sum of a pair set over all pairs of particles, kept by pairs of leaves and of their sections, and by how much
 * trials change it. Where a part of a leaf moves, only that part is computed anew. */
#ifndef CT_GRIDSUMS_H_
#define CT_GRIDSUMS_H_

#include "pairset.h"
#include "sectionsums.h"
#include "trialgrids.h"

/* What a pair of leaves has in the trial. */
typedef struct StagedOnGrid {
  int a;
  int b;
  int kept;        /* where that of the state is; see ctSectionSumsSearch */
  bool isSwapped;  /* rows are of b */
  bool isPartial;  /* of the rows' leaf not all sections were computed */
  uint8_t changed; /* those that were, as bits */
  GridSum computed;
  PairSum sum;
} StagedOnGrid;

/* What of a leaf moves relative to another leaf, which moves as one. */
typedef struct MovingRows {
  int64_t trial;
  int leaf;
  int bodyOfOther;
  bool isSwapped;
  uint8_t sections; /* bits */
  uint16_t numbers; /* of a table */
  unsigned rows;
} MovingRows;

typedef struct GridSums {
  TrialGrids* grids; /* shared with others */
  PairSet* set;
  SectionSums sums;
  SectionSums keptSums;
  int stagedCount;
  int stagedCapacity;
  StagedOnGrid* staged;
  MovingRows lastRows;
  int tableCapacity;
  SectionTable* tables; /* of each that is staged, if it is wanted */
} GridSums;

/* True if a pair set can be summed by these. */
bool ctPairSetFitsGrid(const PairSet* set);

/* False if there is no memory; to be freed all the same. */
bool ctGridSumsCreate(GridSums* sums, TrialGrids* grids, PairSet* set);
void ctGridSumsFree(GridSums* sums);

/* As those of PairSums. */
ctStatus ctGridSumsRefresh(GridSums* sums, size_t count, const ctLeafPair* near);
ctStatus ctGridSumsNearChange(GridSums* sums, double* change);
ctStatus ctGridSumsOtherChange(GridSums* sums, double* change);
bool ctGridSumsAccept(GridSums* sums);
bool ctGridSumsKeep(GridSums* sums);
void ctGridSumsTakeBack(GridSums* sums);

#endif /* CT_GRIDSUMS_H_ */
