/* Trials that move a few slots in a row: these are tested one by one against everything at rest. Compiled once for each
 * instruction set by the file that includes this. */
#ifndef CT_MOVERS_BODY_H_
#define CT_MOVERS_BODY_H_

#include "view_body.h"

/* The box around the centres of movers, along the world's axes. */
typedef struct MoverBox {
  float low[3];
  float high[3];
  float r; /* the largest radius */
} MoverBox;

/* Slots [begin, end), which move, in the view, among sixteen. */
typedef struct Movers {
  int begin;
  int end;
  int first;     /* of the sixteen; the others are empty */
  int leaf;      /* of begin */
  unsigned bits; /* of begin to end */
  MoverBox box;
  Block block;
} Movers;

/* Bit k: slot first + k of sixteen is in [begin, end). */
static unsigned slotBits(int begin, int end, int first) {
  const int low = begin > first ? begin - first : 0;
  const int high = end - first < TREE_WIDTH ? end - first : TREE_WIDTH;
  return low < high ? (1u << high) - (1u << low) : 0;
}

/* World coordinates of sixteen slots from any one on. Those of slot `end` and later ones may be any numbers. Writes to
 * `own` if they are of two leaves. */
static const Block* worldOfSlots(Traversal* t, int first, int end, Block* own) {
  const int leaf = first / TREE_WIDTH;
  const int at = first % TREE_WIDTH;
  if (at == 0) {
    return worldOf(t, leaf);
  }
  const int next = leaf + ((leaf + 1) * TREE_WIDTH < end);
  worldOf(t, leaf);
  const Block* above = worldOf(t, next);
  const Block* below = worldOf(t, leaf); /* again, as in blocksOf */
  float row[2 * TREE_WIDTH];
  const float* const from[4][2] = {
      {below->x, above->x}, {below->y, above->y}, {below->z, above->z}, {below->r, above->r}};
  float* const to[4] = {own->x, own->y, own->z, own->r};
  for (int d = 0; d < 4; d++) {
    store16(row, load16(from[d][0]));
    store16(row + TREE_WIDTH, load16(from[d][1]));
    store16(to[d], load16(row + at));
  }
  return own;
}

/* If there are no particles, nothing is near the box. Those without a radius have -INFINITY. */
CT_INLINE MoverBox boxOfMovers(Float16 x, Float16 y, Float16 z, Float16 r) {
  const unsigned some = greater16(r, all16(-1));
  const Float16 zero = all16(0);
  const Float16 none = all16(INFINITY);
  /* Four at a time; the most of a number is the least of its opposite. */
  const Float16 first[4] = {blend16(some, none, x), blend16(some, none, y), blend16(some, none, z),
                            blend16(some, none, sub16(zero, x))};
  const Float16 last[4] = {blend16(some, none, sub16(zero, y)), blend16(some, none, sub16(zero, z)), sub16(zero, r),
                           zero};
  float least[8];
  least4x16(first, least);
  least4x16(last, least + 4);
  return (MoverBox){{least[0], least[1], least[2]}, {-least[3], -least[4], -least[5]}, -least[6]};
}

/* Moves slots [begin, end) into the view; `first` is the first of their sixteen. */
static void takeMovers(Traversal* t, int begin, int end, int first, Movers* movers) {
  const View* view = t->view;
  Block own;
  const Block* world = worldOfSlots(t, first, end, &own);
  movers->begin = begin;
  movers->end = end;
  movers->first = first;
  movers->leaf = begin / TREE_WIDTH;
  movers->bits = slotBits(begin, end, first);
  Float16 x = load16(world->x);
  Float16 y = load16(world->y);
  Float16 z = load16(world->z);
  const Float16 r = blend16(movers->bits, all16(-INFINITY), load16(world->r));
  for (int p = pieceOf(view, begin); p < view->pieceCount && view->pieces[p].slotBegin < end; p++) {
    if (moves(view, view->pieces[p].body)) {
      const float* motion = t->motions[view->pieces[p].body];
      const unsigned mask = slotBits(view->pieces[p].slotBegin, end, first);
      x = blend16(mask, x, moved16(world, motion));
      y = blend16(mask, y, moved16(world, motion + 4));
      z = blend16(mask, z, moved16(world, motion + 8));
    }
  }
  movers->box = boxOfMovers(x, y, z, r);
  store16(movers->block.x, x);
  store16(movers->block.y, y);
  store16(movers->block.z, z);
  store16(movers->block.r, r);
}

