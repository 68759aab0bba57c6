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
  movers->block = world;
  for (int p = pieceOf(view, begin); p < view->pieceCount && view->pieces[p].slotBegin < end; p++) {
    if (moves(view, view->pieces[p].body)) {
      moveBlock(&world, t->motions[view->pieces[p].body], slotBits(view->pieces[p].slotBegin, end, first),
                &movers->block);
    }
  }
}

/* Hands over the pairs of a slot with these slots of a leaf (bits). False ends the search. */
static bool meet(Traversal* t, Visit* visit, int slot, unsigned others, int leaf) {
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

/* Which members of a leaf each mover is near, as bits. Looks at all movers, without a branch that processors would
 * mispredict. Returns those that are near any. */
CT_INLINE unsigned nearMovers(const Block* block, const Movers* movers, float reach, unsigned near[TREE_WIDTH]) {
  unsigned any = 0;
  for (int k = movers->begin - movers->first; k < movers->end - movers->first; k++) {
    near[k] = near16(block, sphereOf(&movers->block, k), reach);
    any |= near[k];
  }
  return any;
}

/* Tests movers against the slots of a leaf that are at rest; `moved` are the others. False ends the search. */
static bool testLeaf(Traversal* t, Visit* visit, const Movers* movers, int leaf, unsigned moved) {
  unsigned near[TREE_WIDTH];
  visit->particleTests += (movers->end - movers->begin) * TREE_WIDTH;
  if ((nearMovers(worldOf(t, leaf), movers, visit->reach, near) & ~moved) == 0) {
    return true;
  }
  int leafOfMovers = CT_NULL;
  int partner = CT_NULL;
  for (int slot = movers->begin; slot < movers->end; slot++) {
    unsigned others = near[slot - movers->first] & ~moved;
    if (others == 0) {
      continue;
    }
    if (leafOfMovers != slot / TREE_WIDTH) {
      leafOfMovers = slot / TREE_WIDTH;
      partner = exclusionPartner(t->exclusions, leafOfMovers, leaf);
    }
    if (partner != CT_NULL) {
      others &= ~(unsigned)t->exclusions->mask[partner][slot % TREE_WIDTH];
    }
    if (others != 0 && !meet(t, visit, slot, others, leaf)) {
      return false;
    }
  }
  return true;
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
    if (!meet(t, visit, slot, 1u << other % TREE_WIDTH, other / TREE_WIDTH)) {
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

/* Tests movers against everything at rest: all slots but [begin, end), which move. False ends the search. */
static bool probeMovers(Traversal* t, Visit* visit, const Movers* movers, int begin, int end) {
  const Tree* tree = t->tree;
  const int firstLeaf = begin / TREE_WIDTH;
  const int lastLeaf = (end - 1) / TREE_WIDTH;
  for (int leaf = firstLeaf; leaf <= lastLeaf; leaf++) {
    if (!testLeaf(t, visit, movers, leaf, slotBits(begin, end, leaf * TREE_WIDTH))) {
      return false;
    }
  }
  /* Begin at the lowest level of few nodes: the nodes above would separate little. */
  int top = treeTop(tree);
  for (; top > 1 && tree->levelSize[top - 1] <= MOST_FIRST_NODES; top--) {
    for (int i = 0; i < tree->levelSize[top]; i++) {
      updateWorld(t, top, tree->levelBegin[top] + i);
    }
  }
  int* nodes = t->nearNodes; /* level by level */
  int count = 0;
  for (int i = 0; i < tree->levelSize[top]; i++) {
    nodes[count++] = tree->levelBegin[top] + i;
  }
  Sphere sphere = middleOfBlock(&movers->block);
  sphere.r += radiusAbout(sphere, &movers->block, movers->block.r) + (float)floatMargin(t->extent);
  int done = 0;
  for (int level = top; level > 0; level--) {
    const int last = count;
    for (int i = done; i < last; i++) {
      updateWorld(t, level, nodes[i]);
    }
    for (; done < last; done++) {
      const int first = tree->levelBegin[level - 1] + (nodes[done] - tree->levelBegin[level]) * TREE_WIDTH;
      count += indices16(near16(worldOf(t, nodes[done]), sphere, visit->reach), first, nodes + count);
      visit->volumeTests += TREE_WIDTH;
    }
  }
  for (; done < count; done++) {
    const int leaf = nodes[done];
    if (firstLeaf <= leaf && leaf <= lastLeaf) {
      continue;
    }
    updateWorld(t, 0, leaf);
    if (!testLeaf(t, visit, movers, leaf, 0)) {
      return false;
    }
  }
  return true;
}

/* Tests a view in which only slots [begin, end) move. It needs no volumes of straddlers. */
static void visitFew(Traversal* t, Visit* visit, int begin, int end) {
  for (int leaf = begin / TREE_WIDTH; leaf * TREE_WIDTH < end; leaf++) {
    updateWorldLeaf(t, leaf);
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

#endif /* CT_MOVERS_BODY_H_ */
