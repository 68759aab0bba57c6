/* The descent, compiled once for each instruction set by the file that includes this. */
#ifndef CT_DESCENT_BODY_H_
#define CT_DESCENT_BODY_H_

#include <string.h>

#include "descent.h"

static bool moves(const View* view, int motion) {
  return motion > 0 && view->motions != NULL;
}

/* Of which rigid body a member of an expanded item is, coded like Traversal.motion. */
static int motionOfMember(const Traversal* t, int item, int k) {
  const int code = t->motion[item];
  return code < 0 ? straddlerOf(t, code)->motion[k] : code;
}

/* ---- What this view makes of an item ---- */

/* Whether an item still has in the world all that it had when it was last put there. */
static bool isStill(const Traversal* t, int level, int item) {
  if (t->since[item] == t->tree->time) {
    return true;
  }
  if (t->since[item] == NEVER) {
    return false;
  }
  int end;
  treeSlots(t->tree, level, item, &end);
  return treeUnchanged(t->tree, t->since[item], (end + TREE_WIDTH - 1) / TREE_WIDTH);
}

static void restLeaf(Traversal* t, int leaf) {
  const Frame* f = &t->frame[leaf];
  const Leaf* own = &t->tree->leaf[leaf];
  Block* rest = &t->rest[leaf];
  for (int k = 0; k < TREE_WIDTH; k++) {
    const double x = own->x[k];
    const double y = own->y[k];
    const double z = own->z[k];
    rest->x[k] = (float)(f->m[0][0] * x + f->m[0][1] * y + f->m[0][2] * z + f->m[0][3]);
    rest->y[k] = (float)(f->m[1][0] * x + f->m[1][1] * y + f->m[1][2] * z + f->m[1][3]);
    rest->z[k] = (float)(f->m[2][0] * x + f->m[2][1] * y + f->m[2][2] * z + f->m[2][3]);
  }
  memcpy(rest->r, t->view->surfaces ? own->r : own->centres, sizeof rest->r);
}

static void floatMotion(const Frame* f, float motion[12]) {
  const double* m = f->m[0];
  for (int i = 0; i < 12; i++) {
    motion[i] = (float)m[i];
  }
}

static void restNode(Traversal* t, int item) {
  const Members* own = treeMembers(t->tree, item);
  Block* rest = &t->rest[item];
  float motion[12];
  floatMotion(&t->frame[item], motion);
  moveBlock(&own->block, motion, 0xffff, rest);
  memcpy(rest->r, t->view->surfaces ? own->block.r : own->centres, sizeof rest->r);
}

/* Puts the members of an item into the world as the state has them. Its parent has been there before. */
static void putToRest(Traversal* t, int level, int item) {
  if (isStill(t, level, item)) {
    return;
  }
  const Tree* tree = t->tree;
  t->since[item] = tree->time;
  if (level == treeTop(tree)) {
    t->frame[item] = tree->pose[item];
  } else {
    t->frame[item] = transformCompose(&t->frame[treeParent(tree, level, item)], &tree->pose[item]);
  }
  if (level == 0) {
    restLeaf(t, item);
  } else {
    restNode(t, item);
  }
}

/* Once a descent. Its parent has been expanded. */
static void expand(Traversal* t, int level, int item) {
  if (t->itemStamp[item] == t->stamp) {
    return;
  }
  t->itemStamp[item] = t->stamp;
  putToRest(t, level, item);
  const int motion = t->motion[item];
  if (moves(t->view, motion)) {
    moveBlock(&t->rest[item], t->motions[motion], 0xffff, &t->moved[item]);
    memcpy(t->moved[item].r, t->rest[item].r, sizeof t->moved[item].r);
  }
}

static Sphere boundOfStraddler(const Traversal* t, const Straddler* s) {
  Sphere bound = middleOfBlock(&s->block);
  /* Straddlers lie within straddlers: each level adds its own rounding. */
  bound.r += radiusAbout(bound, &s->block, s->block.r) + (float)(FLOAT_MARGIN * t->extent);
  return bound;
}

