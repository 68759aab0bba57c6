#include "traverse.h"

#include <stdlib.h>
#include <string.h>

#include "descent.h"
#include "instructions.h"

/* Pairs that one visit can leave for later: all children of one node with all of another. */
enum { PAIRS_OF_A_VISIT = TREE_WIDTH * TREE_WIDTH };

/* ---- Life ---- */

bool ctTraversalBuild(Traversal* t, Arena* arena, const Tree* tree, const Sequence* sequence,
                      const Exclusions* exclusions) {
  const size_t items = (size_t)tree->itemCount;
  t->visitsWithoutBoxes = FEWEST_VISITS_WITHOUT_BOXES;
  t->tree = tree;
  t->sequence = sequence;
  t->exclusions = exclusions;
  t->since = ctArenaAllocate(arena, items, sizeof(int64_t));
  t->frame = ctArenaAllocate(arena, items, sizeof(Frame));
  t->rest = ctArenaAllocate(arena, items, sizeof(Block));
  t->box = ctArenaAllocate(arena, items, sizeof(Box));
  t->boxes = ctArenaAllocate(arena, items - (size_t)tree->levelBegin[1], sizeof(NodeBoxes));
  t->itemStamp = ctArenaAllocate(arena, items, sizeof(uint32_t));
  t->motion = ctArenaAllocate(arena, items, sizeof(int));
  t->moved = ctArenaAllocate(arena, items, sizeof(Block));
  t->stack = ctArenaAllocate(arena, (size_t)TREE_MAX_LEVELS * PAIRS_OF_A_VISIT, sizeof(ItemPair));
  t->nearItems = ctArenaAllocate(arena, items + TREE_WIDTH, sizeof(int));
  if (arena->failed) {
    return false;
  }
  for (size_t i = 0; i < items; i++) {
    t->since[i] = NEVER;
  }
  for (size_t i = 0; i < items - (size_t)tree->levelBegin[1]; i++) {
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
  return &t->frame[leaf];
}

/* ---- Descents ---- */

int64_t ctTraverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  return t->tree->instructions->traverse(t, view, function, context, counts);
}

void ctTraverseProbe(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                     void* context, ctCounts* counts) {
  t->tree->instructions->probe(t, view, point, radius, function, context, counts);
}

void ctPositionInView(const Traversal* t, int slot, int motion, double position[3]) {
  double local[3];
  treeLocal(t->tree, slot, local);
  transformPoint(&t->frame[slot / TREE_WIDTH], local, position);
  if (motion > 0 && t->view->motions != NULL) {
    transformPoint(&t->view->motions[motion], position, position);
  }
}

void ctTraversalPosition(const Traversal* t, int slot, double position[3]) {
  const int code = t->motion[slot / TREE_WIDTH];
  ctPositionInView(t, slot, code < 0 ? straddlerOf(t, code)->motion[slot % TREE_WIDTH] : code, position);
}

double ctTraversalSquaredDistance(const Traversal* t, int slotA, int slotB) {
  double a[3];
  double b[3];
  ctTraversalPosition(t, slotA, a);
  ctTraversalPosition(t, slotB, b);
  return squaredDistance(a, b);
}