/* Bit k is set if member k may be near a mover. It is if near16 says so: no operation here gives less than there. */
CT_INLINE unsigned nearBoxOfMovers(const Block* block, const MoverBox* box, float reach) {
  const float* const from[3] = {block->x, block->y, block->z};
  Float16 gaps[3];
  for (int d = 0; d < 3; d++) {
    const Float16 x = load16(from[d]);
    gaps[d] = sub16(x, min16(max16(x, all16(box->low[d])), all16(box->high[d])));
  }
  const Float16 sum = max16(add16(load16(block->r), all16(box->r + reach)), all16(0));
  return greater16(mul16(sum, sum), squared16(gaps[0], gaps[1], gaps[2]));
}

/* Bounds the distance of two centres by their coordinates in float, which are those of near16, with its margin. */
static double farthestOf(const Visit* visit, Sphere a, Sphere b) {
  const float x = a.x - b.x;
  const float y = a.y - b.y;
  const float z = a.z - b.z;
  return (double)sqrtf(x * x + y * y + z * z) + visit->margin;
}

/* Hands over the pair of a mover and a slot that has this motion, and their spheres in the view. Most pairs clash by
 * far, which these show: positions in double take several times as long. False ends the search. */
static bool meet(Traversal* t, const Visit* visit, int mover, Sphere sphere, int slot, Sphere other, int motion) {
  if (visit->clashes != NULL && visit->clashes(visit->context, mover, slot, farthestOf(visit, sphere, other))) {
    return false;
  }
  double a[3];
  double b[3];
  ctPositionInView(t, mover, motionOfSlot(t->view, mover), a);
  ctPositionInView(t, slot, motion, b);
  return visit->function(visit->context, mover, slot, squaredDistance(a, b));
}

/* The index of the masks of leafA's slots with those of leafB. Without a branch for what is usual, so that nothing is
 * mispredicted. */
CT_INLINE int exclusionMask(const Exclusions* e, int leafA, int leafB) {
  const int begin = e->begin[leafA];
  const int count = e->begin[leafA + 1] - begin;
  if (count > TREE_WIDTH) {
    const int partner = exclusionPartner(e, leafA, leafB);
    return partner == CT_NULL ? e->emptyMask : partner;
  }
  const unsigned at = equal16(e->partner + begin, leafB) & ((1u << count) - 1);
  return at == 0 ? e->emptyMask : begin + __builtin_ctz(at);
}

/* The excluded pairs of movers with the slots of a leaf: a row for each mover. Writes to `own` if these are of two
 * leaves. */
CT_INLINE const uint16_t* excludedRows(const Exclusions* e, const Movers* movers, int leaf,
                                       uint16_t own[2 * TREE_WIDTH]) {
  const uint16_t* rows = e->mask[exclusionMask(e, movers->leaf, leaf)];
  if (movers->leaf < (movers->end - 1) / TREE_WIDTH) {
    memcpy(own, rows, TREE_WIDTH * sizeof *own);
    memcpy(own + TREE_WIDTH, e->mask[exclusionMask(e, movers->leaf + 1, leaf)], TREE_WIDTH * sizeof *own);
    rows = own;
  }
  return rows + movers->begin % TREE_WIDTH;
}

/* Tests movers against these slots (bits) of a leaf, which are at rest. False ends the search. */
CT_INLINE bool testLeaf(Traversal* t, Visit* visit, const Movers* movers, int leaf, unsigned slots) {
  const int count = movers->end - movers->begin;
  const int from = movers->begin - movers->first;
  const Block* block = worldOf(t, leaf);
  uint16_t own[2 * TREE_WIDTH];
  const uint16_t* excluded = excludedRows(t->exclusions, movers, leaf, own);
  unsigned near[TREE_WIDTH];
  unsigned any = 0;
  for (int i = 0; i < count; i++) {
    near[i] = near16(block, sphereOf(&movers->block, from + i), visit->reach) & slots & ~(unsigned)excluded[i];
    any |= near[i];
  }
  visit->particleTests += count * TREE_WIDTH;
  for (int i = 0; i < count && any != 0; i++) {
    for (; near[i] != 0; near[i] &= near[i] - 1) {
      const int k = __builtin_ctz(near[i]);
      if (!meet(t, visit, movers->begin + i, sphereOf(&movers->block, from + i), leaf * TREE_WIDTH + k,
                sphereOf(block, k), 0)) {
        return false;
      }
    }
  }
  return true;
}