/* An item that straddles pieces, and all such below it; `piece` holds its first slot. */
static const Straddler* expandStraddler(Traversal* t, int level, int item, int piece) {
  const View* view = t->view;
  const Tree* tree = t->tree;
  t->itemStamp[item] = t->stamp;
  t->motion[item] = straddlerCode(t->straddlerCount);
  Straddler* s = &t->straddlers[t->straddlerCount++];
  s->item = item;
  putToRest(t, level, item);
  s->block = t->rest[item];
  int end;
  const int begin = treeSlots(tree, level, item, &end);
  const int width = 1 << TREE_WIDTH_BITS * level;
  const int first = level == 0 ? 0 : tree->levelBegin[level - 1] + begin / width;
  const int count = (end - begin + width - 1) / width;
  int k = 0;
  while (k < count) {
    const int from = begin + k * width;
    while (piece + 1 < view->pieceCount && view->pieces[piece + 1].slotBegin <= from) {
      piece++;
    }
    const int next = piece + 1 < view->pieceCount ? view->pieces[piece + 1].slotBegin : end;
    const int wholes = next < end ? (next - begin) / width : count;
    if (wholes > k) {
      const int motion = view->pieces[piece].motion;
      if (moves(view, motion)) {
        moveBlock(&t->rest[item], t->motions[motion], (1u << wholes) - (1u << k), &s->block);
      }
      while (k < wholes) {
        s->motion[k++] = motion;
      }
    } else if (level > 0) { /* a slot straddles nothing */
      const Sphere bound = boundOfStraddler(t, expandStraddler(t, level - 1, first + k, piece));
      s->block.x[k] = bound.x;
      s->block.y[k] = bound.y;
      s->block.z[k] = bound.z;
      s->block.r[k] = bound.r;
      s->motion[k] = t->motion[first + k];
      k++;
    }
  }
  for (; k < TREE_WIDTH; k++) {
    s->motion[k] = 0;
  }
  return s;
}

/* A new view: its motions, and how large the scene is in it. */
static void startView(Traversal* t, const View* view) {
  const Tree* tree = t->tree;
  const int root = treeRoot(tree);
  const Bound* bound = &tree->bound[root];
  const double centre[3] = {bound->x, bound->y, bound->z};
  t->view = view;
  const double size = bound->r < 0 ? 0 : sqrt(dot(centre, centre)) + (double)bound->r;
  double shift = 0;
  if (view->motions != NULL) {
    for (int i = 1; i < view->motionCount; i++) {
      double translation[3];
      translationOf(&view->motions[i], translation);
      shift = larger(shift, sqrt(dot(translation, translation)));
      floatMotion(&view->motions[i], t->motions[i]);
    }
  }
  t->extent = size + shift;
  t->band = DOUBLE_MARGIN * t->extent;
  if (++t->stamp == 0) {
    memset(t->itemStamp, 0, (size_t)tree->itemCount * sizeof(uint32_t));
    t->stamp = 1;
  }
  if (t->sinceSurfaces != view->surfaces) {
    for (int item = 0; item < tree->itemCount; item++) {
      t->since[item] = NEVER;
    }
    t->sinceSurfaces = view->surfaces;
  }
  t->straddlerCount = 0;
}

/* A new descent: nothing is expanded but the root and what straddles. */
static void startDescent(Traversal* t, const View* view) {
  const Tree* tree = t->tree;
  const int root = treeRoot(tree);
  startView(t, view);
  if (view->pieceCount > 1) {
    expandStraddler(t, treeTop(tree), root, 0);
  } else {
    t->motion[root] = view->pieces[0].motion;
    expand(t, treeTop(tree), root);
  }
}

/* ---- Boxes ---- */

static NodeBoxes* boxesOf(const Traversal* t, int node) {
  return &t->boxes[node - t->tree->levelBegin[1]];
}

/* Around the members of an item in its own frame; with it, the boxes of its children. */
static const Box* ownBox(Traversal* t, int level, int item) {
  const Tree* tree = t->tree;
  Box* box = &t->box[item];
  if (!tree->isFresh[item]) {
    return box;
  }
  tree->isFresh[item] = false;
  if (level == 0) {
    Block block;
    leafBlock(&tree->leaf[item], &block);
    *box = boxAround(&block, 0, NULL, &tree->bound[item]);
    return box;
  }
  NodeBoxes* boxes = boxesOf(t, item);
  Box inner[TREE_WIDTH];
  boxes->thin = 0;
  boxes->since = NEVER;
  int count;
  const int first = treeChildren(tree, level, item, &count);
  for (int k = 0; k < count; k++) {
    if (tree->bound[first + k].r >= 0) {
      float pose[12];
      floatMotion(&tree->pose[first + k], pose);
      const Box* own = ownBox(t, level - 1, first + k);
      inner[k] = movedBox(own, pose);
      boxes->thin |= (unsigned)own->thin << k;
      putBox(&boxes->own, k, &inner[k]);
    }
  }
  *box = boxAround(&treeMembers(tree, item)->block, boxes->thin, inner, &tree->bound[item]);
  return box;
}

