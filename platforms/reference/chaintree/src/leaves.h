/* For clients that sum over pairs of particles: positions of leaves in the world, boxes around them, and the pairs of
 * leaves or slots that a trial changes. Each is made on first use. Positions and boxes are kept from state to state,
 * and recomputed where the tree has moved. Boxes are along the world's axes, in float from worldOrigin, and a little
 * larger than the particles need. A node's boxes are those of its members, so that one box is compared with sixteen
 * others at a time; one more node, the super-root, has the root as its only member.
 *
 * What lies behind a closed window, and other molecules, move by rounding alone. Their positions are not updated:
 * `positionError` bounds their error. */
#ifndef CT_LEAVES_H_
#define CT_LEAVES_H_

#include "axisbox.h"
#include "merged.h"
#include "slotpairs.h"
#include "traverse.h"

/* Of a member that has particles of many bodies. */
enum { MANY_BODIES = -1 };

/* The members of an inner node or the super-root in the open trial. */
typedef struct TrialMembers {
  int64_t trialNumber; /* equal to Leaves.trialNumber: the rest is of this trial */
  int body[TREE_WIDTH];
  const AxisBoxes* inTrial; /* `boxes`, or those of the state for a static node */
  AxisBoxes boxes;          /* not filled for a static node */
} TrialMembers;

/* A growing list. */
typedef struct LeafPairs {
  ctLeafPair* pairs;
  size_t count;
  size_t capacity;
} LeafPairs;

typedef struct Leaves {
  /* Made when positions are first needed. */
  Arena arena;
  ctLeafPositions* state; /* per leaf; NULL: not needed yet */
  uint16_t* occupied;     /* per node and the super-root: bit k is set if member k has particles */
  Revision builtFrom;     /* of positions and boxes */
  double positionError;   /* nm: most error of a distance between these positions, see ctLeavesFollow */

  /* Made when pairs are first needed. The arrays of inner nodes are indexed from levelBegin[1] on. */
  Arena pairArena;
  AxisBoxes* boxes;       /* per inner node and the super-root; NULL: not needed yet */
  TrialMembers* members;  /* the same */
  ctLeafPositions* trial; /* per leaf: in the trial, or the state's if `differs` has no bit for it */
  uint16_t*
      differs; /* per inner node over leaves, or the super-root: bit k, leaf k's positions in `trial` are others */
  int64_t trialNumber; /* number of trials whose pairs were listed */
  LeafPairs changed;   /* in the trial */
  LeafPairs all;       /* of the state */
} Leaves;

/* Leaves to be recomputed: leaves that have moved in the tree, or that pieces move. */
typedef struct LeafUpdate {
  Leaves* leaves;
  World* world;
  const Sequence* sequence;
  int firstMoved;      /* leaf, since leaves->builtFrom */
  int pieceCount;      /* 0: by the tree */
  const Piece* pieces; /* ascending */
} LeafUpdate;

/* Where pairs are listed: in the state, or in a trial. */
typedef struct LeafTask {
  Leaves* leaves;
  const Tree* tree;
  const Sequence* sequence;
  const Exclusions* exclusions;
  LeafPairs* pairs;     /* where pairs of leaves go */
  SlotPairs* slotPairs; /* where pairs of slots go */
  double cutoff;
  int pieceCount;      /* 0: the state */
  const Piece* pieces; /* of the trial, ascending */
  const Frame* motions;
  const ctTransform* worldMotions; /* the same for absolute positions */
  double size;                     /* no particle is farther from worldOrigin, before the trial or in it */
  float limit;                     /* of squared gaps, for pairs without shift */
  bool failed;                     /* there was no memory */
  bool isTooLong;                  /* a molecule reaches over too many boxes */
  int64_t tests;                   /* of boxes */
  int64_t particleTests;
} LeafTask;

/* Make room on first use; false, and nothing changed, if there is no memory. */
bool ctLeavesReserve(Leaves* leaves, const Tree* tree, const Sequence* sequence);
bool ctLeavesReservePairs(Leaves* leaves, const Tree* tree);

void ctLeavesFree(Leaves* leaves);

/* Updates positions and boxes to the state; the tree must be up to date. */
void ctLeavesUpdate(Leaves* leaves, World* world, const Sequence* sequence);

/* Call after changes other than accept. */
void ctLeavesForget(Leaves* leaves);

/* True if positions and boxes are those of the state. */
bool ctLeavesAreOf(const Leaves* leaves, const Tree* tree);

/* Updates positions and boxes of the former state to the accepted trial: recomputes leaves with slots that it moves.
 * Other distances have changed by at most its distanceError; if that is 0, by rounding, and there must be boxes. */
void ctLeavesFollow(Leaves* leaves, World* world, const Sequence* sequence, const Trial* trial);

/* Updates leaves, and writes a task for the state or the open trial. Fails if there is no memory. */
ctStatus ctLeavesBegin(ctChainTree* scene, bool inTrial, double cutoff, LeafTask* task);

/* Makes room for `count` pairs; false, and nothing changed, if there is no memory. */
bool ctLeafPairsReserve(LeafPairs* pairs, size_t count);

/* The node over the root. */
static inline int treeSuperRoot(const Tree* tree) {
  return tree->nodeCount;
}

static inline AxisBoxes* leafBoxes(const Leaves* leaves, const Tree* tree, int node) {
  return &leaves->boxes[node - tree->levelBegin[1]];
}

/* The largest distance from worldOrigin of a corner of member 0. */
static inline double cornerOf(const AxisBoxes* boxes) {
  double corner[3];
  for (int d = 0; d < 3; d++) {
    corner[d] = larger(fabs((double)boxes->low[d][0]), fabs((double)boxes->high[d][0]));
  }
  return sqrt(dot(corner, corner));
}

static inline TrialMembers* trialMembers(const Leaves* leaves, const Tree* tree, int node) {
  return &leaves->members[node - tree->levelBegin[1]];
}

#endif /* CT_LEAVES_H_ */
