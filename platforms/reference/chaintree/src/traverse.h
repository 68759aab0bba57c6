/* The descent of the tree against itself, which tests a trial for clashes (section 2.3). A view says which slots move
 * together and how. A descent writes nothing to the tree: a node that lies in one piece keeps its volume and moves as a
 * whole; a mixed node gets a volume made for this descent. */
#ifndef CT_TRAVERSE_H_
#define CT_TRAVERSE_H_

#include "counts.h"
#include "exclusion.h"
#include "images.h"
#include "world.h"

/* Its body is an index into the view's motions: all pieces of one motion are one rigid body. */
typedef ctPiece Piece;

/* A configuration, as rigid motions of pieces of the state, and how far a descent of it reaches. */
typedef struct View {
  const Piece* pieces; /* ascending, the first begins at slot 0 */
  int pieceCount;
  const Frame* motions; /* in the world; motion 0 is the identity. NULL: nothing moves, but pieces still count */
  int motionCount;
  double reach;              /* pairs whose surfaces are no farther apart are candidates; may be negative */
  const Frame* trialMotions; /* the motions, even where the view is of the state before them; NULL: none */
  bool allImages;            /* pairs with images count whether they move or not */
} View;

/* Boxes around the members of a node over leaves, along the world's axes, in short units: a coordinate in nm times
 * Traversal.boxScale. They are a little larger than the members. Rows 0 to 2 are the opposites of their high ends, rows
 * 3 to 5 their low ends. */
typedef struct ShortBoxes {
  int16_t ends[6][TREE_WIDTH];
} ShortBoxes;

/* Nodes whose members fill 64 bits. */
enum { NODES_AT_ONCE = 64 / TREE_WIDTH };

/* Number of nodes that have boxes of members: those over leaves, rounded up to NODES_AT_ONCE. */
static inline int boxedNodes(const Tree* tree) {
  return (tree->levelSize[1] + NODES_AT_ONCE - 1) / NODES_AT_ONCE * NODES_AT_ONCE;
}

struct Box;
struct MovedBoxes;
struct ChildBoxes;
struct MixedNode;

/* Scratch of a descent. */
typedef struct Traversal {
  const Tree* tree;
  const Exclusions* exclusions;
  const View* view;
  const Image* image;     /* in which the first slots of candidates count; NULL: without shift */
  double coordinateBound; /* no coordinate or radius of this view is larger */
  double tieBand;         /* the canonical distance decides about distances this close to a limit */
  World* world;

  /* The nodes that tests of few slots start with. */
  Revision firstNodesFrom; /* they are up to date with this revision */
  int firstLevel;          /* of these nodes */
  int mostFirstNodes;      /* MOST_FIRST_NODES, but for tests */
  int mostUnaskedNodes;    /* MOST_UNASKED_NODES, but for tests */

  /* Boxes around leaves, per node over leaves, which tests of few slots read instead of spheres: half as many are near,
   * and a comparison takes a third of the time. They are made once only few leaves at a time have moved for a while;
   * then leaves that move get new ones. */
  ShortBoxes* leafBoxes;
  float boxScale;     /* units a nm */
  int mostBoxedNodes; /* MOST_BOXED_NODES, but for tests */
  int testsPerLeaf;   /* TESTS_PER_LEAF, but for tests */
  int testsToBoxes;   /* 0: all leaves have boxes, and world coordinates up to rounding */
  Revision boxesFrom; /* when boxes, or the wait for them, were last updated */

  /* Boxes of children, per inner node, from levelBegin[1] on. A descent tests boxes after its first visitsWithoutBoxes
   * visits; that number grows while boxes separate few pairs, and shrinks while they separate many. */
  struct ChildBoxes* boxes;
  struct Box* box; /* per node: around its members in its own frame */
  int visitsWithoutBoxes;
  bool alwaysBoxes; /* for tests: at all visits */

  /* Of this descent, per node. */
  uint32_t descent;   /* its number */
  uint32_t* placedIn; /* the descent in which the node was last placed in the view */
  int* body;          /* index of its rigid body; below 0: it is a mixed node, see mixedNodeOf */
  Block** inView;     /* members of a placed node in the view; NULL: another node has taken their entry */

  /* Members of nodes that move in this descent: a ring of the last of them. */
  int nextMoved;
  int movedCapacity;
  int* movedNode; /* per entry */
  Block* moved;
  int movedBoxesCount; /* in this descent, replaced ones included */
  int movedBoxesCapacity;
  struct MovedBoxes* movedBoxes;

  /* The mixed nodes, each after those below it. */
  struct MixedNode* mixedNodes;
  Arena mixedNodeArena;
  int mixedNodeCount;
  int mixedNodeCapacity;
  float (*motions)[12]; /* of the view */
  int motionCapacity;

  int* nearNodes; /* found for movers; with room for sixteen more */
} Traversal;

