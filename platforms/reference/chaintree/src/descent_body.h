/* The descent, compiled once for each instruction set by the file that includes this. */
#ifndef CT_DESCENT_BODY_H_
#define CT_DESCENT_BODY_H_

#include "view_body.h"

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
  unsigned thin = 0;
  bool moved = false;
  int count;
  const int first = treeChildren(tree, level, item, &count);
  for (int k = 0; k < count; k++) {
    const int child = first + k;
    moved = moved || (k > 0 && tree->shortcutTime[child - 1] > boxes->ownTime);
    if (tree->bound[child].r < 0) {
      continue;
    }
    if (!moved && tree->contentTime[child] <= boxes->ownTime) {
      inner[k] = boxOf(&boxes->own, k);
      thin |= boxes->thin & 1u << k;
      continue;
    }
    float pose[12];
    floatMotion(&tree->pose[child], pose);
    const Box* own = ownBox(t, level - 1, child);
    inner[k] = movedBox(own, pose);
    thin |= (unsigned)own->thin << k;
    putBox(&boxes->own, k, &inner[k]);
  }
  boxes->thin = thin;
  boxes->ownTime = tree->time;
  boxes->restSince = NEVER;
  /* Nothing is around the root. */
  if (level < treeTop(tree)) {
    *box = boxAround(&treeMembers(tree, item)->block, thin, inner, &tree->bound[item]);
  }
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
  if (boxes->restSince != t->since[node]) {
    boxes->restSince = t->since[node];
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

/* What a descent begins with: the root and what straddles. */
static void expandRoot(Traversal* t) {
  const View* view = t->view;
  const int root = treeRoot(t->tree);
  if (view->pieceCount > 1) {
    expandStraddler(t, treeTop(t->tree), root, 0);
  } else {
    t->motion[root] = view->pieces[0].motion;
    expand(t, treeTop(t->tree), root);
  }
}

typedef struct Visit {
  CandidateFunction* function;
  void* context;
  float reach;
  bool boxes; /* are to be looked at */
  int pairsBoxed;
  int pairsParted;
  int64_t boxTests; /* of the tests of volumes */
  int64_t volumeTests;
  int64_t particleTests;
} Visit;

/* Members of a that are not of the body that its first or its last member is of, whichever has more of them: in a visit
 * of an item with itself those are enough. */
static unsigned ofLesserBodies(const Traversal* t, int item, int count) {
  const unsigned all = (1u << count) - 1;
  const unsigned first = all & ~ofBody(t, item, motionOfMember(t, item, 0));
  const unsigned last = all & ~ofBody(t, item, motionOfMember(t, item, count - 1));
  return __builtin_popcount(first) <= __builtin_popcount(last) ? first : last;
}

/* Those of the members of item a that come near the volume of item b and are of another body; if a is b, those
 * whose visits are enough. */
static unsigned nearItem(const Traversal* t, Visit* visit, const Block* members, int count, const ItemPair* pair) {
  if (pair->a == pair->b) {
    return ofLesserBodies(t, pair->a, count);
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

/* In a visit of an item with itself, members whose pairs with member k of `rows` belong to an earlier one of those. */
static unsigned alreadyVisited(unsigned rows, int k) {
  return rows & ((2u << k) - 1);
}

/* These members of leaf a, expanded, with all of leaf b. */
static bool testMembers(Traversal* t, Visit* visit, int a, int b, unsigned rows) {
  int endB;
  const int beginB = treeSlots(t->tree, 0, b, &endB);
  expand(t, 0, b);
  const Block* blockA = blockOf(t, a);
  const Block* blockB = blockOf(t, b);
  const int partner = exclusionPartner(t->exclusions, a, b);
  for (unsigned left = rows; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const int i = a * TREE_WIDTH + k;
    unsigned mask = near16(blockB, sphereOf(blockA, k), visit->reach);
    visit->particleTests += endB - beginB;
    if (a == b) {
      mask &= ~alreadyVisited(rows, k);
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

static bool visitLeaves(Traversal* t, Visit* visit, const ItemPair* pair) {
  int endA;
  const int beginA = treeSlots(t->tree, 0, pair->a, &endA);
  const Block* blockA = blockOf(t, pair->a);
  unsigned near = nearItem(t, visit, blockA, endA - beginA, pair);
  BoxBlock* around = visit->boxes && near != 0 ? boxesAround(t, pair) : NULL;
  if (around != NULL) {
    near &= nearBox(blockA, around, pair->b % TREE_WIDTH, visit->reach);
  }
  return near == 0 || testMembers(t, visit, pair->a, pair->b, near);
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
  visit->boxTests += __builtin_popcount(mask);
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
  for (unsigned left = near; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const int i = firstA + k;
    const int motion = motionOfMember(t, pair->a, k);
    t->motion[i] = motion;
    unsigned mask = near16(blockB, sphereOf(blockA, k), visit->reach);
    visit->volumeTests += countB;
    if (pair->a == pair->b) {
      mask &= ~alreadyVisited(near, k);
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
    /* Comes first: near a joint all is dense, and clashes are likely. */
    if (pair->a == pair->b && blockA->r[k] >= 0 && motion < 0) {
      t->stack[(*depth)++] = (ItemPair){below, i, i};
    }
  }
}

/* The whole tree against itself. */
static void descend(Traversal* t, Visit* visit) {
  const int root = treeRoot(t->tree);
  expandRoot(t);
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
    visit->boxes = t->alwaysBoxes || visits >= t->visitsWithoutBoxes;
    if (pair.level == 0) {
      goesOn = visitLeaves(t, visit, &pair);
    } else {
      visitNodes(t, visit, &pair, &depth);
    }
  }
  if (visit->pairsBoxed > 0) {
    const bool pays = 4 * visit->pairsParted > visit->pairsBoxed;
    const int next = pays ? t->visitsWithoutBoxes / 2 : t->visitsWithoutBoxes * 2;
    t->visitsWithoutBoxes = next < FEWEST_VISITS_WITHOUT_BOXES ? FEWEST_VISITS_WITHOUT_BOXES
                            : next > MOST_VISITS_WITHOUT_BOXES ? MOST_VISITS_WITHOUT_BOXES
                                                               : next;
  }
}

/* ---- Few that move ---- */

/* Slots in a row that move, as they lie in the view: those of [begin, end) among sixteen. */
typedef struct Movers {
  int begin;
  int end;
  int first; /* of the sixteen; the others are empty */
  Block block;
} Movers;

/* Bit k: slot first + k of sixteen is in [begin, end). */
static unsigned slotBits(int begin, int end, int first) {
  const int low = begin > first ? begin - first : 0;
  const int high = end - first < TREE_WIDTH ? end - first : TREE_WIDTH;
  return low < high ? (1u << high) - (1u << low) : 0;
}

/* Sixteen slots from any one on, as they are at rest; what is behind slot `end` may be anything that is a number. */
static void restOfSlots(const Traversal* t, int first, int end, Block* rest) {
  const Block* below = &t->rest[first / TREE_WIDTH];
  const int at = first % TREE_WIDTH;
  if (at == 0) {
    *rest = *below;
    return;
  }
  const Block* above = below + ((first / TREE_WIDTH + 1) * TREE_WIDTH < end);
  float row[2 * TREE_WIDTH];
  const float* const from[4][2] = {
      {below->x, above->x}, {below->y, above->y}, {below->z, above->z}, {below->r, above->r}};
  float* const to[4] = {rest->x, rest->y, rest->z, rest->r};
  for (int d = 0; d < 4; d++) {
    store16(row, load16(from[d][0]));
    store16(row + TREE_WIDTH, load16(from[d][1]));
    store16(to[d], load16(row + at));
  }
}

static void takeMovers(const Traversal* t, int begin, int end, int first, Movers* movers) {
  const View* view = t->view;
  Block rest;
  restOfSlots(t, first, end, &rest);
  store16(rest.r, blend16(slotBits(begin, end, first), all16(-INFINITY), load16(rest.r)));
  movers->begin = begin;
  movers->end = end;
  movers->first = first;
  movers->block = rest;
  for (int p = pieceOf(view, begin); p < view->pieceCount && view->pieces[p].slotBegin < end; p++) {
    if (moves(view, view->pieces[p].motion)) {
      moveBlock(&rest, t->motions[view->pieces[p].motion], slotBits(view->pieces[p].slotBegin, end, first),
                &movers->block);
    }
  }
}

/* Hands over the pairs of a slot with these of sixteen others of one leaf that are not excluded; whether the search
 * goes on. */
static bool meet(Traversal* t, Visit* visit, int slot, unsigned others, int leaf) {
  const int partner = exclusionPartner(t->exclusions, slot / TREE_WIDTH, leaf);
  if (partner != CT_NULL) {
    others &= ~(unsigned)t->exclusions->mask[partner][slot % TREE_WIDTH];
  }
  for (; others != 0; others &= others - 1) {
    const int other = leaf * TREE_WIDTH + __builtin_ctz(others);
    double a[3];
    double b[3];
    ctPositionInView(t, slot, motionOfSlot(t->view, slot), a);
    ctPositionInView(t, other, motionOfSlot(t->view, other), b);
    if (!visit->function(visit->context, slot, other, squaredDistance(a, b))) {
      return false;
    }
  }
  return true;
}

/* Which of sixteen are near any of the movers. How many are near each of them is hard to foresee, and a processor that
 * guesses wrong waits: so all are looked at. */
static unsigned nearMovers(const Block* block, const Movers* movers, float reach) {
  unsigned near = 0;
  for (int k = movers->begin - movers->first; k < movers->end - movers->first; k++) {
    near |= near16(block, sphereOf(&movers->block, k), reach);
  }
  return near;
}

/* Movers against a leaf that is at rest, but for those of its slots that move. */
static bool testLeaf(Traversal* t, Visit* visit, const Movers* movers, int leaf, unsigned moved) {
  const Block* rest = &t->rest[leaf];
  visit->particleTests += (movers->end - movers->begin) * TREE_WIDTH;
  if ((nearMovers(rest, movers, visit->reach) & ~moved) == 0) {
    return true;
  }
  for (int slot = movers->begin; slot < movers->end; slot++) {
    const unsigned near = near16(rest, sphereOf(&movers->block, slot - movers->first), visit->reach) & ~moved;
    if (near != 0 && !meet(t, visit, slot, near, leaf)) {
      return false;
    }
  }
  return true;
}

/* A mover against those of others that are in [begin, end). */
static bool testMover(Traversal* t, Visit* visit, const Movers* movers, int slot, const Movers* others, int begin,
                      int end) {
  visit->particleTests += TREE_WIDTH;
  unsigned near = near16(&others->block, sphereOf(&movers->block, slot - movers->first), visit->reach) &
                  slotBits(begin, end, others->first);
  for (; near != 0; near &= near - 1) {
    const int other = others->first + __builtin_ctz(near);
    if (!meet(t, visit, slot, 1u << other % TREE_WIDTH, other / TREE_WIDTH)) {
      return false;
    }
  }
  return true;
}

/* Movers against those among others that come after them and move otherwise. */
static bool testMovers(Traversal* t, Visit* visit, const Movers* movers, const Movers* others) {
  const View* view = t->view;
  for (int slot = movers->begin; slot < movers->end; slot++) {
    const int own = pieceOf(view, slot);
    for (int p = pieceOf(view, others->end - 1); p > own; p--) {
      const int end = p + 1 < view->pieceCount ? view->pieces[p + 1].slotBegin : others->end;
      if (view->pieces[p].motion != view->pieces[own].motion &&
          !testMover(t, visit, movers, slot, others, view->pieces[p].slotBegin, end)) {
        return false;
      }
    }
  }
  return true;
}

/* Movers against all that rests, which is what is not in [begin, end). */
static bool probeMovers(Traversal* t, Visit* visit, const Movers* movers, int begin, int end) {
  const Tree* tree = t->tree;
  const int firstLeaf = begin / TREE_WIDTH;
  const int lastLeaf = (end - 1) / TREE_WIDTH;
  for (int leaf = firstLeaf; leaf <= lastLeaf; leaf++) {
    if (!testLeaf(t, visit, movers, leaf, slotBits(begin, end, leaf * TREE_WIDTH))) {
      return false;
    }
  }
  /* From the lowest level of few nodes on: what is above would part little. */
  int top = treeTop(tree);
  for (; top > 1 && tree->levelSize[top - 1] <= 2 * TREE_WIDTH; top--) {
    for (int i = 0; i < tree->levelSize[top]; i++) {
      putToRest(t, top, tree->levelBegin[top] + i);
    }
  }
  int* items = t->nearItems; /* level by level */
  int count = 0;
  for (int i = 0; i < tree->levelSize[top]; i++) {
    items[count++] = tree->levelBegin[top] + i;
  }
  Sphere sphere = middleOfBlock(&movers->block);
  sphere.r += radiusAbout(sphere, &movers->block, movers->block.r) + (float)floatMargin(t->extent);
  int done = 0;
  for (int level = top; level > 0; level--) {
    const int last = count;
    for (int i = done; i < last; i++) {
      putToRest(t, level, items[i]);
    }
    for (; done < last; done++) {
      const int first = tree->levelBegin[level - 1] + (items[done] - tree->levelBegin[level]) * TREE_WIDTH;
      count += indices16(near16(&t->rest[items[done]], sphere, visit->reach), first, items + count);
      visit->volumeTests += TREE_WIDTH;
    }
  }
  for (; done < count; done++) {
    const int leaf = items[done];
    if (firstLeaf <= leaf && leaf <= lastLeaf) {
      continue;
    }
    putToRest(t, 0, leaf);
    if (!testLeaf(t, visit, movers, leaf, 0)) {
      return false;
    }
  }
  return true;
}

/* What moves is some slots in a row, few enough to go against all others one by one: no volume is made for what
 * straddles. */
static void visitFew(Traversal* t, Visit* visit, int begin, int end) {
  for (int leaf = begin / TREE_WIDTH; leaf * TREE_WIDTH < end; leaf++) {
    putLeafToRest(t, leaf);
  }
  const bool areInOneLeaf = begin / TREE_WIDTH == (end - 1) / TREE_WIDTH;
  Movers movers[MOST_MOVERS / TREE_WIDTH];
  int count = 0;
  for (int slot = begin; slot < end; slot = movers[count++].end) {
    const int next = slot + TREE_WIDTH < end ? slot + TREE_WIDTH : end;
    takeMovers(t, slot, next, areInOneLeaf ? slot / TREE_WIDTH * TREE_WIDTH : slot, &movers[count]);
  }
  for (int i = 0; i < count; i++) {
    if (!probeMovers(t, visit, &movers[i], begin, end)) {
      return;
    }
  }
  for (int i = 0; i < count && pieceOf(t->view, begin) != pieceOf(t->view, end - 1); i++) {
    for (int j = i; j < count; j++) {
      if (!testMovers(t, visit, &movers[i], &movers[j])) {
        return;
      }
    }
  }
}

static int64_t traverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  startView(t, view);
  const double margin = floatMargin(t->extent + fabs(view->reach));
  Visit visit = {function, context, (float)(view->reach + margin), false, 0, 0, 0, 0, 0};
  int slotBegin;
  int slotEnd;
  if (ctViewMovesFew(t, view, &slotBegin, &slotEnd)) {
    visitFew(t, &visit, slotBegin, slotEnd);
  } else {
    descend(t, &visit);
  }
  if (counts != NULL) {
    counts->volumeTests += visit.volumeTests;
    counts->particleTests += visit.particleTests;
  }
  return visit.volumeTests + visit.particleTests + 2 * visit.boxTests;
}

static void traverseProbe(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                          void* context, ctCounts* counts) {
  startView(t, view);
  expandRoot(t);
  const double size = t->extent + sqrt(dot(point, point)) + radius;
  const float reach = (float)(view->reach + floatMargin(size + fabs(view->reach)));
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
