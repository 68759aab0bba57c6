/* The one descent that the clashes and the pairs of a trial share: the tree against itself (section 2.3).
 *
 * A view says which particles move together and how. Nothing of the tree is written: items that lie wholly in one piece
 * keep their volumes and are moved as one, those that straddle pieces get a volume made for this descent. */
#ifndef CT_TRAVERSE_H_
#define CT_TRAVERSE_H_

#include "exclusion.h"
#include "tree.h"

/* Consecutive slots that move as one rigid body, up to the next piece's begin. */
typedef struct Piece {
  int slotBegin;
  int motion; /* index into the view's motions; pieces of one motion are one rigid body */
} Piece;

typedef struct View {
  const Piece* pieces; /* ascending, the first begins at slot 0 */
  int pieceCount;
  const Frame* motions; /* in the world; motion 0 is the identity. NULL: nothing moves, but pieces still count */
  int motionCount;
  bool surfaces; /* reach is from surface to surface, else from centre to centre */
  double reach;  /* pairs no farther apart than this are candidates; may be negative */
} View;

typedef struct ItemPair {
  int level;
  int a;
  int b;
} ItemPair;

struct Box;
struct MovedBoxes;
struct NodeBoxes;
struct Straddler;

/* Scratch of a descent. Coordinates are in the world, from the sequence's worldOrigin. */
typedef struct Traversal {
  const Tree* tree;
  const Sequence* sequence;
  const Exclusions* exclusions;
  const View* view;
  double extent; /* no coordinate or radius of this view is larger */
  double band;   /* distances this close to a limit are left to the canonical one */

  /* Per item, of the state; what has not changed since is kept from descent to descent. */
  int64_t* since;     /* the tree's time at which the item was put into the world, or NEVER */
  bool sinceSurfaces; /* whether the radii of those are of surfaces */
  int* restAt;        /* where its frame and members are; CT_NULL: they have had to make room for others */
  struct Box* box;    /* around its members in its own frame, unless the tree calls the item fresh */

  /* What has been put into the world: all nodes, and so many leaves, the ones put there last. */
  int leafPlaces;
  int nextPlace;
  int* leafAt; /* per place of a leaf; CT_NULL: none */
  Frame* frame;
  Block* rest; /* members */

  /* Per node, from levelBegin[1] on: boxes of its children. They are looked at after so many visits of a descent; that
   * grows while they part too little and shrinks while they part much. */
  struct NodeBoxes* boxes;
  int visitsWithoutBoxes;
  bool alwaysBoxes;    /* for tests: at all visits */
  bool alwaysDescends; /* for tests: even if few slots move */

  /* Per item, of this descent. */
  uint32_t stamp;
  uint32_t* itemStamp; /* the item is expanded */
  int* motion;         /* of which rigid body it is; below 0: it straddles bodies, see straddlerOf */
  Block** inView;      /* of an expanded item, its members as they lie in the view; NULL: they had to make room */

  /* Members of items that move in this descent; of many, those moved last. */
  int movedCount;
  int movedPlaces;
  int* movedItem; /* per place: whose they are */
  Block* moved;
  int movedBoxesCount;
  int movedBoxesPlaces;
  struct MovedBoxes* movedBoxes;

  /* What straddles bodies, from the root down. */
  struct Straddler* straddlers;
  int straddlerCount;
  int straddlerCapacity;
  float (*motions)[12]; /* of the view */
  int motionCapacity;

  ItemPair* stack;
  int* nearItems; /* found by a probe; with room for sixteen more */
} Traversal;

/* Receives a candidate and its squared distance; returns false to end the descent. */
typedef bool CandidateFunction(void* context, int slotA, int slotB, double squaredDistance);

/* Receives a slot near a probe. */
typedef bool ProbeFunction(void* context, int slot, double squaredDistance);

bool ctTraversalBuild(Traversal* traversal, Arena* arena, const Tree* tree, const Sequence* sequence,
                      const Exclusions* exclusions);

void ctTraversalFree(Traversal* traversal);

/* Makes room for views of this many pieces; false, and nothing changed, if there is no memory. */
bool ctTraversalReserve(Traversal* traversal, int pieceCount);

/* The frame of a leaf in the world. */
const Frame* ctTraversalLeafFrame(Traversal* traversal, int leaf);

/* Calls `function` at least for every pair of slots of different rigid bodies that is not excluded and within the
 * view's reach, each once. Returns what that has cost, in about the units of Clearance.cost. */
int64_t ctTraverse(Traversal* traversal, const View* view, CandidateFunction* function, void* context,
                   ctCounts* counts);

/* The same for a sphere at a point of the world (from worldOrigin), against everything. */
void ctTraverseProbe(Traversal* traversal, const View* view, const double point[3], double radius,
                     ProbeFunction* function, void* context, ctCounts* counts);

/* Where a slot of this motion is in the view; its leaf has been put into the world. */
void ctPositionInView(Traversal* traversal, int slot, int motion, double position[3]);

/* Where a slot that the running descent has reached is in its view. */
void ctTraversalPosition(Traversal* traversal, int slot, double position[3]);

/* The squared distance of two such. */
double ctTraversalSquaredDistance(Traversal* traversal, int slotA, int slotB);

/* Whether all that moves is few slots in a row, and which: [begin, end). */
bool ctViewMovesFew(const Traversal* traversal, const View* view, int* begin, int* end);

/* The view of the state as it is: one body. */
View ctViewOfState(bool surfaces, double reach);

#endif /* CT_TRAVERSE_H_ */
