/* The stand-in of ctStandIn: the energy that trials see instead of Lennard-Jones, Coulomb and Born solvation. */
#ifndef CT_STANDIN_H_
#define CT_STANDIN_H_

#include <float.h>
#include <math.h>

#include "born.h"
#include "neighbors.h"
#include "nonbonded.h"
#include "trialleaves.h"

/* What the pairs of a leaf add up to. */
typedef struct StandInLeaf {
  double born[CT_LEAF_WIDTH];     /* Born sums over particles that are near */
  double gradient[CT_LEAF_WIDTH]; /* sums of PairRecord.gradient */
  StandInRadii radii;
  double energy; /* of the particles by themselves, and the first order in what the grid neglects */
} StandInLeaf;

/* What the open trial does to a leaf. */
typedef struct TrialLeaf {
  int64_t stamp;     /* the trial that has touched it; else the rest is of no use */
  unsigned crossing; /* bits: slots whose radius on the grid is another */
} TrialLeaf;

/* A pair of leaves of which the open trial makes another record. */
typedef struct StagedPair {
  int a;
  int b;
  int pair;
  bool isNew;    /* no row has it yet */
  bool isNear;   /* its energy was computed first, with the radii of the state */
  bool isOpen;   /* its energy is not computed yet */
  NearRows rows; /* in the trial */
  PairRecord after;
} StagedPair;

typedef struct StandIn {
  TrialLeaves* leaves; /* shared with others */
  Nonbonded nonbonded; /* columns and exclusions */
  Born born;
  StandInModel model;
  double bornCutoff;
  double pairCutoff;
  int particleCount;
  int* slots;                  /* per particle */
  StandInConstants* constants; /* per leaf */
  StandInLeaf (*leafSums)[2];  /* per leaf: that of the state, and the other one */
  StandInShift (*shifts)[2];
  uint8_t* present; /* per leaf: which of both sums is that of the state */
  uint8_t* presentShift;
  Neighbors neighbors;

  /* The open trial. */
  TrialLeaf* trial; /* per leaf */
  int touchedCount;
  int* touched; /* leaves */
  int stagedCount;
  int stagedCapacity;
  StagedPair* staged; /* those that the trial changes, then those that new radii change */
  int movedCount;     /* how many of them the trial changes */
  double nearChange;
  double nearChangeBack;

  /* A copy of what is kept of the state. */
  bool hasCopy;
  StandInLeaf (*copyOfSums)[2];
  StandInShift (*copyOfShifts)[2];
  uint8_t* copyOfPresent; /* of both */
  Neighbors copyOfNeighbors;
} StandIn;

/* slotOf[particle] is its slot. On failure there is nothing to free and errorText (not NULL) says why. */
ctStatus ctStandInCreate(StandIn* standIn, TrialLeaves* leaves, int particleCount, const ctEnergyDefinition* d,
                         const int* slotOf, char* errorText, size_t errorSize);
void ctStandInFree(StandIn* standIn);

/* Computes everything, given the pairs of leaves that are near in the state. */
ctStatus ctStandInRefresh(StandIn* standIn, size_t count, const ctLeafPair* near);

/* The energy of the state. */
double ctStandInEnergy(const StandIn* standIn);

/* True if a number can be the far part of a Born sum: a finite float. */
static inline bool isFarPart(double number) {
  return fabs(number) <= (double)FLT_MAX;
}

/* Far parts of Born sums, one a particle. Setting them leaves values of no state. */
void ctStandInGetFar(const StandIn* standIn, double* far);
void ctStandInSetFar(StandIn* standIn, const double* far);

/* Born sums of the state over particles that are near, one a particle. */
void ctStandInGetNear(const StandIn* standIn, double* near);

/* As in PairSums. The change of near pairs is that with the radii of the state. */
ctStatus ctStandInNearChange(StandIn* standIn, double* change);
ctStatus ctStandInOtherChange(StandIn* standIn, double* change);
bool ctStandInAccept(StandIn* standIn);

/* Keeps a copy of what is kept of the state, and makes it that again. False if there is no memory, or no copy. */
bool ctStandInSave(StandIn* standIn);
bool ctStandInRestore(StandIn* standIn);

/* ---- What the files of this share ---- */

/* Whatever the open trial took belongs to nobody. */
static inline void dropTrial(StandIn* standIn) {
  standIn->stagedCount = 0;
  standIn->movedCount = 0;
  standIn->touchedCount = 0;
}

/* A leaf in the state, and in the trial. */
static inline StandInLeaf* stateLeaf(const StandIn* standIn, int leaf) {
  return &standIn->leafSums[leaf][standIn->present[leaf]];
}

static inline StandInLeaf* otherLeaf(const StandIn* standIn, int leaf) {
  return &standIn->leafSums[leaf][1 - standIn->present[leaf]];
}

static inline StandInShift* stateShift(const StandIn* standIn, int leaf) {
  return &standIn->shifts[leaf][standIn->presentShift[leaf]];
}

static inline StandInShift* otherShift(const StandIn* standIn, int leaf) {
  return &standIn->shifts[leaf][1 - standIn->presentShift[leaf]];
}

/* A leaf of a pair: where it is, and its radii. */
typedef struct PlacedLeaf {
  int leaf;
  const LeafFrame* frame;
  const StandInRadii* radii;
  const StandInShift* shift;
} PlacedLeaf;

/* The Born sums that two leaves contribute to each other, given which particles of these are near; and their energy
 * with these radii. The record's other part stays. */
void ctStandInComputeBorn(const StandIn* standIn, int a, const LeafFrame* frameA, int b, const LeafFrame* frameB,
                          const NearRows* rows, PairRecord* record);
void ctStandInComputePairs(const StandIn* standIn, const PlacedLeaf* a, const PlacedLeaf* b, const NearRows* rows,
                           PairRecord* record);

/* Exchanges in a record what pairs of some particles of either leaf have with the radii of the state by what they have
 * with these. */
void ctStandInExchangePairs(const StandIn* standIn, const PlacedLeaf* a, unsigned slotsOfA, const PlacedLeaf* b,
                            unsigned slotsOfB, PairRecord* record);

/* A leaf in this frame, with the radii of the state. */
PlacedLeaf ctStandInPlace(const StandIn* standIn, int leaf, const LeafFrame* frame);

/* The radii of a leaf by its sums. */
void ctStandInComputeRadii(const StandIn* standIn, int number, StandInLeaf* leaf);

/* How much wider than said the grid of radii is for a particle with this charge. */
double ctStandInGridFactor(double charge);

/* Finds the functions of two radii whose products add up to what a pair's Coulomb and Born energy, per product of
 * charges and in units of Coulomb's constant, is at the cutoff; and to its derivative by ln B. And sets how that fades
 * within the cutoff. */
void ctStandInFitShift(StandInModel* model, const ctEnergyDefinition* d);

#endif /* CT_STANDIN_H_ */