/* Receives a candidate and its squared distance; returns false to end the descent. */
typedef bool CandidateFunction(void* context, int slotA, int slotB, double squaredDistance);

/* Receives a candidate and an upper bound of its distance; returns true to end the descent. Otherwise the candidate and
 * its distance go to the CandidateFunction. */
typedef bool SureClashFunction(void* context, int slotA, int slotB, double farthest);

bool ctTraversalBuild(Traversal* traversal, Arena* arena, World* world, const Exclusions* exclusions);

void ctTraversalFree(Traversal* traversal);

/* Makes room for views of this many pieces; false, and nothing changed, if there is no memory. */
bool ctTraversalReserve(Traversal* traversal, int pieceCount);

/* Calls `function` at least for every pair of slots of different rigid bodies that is not excluded and within the
 * view's reach, each once. Returns what the descent has cost, in the units of costs.h. */
int64_t ctTraverse(Traversal* traversal, const View* view, CandidateFunction* function, void* context,
                   ctCounts* counts);

/* The same for a view in which only slots within [begin, end) move, see ctViewMovesFew. Bounds may be loose. Calls
 * `clashes`, unless it is NULL, for each candidate first. */
void ctTraverseFew(Traversal* traversal, const View* view, int begin, int end, CandidateFunction* function,
                   SureClashFunction* clashes, void* context, ctCounts* counts);

/* The same for pairs of the view with its images, but calls `function` for all pairs whose distance the view changes:
 * within a body that turns, too. Each pair comes in its nearest image: `image` in the traversal. `isPlaced`: the last
 * call was ctTraverse of this view, and went to its end. */
int64_t ctTraverseImages(Traversal* traversal, const View* view, const PeriodicBox* box, bool isPlaced,
                         CandidateFunction* function, void* context, ctCounts* counts);

/* The same for a view in which only slots within [begin, end) move. Bounds may be loose. */
void ctTraverseFewImages(Traversal* traversal, const View* view, const PeriodicBox* box, int begin, int end,
                         CandidateFunction* function, void* context, ctCounts* counts);

/* The same for a sphere at a point of the world (from worldOrigin), against everything in the view of the state:
 * `function` receives CT_NULL and a slot. */
void ctTraverseProbe(Traversal* traversal, const View* view, const double point[3], double radius,
                     CandidateFunction* function, void* context, ctCounts* counts);

/* The position in the view of a slot of this body. */
void ctPositionInView(Traversal* traversal, int slot, int body, double position[3]);

/* The position in the view of a slot that the running descent has reached. */
void ctTraversalPosition(Traversal* traversal, int slot, double position[3]);

/* The squared distance of two such. */
double ctTraversalSquaredDistance(Traversal* traversal, int slotA, int slotB);

/* True if slots move only within [begin, end), and these are few. */
bool ctViewMovesFew(const Traversal* traversal, const View* view, int* begin, int* end);

/* The view of the state as it is: one body. With its images all pairs are candidates. */
View ctViewOfState(double reach);

#endif /* CT_TRAVERSE_H_ */
