/* Trials that move a few slots in a row: these are tested one by one against everything at rest. Compiled once for each
 * instruction set by the file that includes this. */
#ifndef CT_MOVERS_BODY_H_
#define CT_MOVERS_BODY_H_

#include "view_body.h"

/* Slots [begin, end), which move, in the view, among sixteen. */
typedef struct Movers {
  int begin;
  int end;
  int first; /* of the sixteen; the others are empty */
  int leaf;  /* of begin */
  Block block;
} Movers;

/* Bit k: slot first + k of sixteen is in [begin, end). */
static unsigned slotBits(int begin, int end, int first) {
  const int low = begin > first ? begin - first : 0;
  const int high = end - first < TREE_WIDTH ? end - first : TREE_WIDTH;
  return low < high ? (1u << high) - (1u << low) : 0;
}

/* World coordinates of sixteen slots from any one on. Those of slot `end` and later ones may be any numbers. */
static void worldOfSlots(Traversal* t, int first, int end, Block* world) {
  const int leaf = first / TREE_WIDTH;
  const int at = first % TREE_WIDTH;
  if (at == 0) {
    *world = *worldOf(t, leaf);
    return;
  }
  const int next = leaf + ((leaf + 1) * TREE_WIDTH < end);
  worldOf(t, leaf);
  const Block* above = worldOf(t, next);
  const Block* below = worldOf(t, leaf); /* again, as in blocksOf */
  float row[2 * TREE_WIDTH];
  const float* const from[4][2] = {
      {below->x, above->x}, {below->y, above->y}, {below->z, above->z}, {below->r, above->r}};
  float* const to[4] = {world->x, world->y, world->z, world->r};
  for (int d = 0; d < 4; d++) {
    store16(row, load16(from[d][0]));
    store16(row + TREE_WIDTH, load16(from[d][1]));
    store16(to[d], load16(row + at));
  }
}

/* Moves slots [begin, end) into the view; `first` is the first of their sixteen. */
static void takeMovers(Traversal* t, int begin, int end, int first, Movers* movers) {
  const View* view = t->view;
  Block world;
  worldOfSlots(t, first, end, &world);
  store16(world.r, blend16(slotBits(begin, end, first), all16(-INFINITY), load16(world.r)));
  movers->begin = begin;
  movers->end = end;
  movers->first = first;
  movers->leaf = begin / TREE_WIDTH;
  movers->block = world;
  for (int p = pieceOf(view, begin); p < view->pieceCount && view->pieces[p].slotBegin < end; p++) {
    if (moves(view, view->pieces[p].body)) {
      moveBlock(&world, t->motions[view->pieces[p].body], slotBits(view->pieces[p].slotBegin, end, first),
                &movers->block);
    }
  }
}

/* The box around the centres of movers, along the world's axes. */
typedef struct MoverBox {
  float low[3];
  float high[3];
  float r; /* the largest radius */
} MoverBox;

