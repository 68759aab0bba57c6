#include "traverse.h"

#include <string.h>

/* Pairs that one visit can leave for later: all children of one node with all of another. */
enum { PAIRS_OF_A_VISIT = TREE_WIDTH * TREE_WIDTH };

enum { NOT_AT_REST = -1 };

static void allocateSpheres(Spheres* spheres, Arena* arena, size_t count) {
  spheres->x = ctArenaAllocate(arena, count, sizeof(float));
  spheres->y = ctArenaAllocate(arena, count, sizeof(float));
  spheres->z = ctArenaAllocate(arena, count, sizeof(float));
  spheres->r = ctArenaAllocate(arena, count, sizeof(float));
  spheres->motion = ctArenaAllocate(arena, count, sizeof(int));
  for (size_t i = 0; i < count && !arena->failed; i++) {
    spheres->r[i] = -INFINITY; /* padding, and what is never expanded */
  }
}

static void forgetStill(Traversal* t) {
  for (int item = 0; item < t->tree->itemCount; item++) {
    t->stillSince[item] = NOT_AT_REST;
  }
}

bool ctTraversalBuild(Traversal* t, Arena* arena, const Tree* tree, const Sequence* sequence) {
  const size_t items = (size_t)tree->itemCount;
  const size_t slots = (size_t)tree->levelSize[0] * TREE_WIDTH;
  t->tree = tree;
  t->sequence = sequence;
  t->itemStamp = ctArenaAllocate(arena, items, sizeof(uint32_t));
  t->frame = ctArenaAllocate(arena, items, sizeof(ctTransform));
  t->stillSince = ctArenaAllocate(arena, items, sizeof(int64_t));
  t->position = ctArenaAllocate(arena, slots, sizeof(double[3]));
  t->stack = ctArenaAllocate(arena, (size_t)TREE_MAX_LEVELS * PAIRS_OF_A_VISIT, sizeof(ItemPair));
  allocateSpheres(&t->items, arena, items);
  allocateSpheres(&t->slots, arena, slots);
  if (arena->failed) {
    return false;
  }
  forgetStill(t);
  return true;
}

View ctViewOfState(bool surfaces, double reach) {
  static const Piece whole = {0, 0};
  return (View){&whole, 1, NULL, 1, true, surfaces, reach};
}

/* ---- What this view makes of an item ---- */

/* The motion of slots [begin, end), or STRADDLES. */
static int motionOf(const View* view, int begin, int end) {
  int low = 0;
  int high = view->pieceCount - 1;
  while (low < high) {
    const int middle = (low + high + 1) / 2;
    if (view->pieces[middle].slotBegin <= begin) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low + 1 < view->pieceCount && view->pieces[low + 1].slotBegin < end ? STRADDLES : view->pieces[low].motion;
}

static bool isMoved(const View* view, int motion) {
  return motion > 0 && view->motions != NULL;
}

/* Puts sphere k of these at a point of the world. */
static void placeSphere(Spheres* spheres, int k, const double centre[3], double radius) {
  spheres->x[k] = (float)centre[0];
  spheres->y[k] = (float)centre[1];
  spheres->z[k] = (float)centre[2];
  spheres->r[k] = (float)radius;
}

/* The volume of an item that straddles pieces: around its members as they lie in this view. */
static void boundStraddler(Traversal* t, int item, const Spheres* members, int first) {
  double low[3] = {INFINITY, INFINITY, INFINITY};
  double high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int k = first; k < first + TREE_WIDTH; k++) {
    const double r = members->r[k];
    if (r >= 0) {
      const double c[3] = {members->x[k], members->y[k], members->z[k]};
      for (int d = 0; d < 3; d++) {
        low[d] = lesser(low[d], c[d] - r);
        high[d] = larger(high[d], c[d] + r);
      }
    }
  }
  if (low[0] > high[0]) {
    t->items.r[item] = -INFINITY;
    return;
  }
  const double centre[3] = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])};
  double radius = 0;
  for (int k = first; k < first + TREE_WIDTH; k++) {
    if (members->r[k] >= 0) {
      const double c[3] = {members->x[k], members->y[k], members->z[k]};
      radius = larger(radius, sqrt(squaredDistance(centre, c)) + members->r[k]);
    }
  }
  /* Straddlers lie within straddlers: each level adds its own rounding. */
  placeSphere(&t->items, item, centre, radius + FLOAT_MARGIN * t->extent);
}