/* Hands over the pairs of a slot, which has this motion, with the movers that are near it (bits), but for those that
 * are excluded. False ends the search. A function of its own, since this is rare. */
CT_NOINLINE bool meetMovers(Traversal* t, const Visit* visit, const Movers* movers, unsigned near, int slot,
                            Sphere sphere, int motion) {
  for (; near != 0; near &= near - 1) {
    const int k = __builtin_ctz(near);
    const int mover = movers->first + k;
    const int excluded = exclusionMask(t->exclusions, slot / TREE_WIDTH, mover / TREE_WIDTH);
    if ((t->exclusions->mask[excluded][slot % TREE_WIDTH] >> mover % TREE_WIDTH & 1) == 0 &&
        !meet(t, visit, mover, sphereOf(&movers->block, k), slot, sphere, motion)) {
      return false;
    }
  }
  return true;
}

/* The slots of piece p among movers, as bits. */
static unsigned bitsOfPiece(const View* view, int p, const Movers* movers) {
  const int begin = view->pieces[p].slotBegin > movers->begin ? view->pieces[p].slotBegin : movers->begin;
  const int next = p + 1 < view->pieceCount ? view->pieces[p + 1].slotBegin : movers->end;
  return slotBits(begin, next < movers->end ? next : movers->end, movers->first);
}

/* Tests movers against those of others that come later and have another motion. False ends the search. */
static bool testMovers(Traversal* t, Visit* visit, const Movers* movers, const Movers* others) {
  const View* view = t->view;
  const int last = pieceOf(view, others->end - 1);
  for (int own = pieceOf(view, movers->begin); own < last && view->pieces[own].slotBegin < movers->end; own++) {
    unsigned later = 0;
    for (int p = own + 1; p <= last; p++) {
      later |= view->pieces[p].body != view->pieces[own].body ? bitsOfPiece(view, p, others) : 0;
    }
    for (unsigned left = bitsOfPiece(view, own, movers); left != 0; left &= left - 1) {
      const int k = __builtin_ctz(left);
      const Sphere sphere = sphereOf(&movers->block, k);
      const unsigned near = near16(&others->block, sphere, visit->reach) & later;
      visit->particleTests += TREE_WIDTH;
      if (near != 0 && !meetMovers(t, visit, others, near, movers->first + k, sphere, view->pieces[own].body)) {
        return false;
      }
    }
  }
  return true;
}

/* ---- Boxes of leaves ---- */

/* Makes the box of a leaf, whose world coordinates are up to date. */
static void boxLeaf(Traversal* t, int leaf) {
  float least[8];
  boxOfBlock(&t->world[t->entryOf[leaf]], least);
  LeafBoxes* boxes = &t->leafBoxes[leaf / TREE_WIDTH];
  for (int d = 0; d < 3; d++) {
    boxes->low[d][leaf % TREE_WIDTH] = least[d];
    boxes->high[d][leaf % TREE_WIDTH] = -least[3 + d];
  }
}

/* Begins to wait until boxes are worth making. */
static void waitForBoxes(Traversal* t) {
  t->testsToBoxes = t->testsABox * t->tree->levelSize[0] + 1;
}

/* Makes the boxes of all leaves, unless some may lose their entries. */
CT_NOINLINE void boxLeaves(Traversal* t) {
  const int leaves = t->tree->levelSize[0];
  if (t->leafEntryCount < leaves) {
    t->testsToBoxes = INT_MAX;
    return;
  }
  for (int leaf = 0; leaf < leaves; leaf++) {
    updateWorldLeaf(t, leaf);
    boxLeaf(t, leaf);
  }
  t->boxedCount = t->tree->notedCount;
}

/* Makes the boxes anew of leaves whose slots have new positions, unless they are more than are remembered. */
CT_NOINLINE void boxNoted(Traversal* t) {
  const Tree* tree = t->tree;
  if (tree->notedCount - t->boxedCount > NOTED_LEAVES) {
    waitForBoxes(t);
    return;
  }
  for (; t->boxedCount < tree->notedCount; t->boxedCount++) {
    const int leaf = tree->noted[t->boxedCount % NOTED_LEAVES];
    updateWorldLeaf(t, leaf);
    boxLeaf(t, leaf);
  }
}