static BoxBlock* boxesInView(Traversal* t, int level, int node);

/* Around the members of an item that straddles, in the view. */
static Box straddlerBox(Traversal* t, int level, int item) {
  const Block* block = &straddlerOf(t, t->motion[item])->block;
  const Sphere middle = middleOfBlock(block);
  const Bound bound = {middle.x, middle.y, middle.z, middle.r + radiusAbout(middle, block, block->r), 0};
  if (level == 0 || bound.r < 0) {
    return boxAround(block, 0, NULL, &bound);
  }
  const BoxBlock* inView = boxesInView(t, level, item);
  Box inner[TREE_WIDTH];
  for (int k = 0; k < TREE_WIDTH; k++) {
    inner[k] = boxOf(inView, k);
  }
  return boxAround(block, boxesOf(t, item)->thinInView, inner, &bound);
}

/* Boxes of the children of an expanded node, in the view. */
static BoxBlock* boxesInView(Traversal* t, int level, int node) {
  NodeBoxes* boxes = boxesOf(t, node);
  ownBox(t, level, node);
  if (boxes->since != t->since[node]) {
    boxes->since = t->since[node];
    float frame[12];
    floatMotion(&t->frame[node], frame);
    boxes->rest = boxes->own;
    moveBoxes(&boxes->own, frame, 0xffff, &boxes->rest);
  }
  const int code = t->motion[node];
  if (code == 0 || (code > 0 && t->view->motions == NULL)) {
    boxes->thinInView = boxes->thin;
    return &boxes->rest;
  }
  if (boxes->stamp != t->stamp) {
    boxes->stamp = t->stamp;
    boxes->moved = boxes->rest;
    boxes->thinInView = boxes->thin;
    for (int k = 0; k < TREE_WIDTH;) {
      /* Children that move alike go together. */
      const int motion = motionOfMember(t, node, k);
      unsigned run = 0;
      for (; k < TREE_WIDTH && motion == motionOfMember(t, node, k); k++) {
        run |= 1u << k;
      }
      if (moves(t->view, motion)) {
        moveBoxes(&boxes->rest, t->motions[motion], run, &boxes->moved);
      } else if (motion < 0) {
        const int child = __builtin_ctz(run);
        const Box box = straddlerBox(t, level - 1, straddlerOf(t, motion)->item);
        putBox(&boxes->moved, child, &box);
        boxes->thinInView = (boxes->thinInView & ~run) | (unsigned)box.thin << child;
      }
    }
  }
  return &boxes->moved;
}

/* ---- The descent ---- */

typedef struct Visit {
  CandidateFunction* function;
  void* context;
  float reach;
  bool boxes; /* are to be looked at */
  int pairsBoxed;
  int pairsParted;
  int64_t volumeTests;
  int64_t particleTests;
} Visit;

/* An expanded item: its members as they lie in the view. */
static const Block* blockOf(const Traversal* t, int item) {
  const int code = t->motion[item];
  if (code < 0) {
    return &straddlerOf(t, code)->block;
  }
  return moves(t->view, code) ? &t->moved[item] : &t->rest[item];
}

/* Members of an item that are of a rigid body; none, if that straddles. */
static unsigned ofBody(const Traversal* t, int item, int motion) {
  const int code = t->motion[item];
  if (motion < 0) {
    return 0;
  }
  if (code >= 0) {
    return code == motion ? 0xffff : 0;
  }
  return equal16(straddlerOf(t, code)->motion, motion);
}

/* Those of the members of item a that come near the volume of item b and are of another body; all if a is b. */
static unsigned nearItem(const Traversal* t, Visit* visit, const Block* members, int count, const ItemPair* pair) {
  if (pair->a == pair->b) {
    return (1u << count) - 1;
  }
  visit->volumeTests += count;
  const Block* around = blockOf(t, treeParent(t->tree, pair->level, pair->b));
  const Sphere sphere = sphereOf(around, pair->b % TREE_WIDTH);
  return near16(members, sphere, visit->reach) & ~ofBody(t, pair->a, t->motion[pair->b]);
}