static void expandLeaf(Traversal* t, int leaf) {
  const Tree* tree = t->tree;
  const View* view = t->view;
  int end;
  const int begin = treeSlots(tree, 0, leaf, &end);
  const int motion = t->items.motion[leaf];
  for (int slot = begin; slot < end; slot++) {
    if (t->sequence->slotParticle[slot] == CT_NULL) {
      continue;
    }
    double* x = t->position[slot];
    transformPoint(&t->frame[leaf], tree->local[slot], x);
    t->slots.motion[slot] = motion == STRADDLES ? motionOf(view, slot, slot + 1) : motion;
    if (motion == STRADDLES && isMoved(view, t->slots.motion[slot])) {
      transformPoint(&view->motions[t->slots.motion[slot]], x, x);
    }
    placeSphere(&t->slots, slot, x, view->surfaces ? t->sequence->slotRadius[slot] : 0);
  }
}

static void expand(Traversal* t, int level, int item);

static void expandNode(Traversal* t, int level, int item) {
  const Tree* tree = t->tree;
  const View* view = t->view;
  int count;
  const int first = treeChildren(tree, level, item, &count);
  for (int child = first; child < first + count; child++) {
    int motion = t->items.motion[item];
    if (motion == STRADDLES) {
      int end;
      const int begin = treeSlots(tree, level - 1, child, &end);
      motion = motionOf(view, begin, end);
    }
    t->items.motion[child] = motion;
    if (motion == STRADDLES) {
      expand(t, level - 1, child);
      continue;
    }
    double centre[3] = {tree->x[child], tree->y[child], tree->z[child]};
    transformPoint(&t->frame[item], centre, centre);
    if (t->items.motion[item] == STRADDLES && isMoved(view, motion)) {
      transformPoint(&view->motions[motion], centre, centre);
    }
    const float radius = view->surfaces ? tree->surfaces[child] : tree->centres[child];
    placeSphere(&t->items, child, centre, radius < 0 ? -INFINITY : radius);
  }
}

/* Whether an item of the body at rest still has all that expanding it would give. */
static bool isStill(const Traversal* t, int level, int item) {
  if (t->stillSince[item] == NOT_AT_REST) {
    return false;
  }
  int end;
  treeSlots(t->tree, level, item, &end);
  return treeUnchanged(t->tree, t->stillSince[item], (end + TREE_WIDTH - 1) / TREE_WIDTH);
}

/* Puts the children (or slots) of an item into the world, once a descent, or once a change of the state if they are at
 * rest. Its parent has been expanded. */
static void expand(Traversal* t, int level, int item) {
  if (t->itemStamp[item] == t->stamp) {
    return;
  }
  t->itemStamp[item] = t->stamp;
  const Tree* tree = t->tree;
  const int motion = t->items.motion[item];
  if (motion == 0 && isStill(t, level, item)) {
    return;
  }
  t->stillSince[item] = motion == 0 ? tree->time : NOT_AT_REST;
  bool movesAlone = isMoved(t->view, motion);
  if (level == treeTop(tree)) {
    t->frame[item] = tree->pose[item];
  } else {
    const int parent = treeParent(tree, level, item);
    t->frame[item] = transformCompose(&t->frame[parent], &tree->pose[item]);
    movesAlone = movesAlone && t->items.motion[parent] == STRADDLES;
  }
  if (movesAlone) {
    t->frame[item] = transformCompose(&t->view->motions[motion], &t->frame[item]);
  }
  if (level == 0) {
    expandLeaf(t, item);
  } else {
    expandNode(t, level, item);
  }
  if (motion == STRADDLES) {
    if (level == 0) {
      boundStraddler(t, item, &t->slots, item * TREE_WIDTH);
    } else {
      int count;
      const int first = treeChildren(tree, level, item, &count);
      boundStraddler(t, item, &t->items, first);
    }
  }
}

