/* Leaves before and in the open trial: where their particles are, and which pairs of leaves the trial changes. */
#ifndef CT_TRIALLEAVES_H_
#define CT_TRIALLEAVES_H_

#include "wide.h"

typedef struct TrialLeaves {
  ctChainTree* tree;
  const Wide* wide;
  double cutoff; /* within which pairs are looked for */
  int leafCount;
  unsigned* occupied; /* per leaf, as the five below; bits: slots that hold a particle */
  LeafFrame* frames;  /* of the state */
  bool* frameIsOutdated;
  LeafFrame* trialFrames;
  int64_t* frameTrial;            /* the trial in which frameInTrial was set */
  const LeafFrame** frameInTrial; /* one of the two above */
  uint16_t* movers; /* per leaf, of one with a frame of its own in a trial that displaces particles: these,
                       as bits */
  const ctLeafPositions* statePositions;
  bool isPeriodic; /* at the last refresh */
  double box[3][3];

  /* The last trial that was asked about. */
  int64_t trial;
  bool isDisplacement;                   /* of single particles */
  double farthest;                       /* nm: the greatest displacement */
  const ctLeafPositions* trialPositions; /* the scene's, as long as the trial is open */
  int changedCount;
  int changedCapacity;
  ctLeafPair* changed;
  int nearCount; /* the number of near ones, which come first */
  int pieceCount;
  int pieceCapacity;
  ctPiece* pieces;
} TrialLeaves;

/* False if there is no memory. */
bool ctTrialLeavesCreate(TrialLeaves* leaves, ctChainTree* tree, double cutoff, int particleCount, const int* slotOf);
void ctTrialLeavesFree(TrialLeaves* leaves);

/* Finds the pairs of leaves of the state that are near, each leaf with itself too, and marks all frames as outdated.
 * The array is the scene's. */
ctStatus ctTrialLeavesRefresh(TrialLeaves* leaves, size_t* count, const ctLeafPair** pairs, ctCounts* counts);

/* Finds the pairs of leaves that the open trial changes, and where leaves are in it. */
ctStatus ctTrialLeavesOpen(TrialLeaves* leaves, ctCounts* counts);

/* The changed pairs that are near, or the others. */
static inline const ctLeafPair* ctChangedPairs(const TrialLeaves* leaves, bool near, int* count) {
  *count = near ? leaves->nearCount : leaves->changedCount - leaves->nearCount;
  return near ? leaves->changed : leaves->changed + leaves->nearCount;
}

/* Marks the frames of leaves that the accepted trial has moved as outdated. */
void ctTrialLeavesAccept(TrialLeaves* leaves);

/* Marks all frames as outdated, since the state has changed. */
void ctTrialLeavesOutdate(TrialLeaves* leaves);

/* Where the particles of a leaf are in the state, and in the trial. They hold until it ends. */
const LeafFrame* ctStateFrame(TrialLeaves* leaves, int leaf);
const LeafFrame* ctTrialFrame(TrialLeaves* leaves, int leaf);

/* True if the frame in the trial, which was found before, is not that of the state. */
static inline bool ctHasOwnFrame(const TrialLeaves* leaves, int leaf) {
  return leaves->frameInTrial[leaf] == &leaves->trialFrames[leaf];
}

/* The displaced particles of such a leaf as bits; 0 of others. */
static inline unsigned ctMoversOf(const TrialLeaves* leaves, int leaf) {
  return ctHasOwnFrame(leaves, leaf) ? leaves->movers[leaf] : 0;
}

/* True if leaves that are so near can have particles within a cutoff; rounding must not lose a pair. */
static inline bool ctIsWithin(float squaredGap, double cutoff) {
  return (double)squaredGap <= cutoff * cutoff * 1.00001;
}

/* Makes room for `count` entries of this size in an array. False, and nothing changed, if there is no
 * memory. */
bool ctReserveEntries(void** array, int* capacity, size_t count, size_t size);

#endif /* CT_TRIALLEAVES_H_ */