/* The boxes among which that of an item is, at its own place; NULL if it has none of use. */
static BoxBlock* boxesAround(Traversal* t, const ItemPair* pair) {
  if (pair->a == pair->b) {
    return NULL;
  }
  const int parent = treeParent(t->tree, pair->level, pair->b);
  BoxBlock* boxes = boxesInView(t, pair->level + 1, parent);
  return (boxesOf(t, parent)->thinInView >> pair->b % TREE_WIDTH & 1) != 0 ? boxes : NULL;
}

static bool visitLeaves(Traversal* t, Visit* visit, const ItemPair* pair) {
  const int a = pair->a;
  const int b = pair->b;
  int endA;
  int endB;
  const int beginA = treeSlots(t->tree, 0, a, &endA);
  const int beginB = treeSlots(t->tree, 0, b, &endB);
  const Block* blockA = blockOf(t, a);
  unsigned near = nearItem(t, visit, blockA, endA - beginA, pair);
  BoxBlock* around = visit->boxes && near != 0 ? boxesAround(t, pair) : NULL;
  if (around != NULL) {
    near &= nearBox(blockA, around, b % TREE_WIDTH, visit->reach);
  }
  if (near == 0) {
    return true;
  }
  expand(t, 0, b);
  const Block* blockB = blockOf(t, b);
  const int partner = exclusionPartner(t->exclusions, a, b);
  for (; near != 0; near &= near - 1) {
    const int k = __builtin_ctz(near);
    const int i = beginA + k;
    unsigned mask = near16(blockB, sphereOf(blockA, k), visit->reach);
    visit->particleTests += endB - (a == b ? i + 1 : beginB);
    if (a == b) {
      mask &= ~0u << k << 1;
    }
    if (mask != 0) {
      mask &= ~ofBody(t, b, motionOfMember(t, a, k));
    }
    if (partner != CT_NULL) {
      mask &= ~(unsigned)t->exclusions->mask[partner][k];
    }
    for (; mask != 0; mask &= mask - 1) {
      const int j = beginB + __builtin_ctz(mask);
      if (!visit->function(visit->context, i, j, ctTraversalSquaredDistance(t, i, j))) {
        return false;
      }
    }
  }
  return true;
}

/* Which of these children of node b the boxes part from child k of node a. */
static unsigned boxesPart(Traversal* t, Visit* visit, const ItemPair* pair, int k, unsigned mask, BoxBlock* a,
                          BoxBlock* b) {
  visit->pairsBoxed += __builtin_popcount(mask);
  if ((boxesOf(t, pair->a)->thinInView >> k & 1) == 0) {
    mask &= boxesOf(t, pair->b)->thinInView;
  }
  if (mask == 0) {
    return 0;
  }
  visit->volumeTests += __builtin_popcount(mask);
  mask &= boxesApart(a, k, b, visit->reach);
  visit->pairsParted += __builtin_popcount(mask);
  return mask;
}

static void visitNodes(Traversal* t, Visit* visit, const ItemPair* pair, int* depth) {
  const int below = pair->level - 1;
  int countA;
  int countB;
  const int firstA = treeChildren(t->tree, pair->level, pair->a, &countA);
  const int firstB = treeChildren(t->tree, pair->level, pair->b, &countB);
  const Block* blockA = blockOf(t, pair->a);
  unsigned near = nearItem(t, visit, blockA, countA, pair);
  if (near == 0) {
    return;
  }
  expand(t, pair->level, pair->b);
  const Block* blockB = blockOf(t, pair->b);
  BoxBlock* boxesA = NULL;
  BoxBlock* boxesB = NULL;
  if (visit->boxes) {
    boxesA = boxesInView(t, pair->level, pair->a);
    boxesB = boxesInView(t, pair->level, pair->b);
    BoxBlock* around = boxesAround(t, pair);
    if (around != NULL) {
      near &= ~boxesApart(around, pair->b % TREE_WIDTH, boxesA, visit->reach);
    }
  }
  for (; near != 0; near &= near - 1) {
    const int k = __builtin_ctz(near);
    const int i = firstA + k;
    const int motion = motionOfMember(t, pair->a, k);
    t->motion[i] = motion;
    unsigned mask = near16(blockB, sphereOf(blockA, k), visit->reach);
    if (pair->a == pair->b) {
      mask &= ~0u << k << 1;
      visit->volumeTests += countB - k - 1;
      if (blockA->r[k] >= 0 && motion < 0) {
        t->stack[(*depth)++] = (ItemPair){below, i, i};
      }
    } else {
      visit->volumeTests += countB;
    }
    if (mask != 0) {
      mask &= ~ofBody(t, pair->b, motion);
    }
    if (mask != 0 && visit->boxes) {
      mask &= ~boxesPart(t, visit, pair, k, mask, boxesA, boxesB);
    }
    for (; mask != 0; mask &= mask - 1) {
      const int l = __builtin_ctz(mask);
      t->motion[firstB + l] = motionOfMember(t, pair->b, l);
      t->stack[(*depth)++] = (ItemPair){below, i, firstB + l};
    }
  }
}