/* Brings the boxes of leaves up to date, or drops them if some leaf has moved. */
static void followLeaves(Traversal* t) {
  const Tree* tree = t->tree;
  if (!treeStays(tree, t->steadyTime)) {
    t->steadyTime = tree->time;
    waitForBoxes(t);
  } else if (t->testsToBoxes > 0) {
    if (--t->testsToBoxes == 0) {
      boxLeaves(t);
    }
  } else if (t->boxedCount != tree->notedCount) {
    boxNoted(t);
  }
}

/* ---- Movers against everything at rest ---- */

/* The level with which tests begin: the lowest of few nodes, since the nodes above would separate little. */
static int firstLevel(const Traversal* t) {
  int level = treeTop(t->tree);
  while (level > 1 && t->tree->levelSize[level - 1] <= t->mostFirstNodes) {
    level--;
  }
  return level;
}

/* Brings the nodes of that level up to date, and these leaves. */
static void updateFirst(Traversal* t, int begin, int end) {
  const Tree* tree = t->tree;
  const int first = firstLevel(t);
  if (t->firstNodesTime < tree->innerTime || !treeStays(tree, t->firstNodesTime)) {
    t->firstNodesTime = tree->innerTime > tree->time ? tree->innerTime : tree->time;
    for (int level = treeTop(tree); level >= first; level--) {
      for (int i = 0; i < tree->levelSize[level]; i++) {
        updateWorld(t, level, tree->levelBegin[level] + i);
      }
    }
  }
  followLeaves(t);
  for (int leaf = begin; leaf < end; leaf++) {
    for (int level = first - 1; level >= 0; level--) {
      updateWorld(t, level, tree->levelBegin[level] + (leaf >> TREE_WIDTH_BITS * level));
    }
  }
}

/* Bit k is set if the box of leaf k may be near a mover. Half a unit in the last place for either bound, and for each
 * sum here: the reach has room for that, see FLOAT_MARGIN. */
CT_INLINE unsigned nearLeafBoxes(const LeafBoxes* boxes, const MoverBox* box, float reach) {
  const float around = box->r + reach;
  const Float16 low[3] = {all16(box->low[0] - around), all16(box->low[1] - around), all16(box->low[2] - around)};
  const Float16 high[3] = {all16(box->high[0] + around), all16(box->high[1] + around), all16(box->high[2] + around)};
  return overlapping16(boxes->low, boxes->high, low, high);
}

/* Lists the members that may be near movers of nodes [begin, end) of a level, all up to date. Returns how many. */
CT_INLINE int listNearBox(Traversal* t, int level, int begin, int end, const MoverBox* box, float reach, int* near) {
  const Tree* tree = t->tree;
  const int below = tree->levelBegin[level - 1];
  int found = 0;
  if (level == 1 && t->testsToBoxes == 0) {
    for (int i = begin; i < end; i++) {
      found += indices16(nearLeafBoxes(&t->leafBoxes[i], box, reach), i * TREE_WIDTH, near + found);
    }
    return found;
  }
  const Block* blocks = worldOf(t, tree->levelBegin[level]);
  for (int i = begin; i < end; i++) {
    found += indices16(nearBoxOfMovers(&blocks[i], box, reach), below + i * TREE_WIDTH, near + found);
  }
  return found;
}

/* Lists the members that may be near movers of those nodes of a level, all up to date, that may be so themselves.
 * Returns how many. */
CT_NOINLINE int listNearOfMany(Traversal* t, Visit* visit, const Movers* movers, int level, int* near) {
  const Tree* tree = t->tree;
  const int parentCount = tree->levelSize[level + 1];
  const int begin = tree->levelBegin[level];
  int nodes[MOST_FIRST_NODES + TREE_WIDTH];
  const int count = listNearBox(t, level + 1, 0, parentCount, &movers->box, visit->reach, nodes);
  int found = 0;
  for (int i = 0; i < count; i++) {
    const int node = nodes[i] - begin;
    found += listNearBox(t, level, node, node + 1, &movers->box, visit->reach, near + found);
  }
  visit->volumeTests += (parentCount + count) * TREE_WIDTH;
  return found;
}

/* The same of all nodes of the level with which tests begin. */
CT_INLINE int listNearFirst(Traversal* t, Visit* visit, const Movers* movers, int level, int* near) {
  const int count = t->tree->levelSize[level];
  if (count > t->mostUnaskedNodes) {
    return listNearOfMany(t, visit, movers, level, near);
  }
  visit->volumeTests += count * TREE_WIDTH;
  return listNearBox(t, level, 0, count, &movers->box, visit->reach, near);
}

