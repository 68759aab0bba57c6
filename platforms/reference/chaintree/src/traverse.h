/* The one descent that clash, pairs and energy share: the tree against itself (section 2.3).
 *
 * A view says which particles move together and how. Nothing of the tree is written: items that lie wholly in one piece
 * keep their volumes and are moved as one, those that straddle pieces get a volume made for this descent. */
#ifndef CT_TRAVERSE_H_
#define CT_TRAVERSE_H_

#include "volume.h"

/* Consecutive slots that move as one rigid body, up to the next piece's begin. */
typedef struct Piece {
  int slotBegin;
  int motion; /* index into the view's motions; pieces of one motion are one rigid body */
} Piece;

typedef struct View {
  const Piece* pieces; /* ascending, the first begins at slot 0 */
  int pieceCount;
  const ctTransform* motions; /* in the world; motion 0 is the identity. NULL: nothing moves, but pieces still count */
  int motionCount;
  bool everyPair; /* also pairs of one rigid body */
  bool surfaces;  /* reach is from surface to surface, else from centre to centre */
  double reach;   /* pairs no farther apart than this are candidates; may be negative */
} View;

typedef struct ItemPair {
  int level;
  int a;
  int b;
} ItemPair;

/* Scratch of a descent. Coordinates are in the world, from the sequence's worldOrigin. */
typedef struct Traversal {
  const Tree* tree;
  const Sequence* sequence;
  const View* view;
  double extent; /* no coordinate or radius of this view is larger */
  double band;   /* distances this close to a limit are left to the canonical one */

  uint32_t stamp;
  uint32_t* itemStamp; /* per item: its frame and content are of this descent */
  ctTransform* frame;  /* per item */
  int64_t* stillSince; /* per item: the tree's time at which it was expanded at rest, or NOT_AT_REST */
  bool stillSurfaces;  /* whether radii of what was expanded at rest are those of surfaces */
  Spheres items;       /* their volumes; the root has none */

  double (*position)[3]; /* per slot, padded */
  Spheres slots;         /* their particles */

  ItemPair* stack;
} Traversal;

/* Receives a candidate and its squared distance; returns false to end the descent. */
typedef bool CandidateFunction(void* context, int slotA, int slotB, double squaredDistance);

/* Receives a slot near a probe. */
typedef bool ProbeFunction(void* context, int slot, double squaredDistance);

bool ctTraversalBuild(Traversal* traversal, Arena* arena, const Tree* tree, const Sequence* sequence);

/* Calls `function` at least for every pair of slots of different rigid bodies (or every pair) within the view's reach,
 * each once. */
void ctTraverse(Traversal* traversal, const View* view, CandidateFunction* function, void* context, ctCounts* counts);

/* The same for a sphere at a point of the world (from worldOrigin), against everything. */
void ctTraverseProbe(Traversal* traversal, const View* view, const double point[3], double radius,
                     ProbeFunction* function, void* context, ctCounts* counts);

/* The view of the state as it is: one body, every pair. */
View ctViewOfState(bool surfaces, double reach);

#endif /* CT_TRAVERSE_H_ */