static void traverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  startDescent(t, view);
  const int root = treeRoot(t->tree);
  const double margin = FLOAT_MARGIN * (t->extent + fabs(view->reach));
  Visit visit = {function, context, (float)(view->reach + margin), false, 0, 0, 0, 0};
  int depth = 0;
  if (t->motion[root] < 0) {
    t->stack[depth++] = (ItemPair){treeTop(t->tree), root, root};
  }
  bool goesOn = true;
  for (int visits = 0; goesOn && depth > 0; visits++) {
    ItemPair pair = t->stack[--depth];
    if (t->motion[pair.b] < 0 || (t->itemStamp[pair.b] == t->stamp && t->motion[pair.a] >= 0)) {
      /* First go the members of the one that straddles: those that are of the other's body drop out. Otherwise those of
       * one that is expanded: then the other may never have to be. */
      pair = (ItemPair){pair.level, pair.b, pair.a};
    }
    expand(t, pair.level, pair.a);
    visit.boxes = t->alwaysBoxes || visits >= t->visitsWithoutBoxes;
    if (pair.level == 0) {
      goesOn = visitLeaves(t, &visit, &pair);
    } else {
      visitNodes(t, &visit, &pair, &depth);
    }
  }
  if (visit.pairsBoxed > 0) {
    const bool pays = 4 * visit.pairsParted > visit.pairsBoxed;
    const int next = pays ? t->visitsWithoutBoxes / 2 : t->visitsWithoutBoxes * 2;
    t->visitsWithoutBoxes = next < FEWEST_VISITS_WITHOUT_BOXES ? FEWEST_VISITS_WITHOUT_BOXES
                            : next > MOST_VISITS_WITHOUT_BOXES ? MOST_VISITS_WITHOUT_BOXES
                                                               : next;
  }
  if (counts != NULL) {
    counts->volumeTests += visit.volumeTests;
    counts->particleTests += visit.particleTests;
  }
}

static void traverseProbe(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                          void* context, ctCounts* counts) {
  startDescent(t, view);
  const double size = t->extent + sqrt(dot(point, point)) + radius;
  const float reach = (float)(view->reach + FLOAT_MARGIN * (size + fabs(view->reach)));
  const Sphere probe = {(float)point[0], (float)point[1], (float)point[2], (float)radius};
  int depth = 0;
  t->stack[depth++] = (ItemPair){treeTop(t->tree), treeRoot(t->tree), CT_NULL};
  bool goesOn = true;
  while (goesOn && depth > 0) {
    const ItemPair item = t->stack[--depth];
    expand(t, item.level, item.a);
    unsigned mask = near16(&t->rest[item.a], probe, reach);
    if (item.level > 0) {
      int count;
      const int first = treeChildren(t->tree, item.level, item.a, &count);
      for (; mask != 0; mask &= mask - 1) {
        const int child = first + __builtin_ctz(mask);
        t->motion[child] = 0;
        t->stack[depth++] = (ItemPair){item.level - 1, child, CT_NULL};
      }
      if (counts != NULL) {
        counts->volumeTests += count;
      }
      continue;
    }
    int end;
    const int begin = treeSlots(t->tree, 0, item.a, &end);
    for (; goesOn && mask != 0; mask &= mask - 1) {
      const int slot = begin + __builtin_ctz(mask);
      double x[3];
      ctTraversalPosition(t, slot, x);
      goesOn = function(context, slot, squaredDistance(x, point));
    }
    if (counts != NULL) {
      counts->particleTests += end - begin;
    }
  }
}

#endif /* CT_DESCENT_BODY_H_ */
