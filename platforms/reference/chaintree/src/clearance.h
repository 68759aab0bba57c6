/* Clearances: lower bounds of how far apart leaves are. They save a small move the tests of pairs that it cannot bring
 * together. The clearance of two leaves is the least amount by which two of their particles would have to come nearer
 * to overlap beyond their limit. A table keeps a lower bound of it for each pair of leaves. A trial moves runs of
 * leaves against each other. The displacement of a leaf in the frame of another run has a bound that follows from its
 * position. A pair with more clearance than that bound needs no test. When a trial is accepted, these bounds are
 * subtracted from the clearances of leaves that moved against each other, and what tests have found is entered.
 *
 * A test by clearances costs O(leaves^2) very cheap steps; a test by the tree costs fewer and dearer ones. Counts of
 * both, never clocks, choose between them, so equal calls take equal ways. The verdict is the same. */
#ifndef CT_CLEARANCE_H_
#define CT_CLEARANCE_H_

#include "traverse.h"

/* Clearances are whole numbers of Clearance.unit, 0 up to this. */
enum { MOST_CLEARANCE = UINT16_MAX };

/* Pairs of a leaf with sixteen consecutive ones that the open trial has tested. */
typedef struct TestedPairs {
  int a;
  int first;                      /* of the sixteen */
  unsigned left;                  /* bits: pairs whose spheres are too near to decide */
  unsigned soon;                  /* bits: pairs among these that are likely to clash, to be tested first */
  uint16_t clearance[TREE_WIDTH]; /* in the trial; 0: not known */
} TestedPairs;

/* Pairs of a leaf with COLUMNS_AT_ONCE consecutive ones that the open trial may bring together. */
typedef struct NearPairs {
  int a;
  int first;
  uint32_t columns; /* bits */
} NearPairs;

/* Consecutive leaves of one piece of a view. A leaf in which two pieces meet belongs to the runs of both. A leaf in
 * which more meet is a run of its own, of many pieces. */
typedef struct LeafRun {
  int begin; /* leaves */
  int end;
  int firstPiece;
  int lastPiece; /* after the first: the run is a leaf of many pieces */
} LeafRun;

/* Two runs of leaves that move against each other. */
typedef struct RunPair {
  int beginA; /* leaves */
  int endA;
  int bodyA;
  int beginB;
  int endB;
  int bodyB;
  float back[12]; /* A's motion in the frame of B, if both are of one piece: moves A from the world */
} RunPair;

/* Most pairs of runs whose bounds a test keeps until its trial is accepted. Eight torsions of a backbone in a row have
 * some eight such pairs. */
enum { MOST_BOUND_PAIRS = 64 };

/* Clearances of a row that are compared at a time. */
enum { COLUMNS_AT_ONCE = 32 };

typedef struct Clearance {
  bool isKept; /* the table is of the state */
  Arena arena; /* of the arrays below, which are made when first needed */
  int leafCount;
  int stride;      /* of a row, a multiple of COLUMNS_AT_ONCE */
  uint16_t* least; /* leafCount rows; of leaves a < b in row a, column b */
  uint16_t*
      displacements; /* MOST_BOUND_PAIRS rows: of each leaf the bound of its displacement between two runs, in units */
  uint16_t* displacement; /* the row of the current pair */
  float unit;             /* nm */
  double skipped;         /* nm: clearances may be too large by this */
  NearPairs* near;        /* scratch: of the rows of an inner node */
  LeafRun* runs;          /* of a view, ascending */
  int runCount;
  int runCapacity;
  RunPair* boundPairs;      /* whose bounds `shifts` holds */
  int boundPairCount;       /* may be more: then it does not hold all */
  int64_t testedTrial;      /* whose tests these are; the number of the trial */
  const Piece* boundPieces; /* of the open trial, if those are all pairs of their runs; else NULL */
  TestedPairs* tested;      /* of the open trial */
  int testedCount;
  int testedCapacity;

  /* The choice, made after each round of trials. Costs are in the units of costs.h. */
  int64_t cost;      /* of this round */
  int trials;        /* of this round */
  int64_t treeCost;  /* of a test by the tree, as last measured */
  int64_t mostCost;  /* most cost of a test by clearances before it gives up */
  bool measuresTree; /* this round is by the tree, only to measure treeCost */
  int rounds;        /* by clearances, since the tree was last measured */
  int patience;      /* rounds by the tree when next clearances do not pay */
  int wait;          /* rounds by the tree that are left */
} Clearance;

/* Receives a pair whose spheres may overlap beyond their limit, and whether it is of two rigid bodies. Returns its
 * clearance in nm, below 0 if it clashes. */
typedef double ClearanceFunction(void* context, int slotA, int slotB, double squaredDistance, bool ofTwoBodies);

/* Returned by a test by clearances instead of its cost if it is undecided: it cost too much, or had no memory. */
enum { GAVE_UP = -1 };

/* Drops what tests have found. */
void ctClearanceDropTests(Clearance* clearance);

/* True if the next test should be by clearances; then the table is of the state. `reach` is that of its view.
 * `isAlone`: there is no descent to compare the cost with. */
bool ctClearanceIsWanted(Clearance* clearance, Traversal* traversal, double reach, bool isAlone);

/* Adds the cost of a test or of accepting a trial. */
void ctClearanceCharge(Clearance* clearance, int64_t cost, bool isTest);

/* Returns to the tree, for longer each time, since clearances do not pay. */
void ctClearanceGiveUp(Clearance* clearance);

/* Adds by how much an accepted trial may change clearances of pairs that it skips. */
void ctClearanceSkip(Clearance* clearance, double distanceError);

/* Call after a change other than accept, and after a change of limits: the table is no longer of the state. */
void ctClearanceForget(Clearance* clearance);

void ctClearanceFree(Clearance* clearance);

#endif /* CT_CLEARANCE_H_ */