/* A new descent: nothing is expanded, and the size of the scene in this view is known. */
static void startDescent(Traversal* t, const View* view) {
  const Tree* tree = t->tree;
  const int root = treeRoot(tree);
  const Bound* bound = &tree->bound[root];
  t->view = view;
  const double size = bound->surfaces < 0 ? 0 : sqrt(dot(bound->centre, bound->centre)) + bound->surfaces;
  double shift = 0;
  for (int i = 1; i < view->motionCount && view->motions != NULL; i++) {
    shift = larger(shift, sqrt(dot(view->motions[i].translation, view->motions[i].translation)));
  }
  t->extent = size + shift;
  t->band = DOUBLE_MARGIN * t->extent;
  if (++t->stamp == 0) {
    memset(t->itemStamp, 0, (size_t)tree->itemCount * sizeof(uint32_t));
    t->stamp = 1;
  }
  if (t->stillSurfaces != view->surfaces) {
    forgetStill(t);
    t->stillSurfaces = view->surfaces;
  }
  t->items.motion[root] = motionOf(view, 0, tree->slotCount);
  expand(t, treeTop(tree), root);
}

/* ---- The descent ---- */

typedef struct Visit {
  CandidateFunction* function;
  void* context;
  float reach;
  int64_t volumeTests;
  int64_t particleTests;
} Visit;

/* Those of this many members of item a that come near the volume of item b and are of another body; all if a is b. */
static unsigned nearItem(const Traversal* t, Visit* visit, const Spheres* members, int first, int count, int a, int b) {
  if (a == b) {
    return (1u << count) - 1;
  }
  visit->volumeTests += count;
  const Spheres* items = &t->items;
  const unsigned near = near16(members, first, items->x[b], items->y[b], items->z[b], items->r[b] + visit->reach);
  return near == 0 || t->view->everyPair || items->motion[b] == STRADDLES
             ? near
             : near & ~sameBody16(members, first, items->motion[b]);
}

static bool visitLeaves(Traversal* t, Visit* visit, int a, int b) {
  const Spheres* slots = &t->slots;
  int endA;
  int endB;
  const int beginA = treeSlots(t->tree, 0, a, &endA);
  const int beginB = treeSlots(t->tree, 0, b, &endB);
  unsigned near = nearItem(t, visit, slots, beginA, endA - beginA, a, b);
  for (; near != 0; near &= near - 1) {
    const int i = beginA + __builtin_ctz(near);
    unsigned mask = near16(slots, beginB, slots->x[i], slots->y[i], slots->z[i], slots->r[i] + visit->reach);
    visit->particleTests += endB - (a == b ? i + 1 : beginB);
    if (a == b) {
      mask &= ~0u << (i - beginA) << 1;
    }
    if (mask != 0 && !t->view->everyPair) {
      mask &= ~sameBody16(slots, beginB, slots->motion[i]);
    }
    for (; mask != 0; mask &= mask - 1) {
      const int j = beginB + __builtin_ctz(mask);
      if (!visit->function(visit->context, i, j, squaredDistance(t->position[i], t->position[j]))) {
        return false;
      }
    }
  }
  return true;
}

