#include "traverse.h"

#include <stdlib.h>
#include <string.h>

#include "descent.h"
#include "instructions.h"

/* Pairs that one visit can leave for later: all children of one node with all of another. */
enum { PAIRS_OF_A_VISIT = TREE_WIDTH * TREE_WIDTH };

/* So much is kept of leaves at rest, of items that move and of nodes whose boxes move: beyond that memory costs more
 * than it spares. A visit needs two leaves, two items that move and BOXES_OF_A_VISIT nodes with boxes at a time. */
enum { MOST_LEAF_PLACES = 8192, MOST_MOVED_PLACES = 1024, MOVED_BOXES_PLACES = 64 };

/* ---- Life ---- */

bool ctTraversalBuild(Traversal* t, Arena* arena, const Tree* tree, const Sequence* sequence,
                      const Exclusions* exclusions) {
  const size_t items = (size_t)tree->itemCount;
  const int leaves = tree->levelBegin[1];
  const size_t nodes = items - (size_t)leaves;
  t->leafPlaces = leaves < MOST_LEAF_PLACES ? leaves : MOST_LEAF_PLACES;
  const size_t places = (size_t)t->leafPlaces + nodes;
  t->movedPlaces = tree->itemCount < MOST_MOVED_PLACES ? tree->itemCount : MOST_MOVED_PLACES;
  t->tree = tree;
  t->sequence = sequence;
  t->exclusions = exclusions;
  t->since = ctArenaAllocate(arena, items, sizeof(int64_t));
  t->restAt = ctArenaAllocate(arena, items, sizeof(int));
  t->leafAt = ctArenaAllocate(arena, (size_t)t->leafPlaces, sizeof(int));
  t->frame = ctArenaAllocate(arena, places, sizeof(Frame));
  t->rest = ctArenaAllocate(arena, places, sizeof(Block));
  t->box = ctArenaAllocate(arena, items, sizeof(Box));
  t->boxes = ctArenaAllocate(arena, nodes, sizeof(NodeBoxes));
  t->itemStamp = ctArenaAllocate(arena, items, sizeof(uint32_t));
  t->motion = ctArenaAllocate(arena, items, sizeof(int));
  t->inView = ctArenaAllocate(arena, items, sizeof(Block*));
  t->movedItem = ctArenaAllocate(arena, (size_t)t->movedPlaces, sizeof(int));
  t->moved = ctArenaAllocate(arena, (size_t)t->movedPlaces, sizeof(Block));
  t->movedBoxesPlaces = MOVED_BOXES_PLACES;
  t->movedBoxes = ctArenaAllocate(arena, MOVED_BOXES_PLACES, sizeof(MovedBoxes));
  t->stack = ctArenaAllocate(arena, (size_t)TREE_MAX_LEVELS * PAIRS_OF_A_VISIT, sizeof(ItemPair));
  t->nearItems = ctArenaAllocate(arena, items + TREE_WIDTH, sizeof(int));
  if (arena->failed) {
    return false;
  }
  for (int place = 0; place < t->leafPlaces; place++) {
    t->leafAt[place] = CT_NULL;
  }
  for (int item = 0; item < tree->itemCount; item++) {
    t->since[item] = NEVER;
    t->restAt[item] = item < leaves ? CT_NULL : t->leafPlaces + item - leaves;
  }
  for (size_t i = 0; i < nodes; i++) {
    t->boxes[i].ownTime = NEVER;
    t->boxes[i].restSince = NEVER;
  }
  return true;
}

void ctTraversalFree(Traversal* t) {
  free(t->straddlers);
  free(t->motions);
}

bool ctTraversalReserve(Traversal* t, int pieceCount) {
  /* Where two pieces meet, one item of each level straddles them. */
  return ctReserve((void**)&t->straddlers, &t->straddlerCapacity, (pieceCount - 1) * t->tree->levelCount,
                   sizeof(Straddler)) &&
         ctReserve((void**)&t->motions, &t->motionCapacity, pieceCount, sizeof(float[12]));
}

View ctViewOfState(bool surfaces, double reach) {
  static const Piece whole = {0, 0};
  return (View){&whole, 1, NULL, 1, surfaces, reach};
}

bool ctViewMovesFew(const Traversal* t, const View* view, int* begin, int* end) {
  int p = 0;
  while (p < view->pieceCount && view->pieces[p].motion == 0) {
    p++;
  }
  if (p == view->pieceCount || t->alwaysDescends || treeTop(t->tree) == 0) {
    return false;
  }
  *begin = view->pieces[p].slotBegin;
  while (p < view->pieceCount && view->pieces[p].motion != 0) {
    p++;
  }
  *end = p < view->pieceCount ? view->pieces[p].slotBegin : t->tree->slotCount;
  return p + 1 >= view->pieceCount && *end - *begin <= MOST_MOVERS;
}

const Frame* ctTraversalLeafFrame(Traversal* t, int leaf) {
  t->tree->instructions->putLeafToRest(t, leaf);
  return &t->frame[t->restAt[leaf]];
}

/* ---- Descents ---- */

int64_t ctTraverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  return t->tree->instructions->traverse(t, view, function, context, counts);
}

void ctTraverseProbe(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                     void* context, ctCounts* counts) {
  t->tree->instructions->probe(t, view, point, radius, function, context, counts);
}

void ctPositionInView(Traversal* t, int slot, int motion, double position[3]) {
  const int leaf = slot / TREE_WIDTH;
  if (t->restAt[leaf] == CT_NULL) {
    t->tree->instructions->putLeafToRest(t, leaf);
  }
  double local[3];
  treeLocal(t->tree, slot, local);
  transformPoint(&t->frame[t->restAt[leaf]], local, position);
  if (motion > 0 && t->view->motions != NULL) {
    transformPoint(&t->view->motions[motion], position, position);
  }
}

void ctTraversalPosition(Traversal* t, int slot, double position[3]) {
  const int code = t->motion[slot / TREE_WIDTH];
  ctPositionInView(t, slot, code < 0 ? straddlerOf(t, code)->motion[slot % TREE_WIDTH] : code, position);
}

double ctTraversalSquaredDistance(Traversal* t, int slotA, int slotB) {
  double a[3];
  double b[3];
  ctTraversalPosition(t, slotA, a);
  ctTraversalPosition(t, slotB, b);
  return squaredDistance(a, b);
}
