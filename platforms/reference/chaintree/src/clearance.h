/* How far apart the leaves of a dense scene are at least: what spares a small move the tests of pairs that it cannot
 * bring together.
 *
 * For each pair of leaves it keeps a lower bound of their clearance, the least amount by which two of their particles
 * would have to come nearer to overlap beyond their limit. A trial moves bodies against each other; no particle of a
 * leaf is displaced, as one body sees the other, by more than a bound that follows from where the leaf is. So a pair
 * with more clearance than that bound needs no test. A commit takes the bounds off the clearances of what moved against
 * each other, and puts in what tests have found.
 *
 * That costs O(leaves^2) of very cheap work; the tree costs much dearer work for what is near. Which of them answers is
 * decided by counts of both (never by clocks), so that the same calls give the same method; the verdict is the same. */
#ifndef CT_CLEARANCE_H_
#define CT_CLEARANCE_H_

#include "traverse.h"

/* Clearances are kept in whole units, 0 up to this. */
enum { MOST_CLEARANCE = UINT16_MAX };

/* Pairs of a leaf with sixteen in a row that the open trial has tested. */
typedef struct TestedPairs {
  int a;
  int first;                      /* of the sixteen */
  unsigned left;                  /* bits: those that their spheres leave in doubt */
  unsigned soon;                  /* bits: those of them that are likely to clash */
  uint16_t clearance[TREE_WIDTH]; /* in the trial; 0: not known */
} TestedPairs;

/* Pairs of a leaf with COLUMNS_AT_ONCE in a row whose clearance the open trial may use up. */
typedef struct NearPairs {
  int a;
  int first;
  uint32_t columns; /* bits */
} NearPairs;

/* Leaves that move as one. A leaf in which two pieces of a view meet belongs to both; one in which more do is a body of
 * its own, with several pieces. */
typedef struct LeafRun {
  int begin; /* leaves */
  int end;
  int firstPiece;
  int lastPiece;
} LeafRun;

/* So many clearances of a row are compared at a time. */
enum { COLUMNS_AT_ONCE = 32 };

/* Who tests trials. */
typedef enum TrialMethod {
  byCost, /* whichever costs less */
  byTree,
  byTreeAndBoxes, /* those at all visits */
  byClearances
} TrialMethod;

typedef struct Clearance {
  TrialMethod method;
  bool isKept; /* the clearances are of the state */
  Arena arena; /* of the arrays that follow, which are made when first asked for */
  int leafCount;
  int stride;      /* of a row, a multiple of COLUMNS_AT_ONCE */
  uint16_t* least; /* leafCount rows; of leaves a < b in row a, column b */
  uint16_t* shift; /* per leaf, with padding: a bound of how far two bodies displace it, in units */
  float unit;      /* nm */
  NearPairs* near; /* scratch: of the rows of a node */
  LeafRun* runs;   /* of a view, ascending */
  int runCount;
  int runCapacity;
  TestedPairs* tested; /* of the open trial */
  int testedCount;
  int testedCapacity;

  /* The choice, made after each round of trials. Costs are in units of about a nanosecond. */
  int64_t cost;      /* of this round */
  int trials;        /* of this round */
  int64_t treeCost;  /* of a test by the tree, as last measured */
  int64_t mostCost;  /* of a test by clearances before it gives up */
  bool measuresTree; /* this round is by the tree, only to know that */
  int rounds;        /* by clearances since they came into use or the tree was measured */
  int patience;      /* rounds by the tree after clearances have not paid */
  int wait;          /* of those left */
} Clearance;

/* Receives a pair whose spheres may overlap beyond their limit and whether they are of different bodies. Returns their
 * clearance in nm, below 0 if they do. */
typedef double ClearanceFunction(void* context, int slotA, int slotB, double squaredDistance, bool ofTwoBodies);

/* What a test by clearances returns instead of its cost if that is out of proportion, or if there is no memory for what
 * it finds: it has no verdict. */
enum { GAVE_UP = -1 };

/* Whether the next test should go by clearances; if so they are of the state. `reach` is that of views. */
bool ctClearanceIsWanted(Clearance* clearance, Traversal* traversal, double reach);

/* Adds what a test, or else a commit, has cost. */
void ctClearanceCharge(Clearance* clearance, int64_t cost, bool isTest);

/* Clearances don't pay here: back to the tree, for longer each time. */
void ctClearanceGiveUp(Clearance* clearance);

/* From the environment, see ctCreate. */
TrialMethod ctChooseTrialMethod(void);

/* Something but a commit has changed the state or the limits. */
void ctClearanceForget(Clearance* clearance);

void ctClearanceFree(Clearance* clearance);

#endif /* CT_CLEARANCE_H_ */