/* If there are no particles, nothing is near the box. */
static MoverBox boxOfMovers(const Block* block) {
  const unsigned some = greater16(load16(block->r), all16(-1)); /* members of radius -INFINITY are none */
  const Float16 zero = all16(0);
  const Float16 none = all16(INFINITY);
  const Float16 x = load16(block->x);
  const Float16 y = load16(block->y);
  const Float16 z = load16(block->z);
  /* Four at a time; the most of a number is the least of its opposite. */
  const Float16 first[4] = {blend16(some, none, x), blend16(some, none, y), blend16(some, none, z),
                            blend16(some, none, sub16(zero, x))};
  const Float16 last[4] = {blend16(some, none, sub16(zero, y)), blend16(some, none, sub16(zero, z)),
                           sub16(zero, load16(block->r)), zero};
  float least[8];
  least4x16(first, least);
  least4x16(last, least + 4);
  return (MoverBox){{least[0], least[1], least[2]}, {-least[3], -least[4], -least[5]}, -least[6]};
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

/* Hands over the pairs of movers with the members of a leaf that each is near (bits). False ends the search. */
static bool meet(Traversal* t, Visit* visit, const Movers* movers, const unsigned near[TREE_WIDTH], int leaf) {
  for (int slot = movers->begin; slot < movers->end; slot++) {
    for (unsigned others = near[slot - movers->first]; others != 0; others &= others - 1) {
      const int other = leaf * TREE_WIDTH + __builtin_ctz(others);
      double a[3];
      double b[3];
      ctPositionInView(t, slot, motionOfSlot(t->view, slot), a);
      ctPositionInView(t, other, 0, b);
      if (!visit->function(visit->context, slot, other, squaredDistance(a, b))) {
        return false;
      }
    }
  }
  return true;
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

/* Tests movers against these slots (bits) of a leaf at rest. False ends the search. */
CT_INLINE bool testLeaf(Traversal* t, Visit* visit, const Movers* movers, int leaf, unsigned slots) {
  const Exclusions* e = t->exclusions;
  const Block* block = worldOf(t, leaf);
  const uint16_t* masks[2] = {e->mask[exclusionMask(e, movers->leaf, leaf)], e->mask[e->emptyMask]};
  if (movers->leaf < (movers->end - 1) / TREE_WIDTH) {
    masks[1] = e->mask[exclusionMask(e, movers->leaf + 1, leaf)];
  }
  unsigned near[TREE_WIDTH];
  unsigned any = 0;
  for (int slot = movers->begin; slot < movers->end; slot++) {
    const int k = slot - movers->first;
    const unsigned excluded = masks[slot / TREE_WIDTH - movers->leaf][slot % TREE_WIDTH];
    near[k] = near16(block, sphereOf(&movers->block, k), visit->reach) & slots & ~excluded;
    any |= near[k];
  }
  visit->particleTests += (movers->end - movers->begin) * TREE_WIDTH;
  return any == 0 || meet(t, visit, movers, near, leaf);
}

/* Tests a mover against those of others that are in [begin, end). False ends the search. */
static bool testMover(Traversal* t, Visit* visit, const Movers* movers, int slot, const Movers* others, int begin,
                      int end) {
  visit->particleTests += TREE_WIDTH;
  unsigned near = near16(&others->block, sphereOf(&movers->block, slot - movers->first), visit->reach) &
                  slotBits(begin, end, others->first);
  for (; near != 0; near &= near - 1) {
    const int other = others->first + __builtin_ctz(near);
    const int partner = exclusionPartner(t->exclusions, slot / TREE_WIDTH, other / TREE_WIDTH);
    if (partner != CT_NULL && (t->exclusions->mask[partner][slot % TREE_WIDTH] >> other % TREE_WIDTH & 1) != 0) {
      continue;
    }
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

/* Tests movers against those of others that come later and have another motion. False ends the search. */
static bool testMovers(Traversal* t, Visit* visit, const Movers* movers, const Movers* others) {
  const View* view = t->view;
  for (int slot = movers->begin; slot < movers->end; slot++) {
    const int own = pieceOf(view, slot);
    for (int p = pieceOf(view, others->end - 1); p > own; p--) {
      const int end = p + 1 < view->pieceCount ? view->pieces[p + 1].slotBegin : others->end;
      if (view->pieces[p].body != view->pieces[own].body &&
          !testMover(t, visit, movers, slot, others, view->pieces[p].slotBegin, end)) {
        return false;
      }
    }
  }
  return true;
}

/* The level with which tests begin: the lowest of few nodes, since the nodes above would separate little. */
static int firstLevel(const Tree* tree) {
  int level = treeTop(tree);
  while (level > 1 && tree->levelSize[level - 1] <= MOST_FIRST_NODES) {
    level--;
  }
  return level;
}

/* Brings the nodes of that level up to date, and these leaves. */
static void updateFirst(Traversal* t, int begin, int end) {
  const Tree* tree = t->tree;
  const int first = firstLevel(tree);
  if (t->firstNodesTime != tree->time) {
    t->firstNodesTime = tree->time;
    for (int level = treeTop(tree); level >= first; level--) {
      for (int i = 0; i < tree->levelSize[level]; i++) {
        updateFrame(t, level, tree->levelBegin[level] + i);
      }
    }
  }
  for (int leaf = begin; leaf < end; leaf++) {
    for (int level = first - 1; level >= 0; level--) {
      updateWorld(t, level, tree->levelBegin[level] + (leaf >> TREE_WIDTH_BITS * level));
    }
  }
}

/* Tests movers against everything at rest: all slots but [begin, end), which move. False ends the search. */
static bool probeMovers(Traversal* t, Visit* visit, const Movers* movers, int begin, int end) {
  const Tree* tree = t->tree;
  const MoverBox box = boxOfMovers(&movers->block);
  const int firstLeaf = begin / TREE_WIDTH;
  const int lastLeaf = (end - 1) / TREE_WIDTH;
  for (int leaf = firstLeaf; leaf <= lastLeaf; leaf++) {
    if (!testLeaf(t, visit, movers, leaf, ~slotBits(begin, end, leaf * TREE_WIDTH))) {
      return false;
    }
  }
  const int top = firstLevel(tree);
  int* nodes = t->nearNodes; /* level by level */
  int count = 0;
  for (int i = 0; i < tree->levelSize[top]; i++) {
    nodes[count++] = tree->levelBegin[top] + i;
  }
  int done = 0;
  for (int level = top; level > 0; level--) {
    const int last = count;
    for (int i = done; i < last && level < top; i++) {
      updateWorld(t, level, nodes[i]);
    }
    for (; done < last; done++) {
      const int first = tree->levelBegin[level - 1] + (nodes[done] - tree->levelBegin[level]) * TREE_WIDTH;
      count += indices16(nearBoxOfMovers(worldOf(t, nodes[done]), &box, visit->reach), first, nodes + count);
      visit->volumeTests += TREE_WIDTH;
    }
  }
  for (; done < count; done++) {
    const int leaf = nodes[done];
    if (firstLeaf <= leaf && leaf <= lastLeaf) {
      continue;
    }
    updateWorld(t, 0, leaf);
    if (!testLeaf(t, visit, movers, leaf, 0xffff)) {
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