static void visitNodes(Traversal* t, Visit* visit, ItemPair pair, int* depth) {
  const Spheres* items = &t->items;
  const int below = pair.level - 1;
  int countA;
  int countB;
  const int firstA = treeChildren(t->tree, pair.level, pair.a, &countA);
  const int firstB = treeChildren(t->tree, pair.level, pair.b, &countB);
  unsigned near = nearItem(t, visit, items, firstA, countA, pair.a, pair.b);
  for (; near != 0; near &= near - 1) {
    const int i = firstA + __builtin_ctz(near);
    const int motion = items->motion[i];
    unsigned mask = near16(items, firstB, items->x[i], items->y[i], items->z[i], items->r[i] + visit->reach);
    visit->volumeTests += firstB + countB - (pair.a == pair.b ? i + 1 : firstB);
    if (mask != 0 && !t->view->everyPair && motion != STRADDLES) {
      mask &= ~sameBody16(items, firstB, motion);
    }
    if (pair.a == pair.b) {
      mask &= ~0u << (i - firstA) << 1;
      if (t->items.r[i] >= 0 && (t->view->everyPair || motion == STRADDLES)) {
        t->stack[(*depth)++] = (ItemPair){below, i, i};
      }
    }
    for (; mask != 0; mask &= mask - 1) {
      t->stack[(*depth)++] = (ItemPair){below, i, firstB + __builtin_ctz(mask)};
    }
  }
}

void ctTraverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  startDescent(t, view);
  const int root = treeRoot(t->tree);
  const double margin = FLOAT_MARGIN * (t->extent + fabs(view->reach));
  Visit visit = {function, context, (float)(view->reach + margin), 0, 0};
  int depth = 0;
  if (view->everyPair || t->items.motion[root] == STRADDLES) {
    t->stack[depth++] = (ItemPair){treeTop(t->tree), root, root};
  }
  bool goesOn = true;
  while (goesOn && depth > 0) {
    ItemPair pair = t->stack[--depth];
    if (t->items.motion[pair.b] == STRADDLES) {
      /* First go the members of the one that straddles: those that are of the other's body drop out. */
      pair = (ItemPair){pair.level, pair.b, pair.a};
    }
    expand(t, pair.level, pair.a);
    expand(t, pair.level, pair.b);
    if (pair.level == 0) {
      goesOn = visitLeaves(t, &visit, pair.a, pair.b);
    } else {
      visitNodes(t, &visit, pair, &depth);
    }
  }
  if (counts != NULL) {
    counts->volumeTests += visit.volumeTests;
    counts->particleTests += visit.particleTests;
  }
}

void ctTraverseProbe(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                     void* context, ctCounts* counts) {
  startDescent(t, view);
  const double size = t->extent + sqrt(dot(point, point)) + radius;
  const float reach = (float)(radius + view->reach + FLOAT_MARGIN * (size + fabs(view->reach)));
  const float x = (float)point[0];
  const float y = (float)point[1];
  const float z = (float)point[2];
  int depth = 0;
  t->stack[depth++] = (ItemPair){treeTop(t->tree), treeRoot(t->tree), CT_NULL};
  bool goesOn = true;
  while (goesOn && depth > 0) {
    const ItemPair item = t->stack[--depth];
    expand(t, item.level, item.a);
    if (item.level > 0) {
      int count;
      const int first = treeChildren(t->tree, item.level, item.a, &count);
      unsigned mask = near16(&t->items, first, x, y, z, reach);
      for (; mask != 0; mask &= mask - 1) {
        t->stack[depth++] = (ItemPair){item.level - 1, first + __builtin_ctz(mask), CT_NULL};
      }
      if (counts != NULL) {
        counts->volumeTests += count;
      }
      continue;
    }
    int end;
    const int begin = treeSlots(t->tree, 0, item.a, &end);
    unsigned mask = near16(&t->slots, begin, x, y, z, reach);
    for (; goesOn && mask != 0; mask &= mask - 1) {
      const int slot = begin + __builtin_ctz(mask);
      goesOn = function(context, slot, squaredDistance(t->position[slot], point));
    }
    if (counts != NULL) {
      counts->particleTests += end - begin;
    }
  }
}
