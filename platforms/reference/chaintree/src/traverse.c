#include "traverse.h"

#include <stdlib.h>
#include <string.h>

#include "descent.h"
#include "wide.h"

/* Most entries for nodes that move, and for nodes whose boxes move: with more of them, caches of the processor would
 * miss more often than entries spare work. A visit needs at least two nodes that move and BOXES_PER_VISIT nodes with
 * boxes. */
enum { MOST_MOVED_ENTRIES = 1024, MOST_MOVED_BOXES = 64 };

/* ---- Life ---- */

bool ctTraversalBuild(Traversal* t, Arena* arena, World* world, const Exclusions* exclusions) {
  const Tree* tree = world->tree;
  const size_t nodes = (size_t)tree->nodeCount;
  const size_t inner = nodes - (size_t)tree->levelBegin[1];
  t->movedCapacity = tree->nodeCount < MOST_MOVED_ENTRIES ? tree->nodeCount : MOST_MOVED_ENTRIES;
  t->tree = tree;
  t->world = world;
  t->firstNodesFrom = NO_REVISION;
  t->mostFirstNodes = MOST_FIRST_NODES;
  t->mostUnaskedNodes = MOST_UNASKED_NODES;
  t->mostBoxedNodes = MOST_BOXED_NODES;
  t->testsPerLeaf = TESTS_PER_LEAF;
  t->exclusions = exclusions;
  t->box = ctArenaAllocate(arena, nodes, sizeof(Box));
  t->boxes = ctArenaAllocate(arena, inner, sizeof(ChildBoxes));
  const int boxed = world->leafEntryCount < tree->levelSize[0] ? 0 : boxedNodes(tree); /* see boxLeaves */
  t->leafBoxes = ctArenaAllocate(arena, (size_t)boxed, sizeof(ShortBoxes));
  t->placedIn = ctArenaAllocate(arena, nodes, sizeof(uint32_t));
  t->body = ctArenaAllocate(arena, nodes, sizeof(int));
  t->inView = ctArenaAllocate(arena, nodes, sizeof(Block*));
  t->movedNode = ctArenaAllocate(arena, (size_t)t->movedCapacity, sizeof(int));
  t->moved = ctArenaAllocate(arena, (size_t)t->movedCapacity, sizeof(Block));
  t->movedBoxesCapacity = MOST_MOVED_BOXES;
  t->movedBoxes = ctArenaAllocate(arena, MOST_MOVED_BOXES, sizeof(MovedBoxes));
  t->nearNodes = ctArenaAllocate(arena, nodes + TREE_WIDTH, sizeof(int));
  if (arena->failed) {
    return false;
  }
  world->inView = t->inView;
  for (int i = 0; i < boxed; i++) {
    for (int k = 0; k < TREE_WIDTH; k++) {
      t->leafBoxes[i].ends[0][k] = INT16_MAX; /* below no limit: no member */
    }
  }
  t->boxesFrom = NO_REVISION;
  return true;
}

void ctTraversalFree(Traversal* t) {
  ctArenaFree(&t->mixedNodeArena);
  free(t->motions);
}

CT_NOINLINE bool growMixedNodes(Traversal* t, int count) {
  Arena grown = {0};
  MixedNode* mixedNodes = ctArenaAllocate(&grown, (size_t)count, sizeof(MixedNode));
  if (mixedNodes == NULL) {
    ctArenaFree(&grown);
    return false;
  }
  ctArenaFree(&t->mixedNodeArena);
  t->mixedNodeArena = grown;
  t->mixedNodes = mixedNodes;
  t->mixedNodeCapacity = count;
  return true;
}

bool ctTraversalReserve(Traversal* t, int pieceCount) {
  /* The boundary of two pieces lies within one node of each level at most. */
  const int64_t mixedNodes = (int64_t)(pieceCount - 1) * t->tree->levelCount;
  return mixedNodes <= CT_MOST_COUNT && (mixedNodes <= t->mixedNodeCapacity || growMixedNodes(t, (int)mixedNodes)) &&
         ctReserve((void**)&t->motions, &t->motionCapacity, pieceCount, sizeof(float[12]));
}

View ctViewOfState(double reach) {
  static const Piece whole = {0, 0};
  return (View){&whole, 1, NULL, 1, reach, NULL, true};
}

/* Slots [begin, end) without those at their end that hold no particle, such as fill a molecule's last leaf. */
static int withoutPadding(const Tree* tree, int begin, int end) {
  while (end > begin + 1 && tree->leaf[coveringNode(end - 1)].r[memberIndex(end - 1)] < 0) {
    end--;
  }
  return end;
}

bool ctViewMovesFew(const Traversal* t, const View* view, int* begin, int* end) {
  int p = 0;
  if (view->pieceCount == 3 && view->pieces[0].body == 0 && view->pieces[1].body != 0 && view->pieces[2].body == 0) {
    *begin = view->pieces[1].slotBegin;
    *end = withoutPadding(t->tree, *begin, view->pieces[2].slotBegin);
    return *end - *begin <= MOST_MOVERS && treeTop(t->tree) > 0;
  }
  while (p < view->pieceCount && view->pieces[p].body == 0) {
    p++;
  }
  if (p == view->pieceCount || treeTop(t->tree) == 0) {
    return false;
  }
  *begin = view->pieces[p].slotBegin;
  p = view->pieceCount;
  while (view->pieces[p - 1].body == 0) {
    p--;
  }
  *end = withoutPadding(t->tree, *begin, p < view->pieceCount ? view->pieces[p].slotBegin : t->tree->slotCount);
  return *end - *begin <= MOST_MOVERS;
}

/* ---- Descents ---- */

int64_t ctTraverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  return t->tree->wide->traverse(t, view, function, context, counts);
}

void ctTraverseFew(Traversal* t, const View* view, int begin, int end, CandidateFunction* function,
                   SureClashFunction* clashes, void* context, ctCounts* counts) {
  t->tree->wide->traverseFew(t, view, begin, end, function, clashes, context, counts);
}

int64_t ctTraverseImages(Traversal* t, const View* view, const PeriodicBox* box, bool isPlaced,
                         CandidateFunction* function, void* context, ctCounts* counts) {
  return t->tree->wide->traverseImages(t, view, box, isPlaced, function, context, counts);
}

void ctTraverseFewImages(Traversal* t, const View* view, const PeriodicBox* box, int begin, int end,
                         CandidateFunction* function, void* context, ctCounts* counts) {
  t->tree->wide->traverseFewImages(t, view, box, begin, end, function, context, counts);
}

void ctTraverseProbe(Traversal* t, const View* view, const double point[3], double radius, CandidateFunction* function,
                     void* context, ctCounts* counts) {
  t->tree->wide->traverseProbe(t, view, point, radius, function, context, counts);
}

void ctPositionInView(Traversal* t, int slot, int body, double position[3]) {
  double local[3];
  treeLocal(t->tree, slot, local);
  transformPoint(ctWorldLeafFrame(t->world, coveringNode(slot)), local, position);
  if (body > 0 && t->view->motions != NULL) {
    transformPoint(&t->view->motions[body], position, position);
  }
}

void ctTraversalPosition(Traversal* t, int slot, double position[3]) {
  const int code = t->body[coveringNode(slot)];
  ctPositionInView(t, slot, code < 0 ? mixedNodeOf(t, code)->body[memberIndex(slot)] : code, position);
}

double ctTraversalSquaredDistance(Traversal* t, int slotA, int slotB) {
  double a[3];
  double b[3];
  ctTraversalPosition(t, slotA, a);
  ctTraversalPosition(t, slotB, b);
  return squaredDistance(a, b);
}
