/* For clients that sum something over pairs of particles: the positions of all leaves in the world, boxes around them,
 * and the pairs of leaves that a trial changes. Nothing of this is made before it is asked for.
 *
 * Positions and boxes are kept from state to state, and recomputed where the tree says that something has moved. Boxes
 * are along the world's axes, in float from worldOrigin, and a little larger than the particles need. A node's boxes
 * are those of its members, so that one box is compared with sixteen others at a time; one more node, the crown, has
 * the root as its only member.
 *
 * What lies behind a closed window moves by rounding alone. Its positions stay as they are, and lag behind the tree's.
 */
#ifndef CT_LEAVES_H_
#define CT_LEAVES_H_

#include "skipped.h"
#include "traverse.h"

/* The boxes of the members of a node, along the world's axes; low above high: the member has no particles. */
typedef struct LeafBoxes {
  float low[3][TREE_WIDTH];
  float high[3][TREE_WIDTH];
} LeafBoxes;

static inline void clearBoxes(LeafBoxes* boxes) {
  for (int d = 0; d < 3; d++) {
    for (int k = 0; k < TREE_WIDTH; k++) {
      boxes->low[d][k] = INFINITY;
      boxes->high[d][k] = -INFINITY;
    }
  }
}

/* The members of an inner node or the crown in the open trial. */
typedef struct TrialMembers {
  int64_t stamp; /* equal to Leaves.stamp: the rest is of this trial */
  int body[TREE_WIDTH];
  LeafBoxes boxes; /* of a node at rest: not filled, see the boxes of the state */
} TrialMembers;

/* A growing list. */
typedef struct LeafPairs {
  ctLeafPair* pairs;
  size_t count;
  size_t capacity;
} LeafPairs;

typedef struct Leaves {
  /* Made when positions are asked for. */
  Arena arena;
  ctLeafPositions* state; /* per leaf; NULL: nobody has asked */
  uint16_t* occupied;     /* per node and the crown: bit k is set if member k has particles */
  int64_t time;           /* the tree's, of positions and boxes; NEVER: they have none */
  double lag;             /* nm: no distance between these positions is off by more, see ctLeavesFollow */

  /* Made when pairs are asked for. The arrays of inner nodes are indexed from levelBegin[1] on. */
  Arena pairArena;
  LeafBoxes* boxes;       /* per inner node and the crown; NULL: nobody has asked */
  TrialMembers* members;  /* the same */
  ctLeafPositions* trial; /* per leaf: in the trial, or the state's if `differs` has no bit for it */
  uint16_t* differs; /* per inner node over leaves, or the crown: bit k, leaf k's positions in `trial` are others */
  int64_t stamp;     /* number of trials that pairs were asked of */
  LeafPairs changed; /* in the trial */
  LeafPairs all;     /* of the state */
} Leaves;

/* Which leaves are to be recomputed: those that the tree has changed since, or those that pieces move. */
typedef struct LeafUpdate {
  Leaves* leaves;
  const Tree* tree;
  const Sequence* sequence;
  int firstMoved;      /* leaf, since leaves->time */
  int pieceCount;      /* 0: by the tree */
  const Piece* pieces; /* ascending */
} LeafUpdate;

/* What pairs are asked of: the state, or a trial. */
typedef struct LeafTask {
  Leaves* leaves;
  const Tree* tree;
  const Sequence* sequence;
  LeafPairs* pairs; /* where they go */
  double cutoff;
  int pieceCount;      /* 0: the state */
  const Piece* pieces; /* of the trial, ascending */
  const Frame* motions;
  const ctTransform* worldMotions; /* the same for absolute positions */
  bool failed;                     /* there was no memory */
  int64_t tests;                   /* of boxes */
} LeafTask;

/* Make room, when something is asked for first; false, and nothing changed, if there is no memory. */
bool ctLeavesReserve(Leaves* leaves, const Tree* tree, const Sequence* sequence);
bool ctLeavesReservePairs(Leaves* leaves, const Tree* tree);

void ctLeavesFree(Leaves* leaves);

/* Makes what is kept that of the state; the tree must not be stale. */
void ctLeavesUpdate(Leaves* leaves, const Tree* tree, const Sequence* sequence);

/* To be called when the state has become another one than by an accepted trial. */
void ctLeavesForget(Leaves* leaves);

/* True if what is kept is that of the state. */
bool ctLeavesAreOf(const Leaves* leaves, const Tree* tree);

/* Makes what is kept that of the state that a trial has become, if it was that of the state before: recomputes leaves
 * with slots that are not at rest in these pieces. Other distances have changed by no more than `slack`: they lag. */
void ctLeavesFollow(Leaves* leaves, const Tree* tree, const Sequence* sequence, int pieceCount, const Piece* pieces,
                    double slack);

/* Makes room for so many pairs; false, and nothing changed, if there is no memory. */
bool ctLeafPairsReserve(LeafPairs* pairs, size_t count);

/* The node over the root. */
static inline int treeCrown(const Tree* tree) {
  return tree->nodeCount;
}

static inline LeafBoxes* leafBoxes(const Leaves* leaves, const Tree* tree, int node) {
  return &leaves->boxes[node - tree->levelBegin[1]];
}

static inline TrialMembers* trialMembers(const Leaves* leaves, const Tree* tree, int node) {
  return &leaves->members[node - tree->levelBegin[1]];
}

#endif /* CT_LEAVES_H_ */