/* Lists the leaves that may be near movers, and returns them. */
static const int* listNearLeaves(Traversal* t, Visit* visit, const Movers* movers, int* leafCount) {
  const Tree* tree = t->tree;
  const int top = firstLevel(t);
  int* nodes = t->nearNodes; /* level by level */
  int count = listNearFirst(t, visit, movers, top, nodes);
  int done = 0;
  for (int level = top - 1; level > 0; level--) {
    const int last = count;
    for (int i = done; i < last; i++) {
      updateWorld(t, level, nodes[i]);
    }
    visit->volumeTests += (last - done) * TREE_WIDTH;
    for (; done < last; done++) {
      const int node = nodes[done] - tree->levelBegin[level];
      count += listNearBox(t, level, node, node + 1, &movers->box, visit->reach, nodes + count);
    }
  }
  *leafCount = count - done;
  return nodes + done;
}

/* Tests movers against slots at rest. False ends the search. */
static bool testSlots(Traversal* t, Visit* visit, const Movers* movers, const int* slots, int count) {
  visit->particleTests += count * (movers->end - movers->begin);
  for (int i = 0; i < count; i++) {
    const Sphere sphere = sphereOf(worldOf(t, slots[i] / TREE_WIDTH), slots[i] % TREE_WIDTH);
    const unsigned near = near16(&movers->block, sphere, visit->reach) & movers->bits;
    if (near != 0 && !meetMovers(t, visit, movers, near, slots[i], sphere, 0)) {
      return false;
    }
  }
  return true;
}

/* Lists the slots near the box of movers in these leaves, but for leaves first to last. Returns how many. */
CT_INLINE int listNearSlots(Traversal* t, const int* leaves, int leafCount, bool areUpToDate, int first, int last,
                            const MoverBox* box, float reach, int* slots) {
  int count = 0;
  for (int i = 0; i < leafCount; i++) {
    const int leaf = leaves[i];
    const unsigned others = leaf < first || last < leaf ? 0xffff : 0;
    if (!areUpToDate) {
      updateWorld(t, 0, leaf);
    }
    const Block* world = &t->world[t->entryOf[leaf]];
    count += indices16(nearBoxOfMovers(world, box, reach) & others, leaf * TREE_WIDTH, slots + count);
  }
  return count;
}

/* Tests movers against everything at rest: all slots but [begin, end), which move. False ends the search. */
static bool probeMovers(Traversal* t, Visit* visit, const Movers* movers, int begin, int end) {
  enum { LEAVES_AT_ONCE = 16 };
  const int firstLeaf = begin / TREE_WIDTH;
  const int lastLeaf = (end - 1) / TREE_WIDTH;
  for (int leaf = firstLeaf; leaf <= lastLeaf; leaf++) {
    if (!testLeaf(t, visit, movers, leaf, ~slotBits(begin, end, leaf * TREE_WIDTH))) {
      return false;
    }
  }
  int leafCount;
  const int* leaves = listNearLeaves(t, visit, movers, &leafCount);
  visit->volumeTests += leafCount * TREE_WIDTH;
  for (int i = 0; i < leafCount; i += LEAVES_AT_ONCE) {
    const int some = leafCount - i < LEAVES_AT_ONCE ? leafCount - i : LEAVES_AT_ONCE;
    int slots[(LEAVES_AT_ONCE + 1) * TREE_WIDTH]; /* near the box: few, so that most leaves cost no more than that */
    const int count =
        t->testsToBoxes == 0
            ? listNearSlots(t, leaves + i, some, true, firstLeaf, lastLeaf, &movers->box, visit->reach, slots)
            : listNearSlots(t, leaves + i, some, false, firstLeaf, lastLeaf, &movers->box, visit->reach, slots);
    if (!testSlots(t, visit, movers, slots, count)) {
      return false;
    }
  }
  return true;
}

/* Tests a view in which only slots [begin, end) move. It needs no volumes of straddlers. */
static void visitFew(Traversal* t, Visit* visit, int begin, int end) {
  updateFirst(t, begin / TREE_WIDTH, (end - 1) / TREE_WIDTH + 1);
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

#endif /* CT_MOVERS_BODY_H_ */
