/* The stand-in of ctStandIn: the energy that trials see instead of Lennard-Jones, Coulomb and Born solvation. */
#ifndef CT_STANDIN_H_
#define CT_STANDIN_H_

#include <float.h>
#include <math.h>

#include "born.h"
#include "neighbors.h"
#include "nonbonded.h"
#include "trialleaves.h"

/* Sums over the pairs of a leaf. */
typedef struct StandInLeaf {
  double born[CT_LEAF_WIDTH];     /* Born sums over particles that are near */
  double gradient[CT_LEAF_WIDTH]; /* sums of PairRecord.gradient */
  StandInRadii radii;
  double energy; /* of single particles, and the first order of what the grid neglects */
} StandInLeaf;

/* A leaf in the open trial. */
typedef struct TrialLeaf {
  int64_t trial;     /* the last trial that changed the leaf's sums; the next field belongs to it */
  unsigned crossing; /* bits: slots whose radius on the grid is another */
} TrialLeaf;

/* A pair of leaves whose record the open trial changes. */
typedef struct StagedPair {
  int a;
  int b;
  int pair;
  bool isNew;    /* no row has it yet */
  bool isNear;   /* its energy was computed first, with the radii of the state */
  bool isOpen;   /* its energy is not computed yet */
  bool isMove;   /* its record is changed by what displaced particles change, not computed again */
  NearRows rows; /* in the trial; with isMove, displaced ones in the trial or before it */
  PairRecord after;
} StagedPair;

typedef struct StandIn {
  TrialLeaves* leaves; /* shared with others */
  Nonbonded nonbonded; /* columns and exclusions */
  Born born;
  StandInModel model;
  StandInReach reach;
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
  StagedPair* staged;    /* pairs that the trial moves, then pairs that only new radii change */
  int movedCount;        /* pairs that the trial moves */
  StandInReach farReach; /* for displaced particles: near in the trial or before it */
  double nearChange;
  double nearChangeBack;

  /* The saved copy. */
  bool hasSaved;
  StandInLeaf (*savedSums)[2];
  StandInShift (*savedShifts)[2];
  uint8_t* savedPresent; /* of both */
  Neighbors savedNeighbors;
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

/* Saves a copy of all sums and records, and restores it. False if there is no memory, or no copy. */
bool ctStandInSave(StandIn* standIn);
bool ctStandInRestore(StandIn* standIn);

/* ---- Shared by the files of the stand-in ---- */

/* Ends the open trial without a change of the state. */
static inline void rejectTrial(StandIn* standIn) {
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

/* The frames of the leaves of a pair, the lower one in an image. */
typedef struct PairFrames {
  const LeafFrame* a;
  const LeafFrame* b;
  LeafFrame shifted; /* that of a, if it is an image */
} PairFrames;

/* Finds the frames in the state, or in the trial. */
void ctStandInFindFrames(const StandIn* standIn, int a, int b, const int image[3], bool inTrial, PairFrames* frames);

/* The Born sums that two leaves contribute to each other, given which particles of these are near; and their energy
 * with these radii. The record's other part stays. */
void ctStandInComputeBorn(const StandIn* standIn, int a, const LeafFrame* frameA, int b, const LeafFrame* frameB,
                          const NearRows* rows, PairRecord* record);
void ctStandInComputePairs(const StandIn* standIn, const PlacedLeaf* a, const PlacedLeaf* b, const NearRows* rows,
                           PairRecord* record);

/* Adds to a record what displaced particles change of Born sums; and of the energy, with the radii of the state. Leaves
 * are given in the trial and before it. */
void ctStandInMoveBorn(const StandIn* standIn, int a, int b, const PairFrames frames[2], const NearRows* movers,
                       PairRecord* record);
void ctStandInMovePairs(const StandIn* standIn, int a, int b, const PairFrames frames[2], const NearRows* movers,
                        PairRecord* record);

/* Replaces in a record the energies of pairs with a particle in slotsOfA or slotsOfB, computed with the radii of the
 * state, by those with these radii. */
void ctStandInExchangePairs(const StandIn* standIn, const PlacedLeaf* a, unsigned slotsOfA, const PlacedLeaf* b,
                            unsigned slotsOfB, PairRecord* record);

/* A leaf in this frame, with the radii of the state. */
PlacedLeaf ctStandInPlace(const StandIn* standIn, int leaf, const LeafFrame* frame);

/* The radii of a leaf by its sums. */
void ctStandInComputeRadii(const StandIn* standIn, int number, StandInLeaf* leaf);

/* The reach of the cutoffs, and of particles that may be displaced by this much, nm. */
StandInReach ctStandInReach(const StandInModel* model, float displacement);

/* The factor by which the grid of radii is wider for a particle with this charge. */
double ctStandInGridFactor(double charge);

/* Finds the functions of two radii whose products add up to what a pair's Coulomb and Born energy, per product of
 * charges and in units of Coulomb's constant, is at the cutoff; and to its derivative by ln B. And sets how that fades
 * within the cutoff. */
void ctStandInFitShift(StandInModel* model, const ctEnergyDefinition* d);

#endif /* CT_STANDIN_H_ */
