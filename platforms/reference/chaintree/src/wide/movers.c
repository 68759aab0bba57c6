/* Trials that move a few slots in a row, and probes: each mover is tested against all static slots. */
#include "nearimages.h"
#include "signedshorts.h"
#include "view.h"

/* The box around the centres of movers, along the world's axes: its low ends, the opposites of its high ends, and the
 * opposite of the largest radius. */
typedef struct MoverBox {
  float ends[8];
} MoverBox;

/* Slots [begin, end), in the view, among sixteen; those of body 0 are left out. Or a probe: a sphere that is no slot.
 */
typedef struct Movers {
  const double* probe; /* where it is; NULL: movers are slots */
  int begin;
  int end;
  int first;     /* of the sixteen; the others are empty */
  int leaf;      /* of begin */
  unsigned bits; /* of begin to end, without body 0 */
  int firstLeaf; /* of all that move, which may be more; beyond lastLeaf: none */
  int lastLeaf;
  MoverBox box;
  int16_t limits[8]; /* of ShortBoxes.ends: the ends of boxes that may be near are below them */
  Block block;
} Movers;

/* Bit k: slot first + k of sixteen is in [begin, end). */
static unsigned slotBits(int begin, int end, int first) {
  const int low = begin > first ? begin - first : 0;
  const int high = end - first < TREE_WIDTH ? end - first : TREE_WIDTH;
  return low < high ? (1u << high) - (1u << low) : 0;
}

/* Removes slots of body 0 from such bits. A function of its own, since this is rare. */
CT_NOINLINE unsigned withoutStill(const View* view, int begin, int end, int first, unsigned bits) {
  for (int next = end, p = pieceOf(view, end - 1); next > begin; next = view->pieces[p--].slotBegin) {
    if (view->pieces[p].body == 0) {
      bits &= ~slotBits(view->pieces[p].slotBegin, next, first);
    }
  }
  return bits;
}

/* The same as slotBits without slots of body 0. */
CT_INLINE unsigned movingBits(const View* view, int begin, int end, int first) {
  const unsigned bits = slotBits(begin, end, first);
  const bool isOnePiece = view->pieceCount <= 3 && view->pieces[0].body == 0; /* or two that move */
  return isOnePiece ? bits : withoutStill(view, begin, end, first, bits);
}

/* World coordinates of sixteen slots, starting at any. Coordinates of slot `end` and later ones may be any numbers.
 * Writes to `own` if the slots are of two leaves. */
static const Block* worldOfSlots(Traversal* t, int first, int end, Block* own) {
  const int leaf = coveringNode(first);
  const int at = memberIndex(first);
  if (at == 0) {
    return worldOf(t->world, leaf);
  }
  const int next = leaf + ((leaf + 1) * TREE_WIDTH < end);
  worldOf(t->world, leaf);
  const Block* above = worldOf(t->world, next);
  const Block* below = worldOf(t->world, leaf); /* again, as in blocksOf */
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
CT_INLINE MoverBox boxOfMovers(const Block* block) {
  const Float16 x = load16(block->x);
  const Float16 y = load16(block->y);
  const Float16 z = load16(block->z);
  const Float16 r = load16(block->r);
  const unsigned some = greater16(r, all16(-1));
  const Float16 zero = all16(0);
  const Float16 none = all16(INFINITY);
  /* Four at a time; the most of a number is the least of its opposite. */
  const Float16 first[4] = {blend16(some, none, x), blend16(some, none, y), blend16(some, none, z),
                            blend16(some, none, sub16(zero, x))};
  const Float16 last[4] = {blend16(some, none, sub16(zero, y)), blend16(some, none, sub16(zero, z)), sub16(zero, r),
                           zero};
  MoverBox box;
  least4x16(first, box.ends);
  least4x16(last, box.ends + 4);
  return box;
}

/* Moves slots [begin, end) into the view; `first` is the first of their sixteen. The other slots have no radius and any
 * coordinates. */
static void takeMovers(Traversal* t, int begin, int end, int first, Movers* movers) {
  const View* view = t->view;
  Block own;
  const Block* world = worldOfSlots(t, first, end, &own);
  movers->probe = NULL;
  movers->begin = begin;
  movers->end = end;
  movers->first = first;
  movers->leaf = coveringNode(begin);
  movers->bits = movingBits(view, begin, end, first);
  Float16 x = load16(world->x);
  Float16 y = load16(world->y);
  Float16 z = load16(world->z);
  const Float16 r = blend16(movers->bits, all16(-INFINITY), load16(world->r));
  for (int p = pieceOf(view, begin); p < view->pieceCount && view->pieces[p].slotBegin < end; p++) {
    const float* motion = t->motions[view->pieces[p].body];
    if (!moves(view, view->pieces[p].body)) {
      continue;
    }
    if (view->pieces[p].slotBegin <= begin) { /* mostly: all move alike */
      x = moved16(world, motion);
      y = moved16(world, motion + 4);
      z = moved16(world, motion + 8);
    } else {
      const unsigned mask = slotBits(view->pieces[p].slotBegin, end, first);
      x = blend16(mask, x, moved16(world, motion));
      y = blend16(mask, y, moved16(world, motion + 4));
      z = blend16(mask, z, moved16(world, motion + 8));
    }
  }
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
    gaps[d] = sub16(x, min16(max16(x, all16(box->ends[d])), all16(-box->ends[3 + d])));
  }
  const Float16 sum = max16(add16(load16(block->r), all16(reach - box->ends[6])), all16(0));
  return greater16(mul16(sum, sum), squared16(gaps[0], gaps[1], gaps[2]));
}

/* Bounds the distance of two centres by their coordinates in float, which are those of near16, with its margin. */
static double farthestOf(const Visit* visit, Sphere a, Sphere b) {
  const float x = a.x - b.x;
  const float y = a.y - b.y;
  const float z = a.z - b.z;
  return (double)sqrtf(x * x + y * y + z * z) + visit->margin;
}

/* Tests the pair of a mover and a slot of this body, with their spheres in the view. Most clashing pairs clash by far,
 * which spheres show: positions in double take several times as long. False ends the search. */
static bool meet(Traversal* t, const Visit* visit, int mover, Sphere sphere, int slot, Sphere other, int body) {
  if (visit->clashes != NULL && visit->clashes(visit->context, mover, slot, farthestOf(visit, sphere, other))) {
    return false;
  }
  double a[3];
  double b[3];
  ctPositionInView(t, mover, bodyOfSlot(t->view, mover), a);
  ctPositionInView(t, slot, body, b);
  return visit->function(visit->context, mover, slot, squaredDistance(a, b));
}

/* The index of the masks of leafA's slots with leafB's. The usual case has no branch, so that nothing is mispredicted.
 */
CT_INLINE int exclusionMask(const Exclusions* e, int leafA, int leafB) {
  if (leafA == leafB) {
    return e->own[leafA];
  }
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
  if (movers->leaf < coveringNode(movers->end - 1)) {
    memcpy(own, rows, TREE_WIDTH * sizeof *own);
    memcpy(own + TREE_WIDTH, e->mask[exclusionMask(e, movers->leaf + 1, leaf)], TREE_WIDTH * sizeof *own);
    rows = own;
  }
  return rows + memberIndex(movers->begin);
}

/* Tests movers against these slots (bits) of a leaf, which are static. False ends the search. */
CT_INLINE bool testLeaf(Traversal* t, Visit* visit, const Movers* movers, int leaf, unsigned slots) {
  const int count = movers->end - movers->begin;
  const int from = movers->begin - movers->first;
  const Block* block = worldOf(t->world, leaf);
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

/* Tests the pair of a probe and a static slot. False ends the search. */
static bool meetProbe(Traversal* t, const Visit* visit, const double probe[3], int slot) {
  double position[3];
  ctPositionInView(t, slot, 0, position);
  return visit->function(visit->context, CT_NULL, slot, squaredDistance(probe, position));
}

/* Tests the pairs of a slot of this body with movers that are near it (bits), except excluded ones. False ends the
 * search. A function of its own, since this is rare. */
CT_NOINLINE bool meetMovers(Traversal* t, const Visit* visit, const Movers* movers, unsigned near, int slot,
                            Sphere sphere, int body) {
  if (movers->probe != NULL) {
    return meetProbe(t, visit, movers->probe, slot);
  }
  for (; near != 0; near &= near - 1) {
    const int k = __builtin_ctz(near);
    const int mover = movers->first + k;
    const int excluded = exclusionMask(t->exclusions, coveringNode(slot), coveringNode(mover));
    if ((t->exclusions->mask[excluded][memberIndex(slot)] >> memberIndex(mover) & 1) == 0 &&
        !meet(t, visit, mover, sphereOf(&movers->block, k), slot, sphere, body)) {
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

/* Tests movers against later movers of another body. False ends the search. */
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

/* Ends are shifted away from a box, and limits from the movers: by a unit, since shorts are rounded towards 0, and by
 * another for the roundings of floats. Beyond the range of shorts, ends stay below limits. */
enum { UNITS_AROUND = 2 };

/* Units for the size of the state; the rest is for particles that move beyond it. */
enum { UNITS_OF_STATE = 30000 };

/* Units a nm, at most: products with CT_MOST_LENGTH are finite. */
#define MOST_BOX_SCALE 1e20

/* Makes the box of a leaf, whose world coordinates are up to date. */
static void boxLeaf(Traversal* t, int leaf) {
  float least[8];
  int16_t ends[8];
  boxOfBlock(&t->world->members[t->world->entryOf[leaf]], least);
  storeSignedShorts8(ends, least, t->boxScale, 0, -UNITS_AROUND);
  ShortBoxes* boxes = &t->leafBoxes[coveringNode(leaf)];
  for (int d = 0; d < 3; d++) {
    boxes->ends[d][memberIndex(leaf)] = ends[3 + d];
    boxes->ends[3 + d][memberIndex(leaf)] = ends[d];
  }
}

/* The limits of boxes near movers. Half a unit in the last place for either end, and for each sum: the reach has room
 * for that, see FLOAT_MARGIN. */
static void limitBoxes(const Traversal* t, float reach, Movers* movers) {
  const float around = reach - movers->box.ends[6];
  storeSignedShorts8(movers->limits, movers->box.ends, -t->boxScale, around * t->boxScale, UNITS_AROUND);
}

/* Starts the count of tests until boxes are worth making. */
static void waitForBoxes(Traversal* t) {
  t->testsToBoxes = t->testsPerLeaf * t->tree->levelSize[0] + 1;
}

/* Makes the boxes of all leaves, unless some may lose their entries. */
CT_NOINLINE void boxLeaves(Traversal* t) {
  const int leaves = t->tree->levelSize[0];
  if (t->world->leafEntryCount < leaves) {
    t->testsToBoxes = INT_MAX;
    return;
  }
  t->boxScale = (float)lesser(UNITS_OF_STATE / sizeOfState(t->tree), MOST_BOX_SCALE);
  for (int leaf = 0; leaf < leaves; leaf++) {
    CT_WIDE(updateWorldAt)(t->world, 0, leaf);
    boxLeaf(t, leaf);
  }
}

/* Makes new boxes of leaves that have moved since the last test, unless more have than are listed. */
CT_NOINLINE void boxListed(Traversal* t) {
  const Changes* changes = &t->tree->changes;
  int count = 0;
  while (count < LISTED_LEAVES && listedLeaf(changes, count).revision > t->boxesFrom) {
    count++;
  }
  if (count == LISTED_LEAVES) {
    waitForBoxes(t);
    return;
  }
  for (int i = 0; i < count; i++) {
    const int leaf = listedLeaf(changes, i).leaf;
    CT_WIDE(updateWorldAt)(t->world, 0, leaf);
    boxLeaf(t, leaf);
  }
}

/* Updates the boxes of leaves, or drops them if other leaves may have moved than the listed ones. */
static void followLeaves(Traversal* t) {
  const Changes* changes = &t->tree->changes;
  if (changes->unlisted > t->boxesFrom) {
    waitForBoxes(t);
  } else if (t->testsToBoxes > 0) {
    if (--t->testsToBoxes == 0) {
      boxLeaves(t);
    }
  } else if (stateChangedSince(changes, t->boxesFrom)) {
    boxListed(t);
  }
  t->boxesFrom = changes->now;
}

/* ---- Movers against static slots ---- */

/* Updates the nodes of the level where tests start: the lowest level of few nodes, since nodes above would separate
 * little. */
CT_NOINLINE void updateFirstNodes(Traversal* t) {
  const Tree* tree = t->tree;
  t->firstLevel = treeTop(tree);
  while (t->firstLevel > 1 && tree->levelSize[t->firstLevel - 1] <= t->mostFirstNodes) {
    t->firstLevel--;
  }
  for (int level = treeTop(tree); level >= t->firstLevel; level--) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      updateWorld(t->world, level, tree->levelBegin[level] + i);
    }
  }
  t->firstNodesFrom = tree->changes.now;
}

/* Updates the nodes where a test starts, and these leaves. With boxes they are up to date already: leaves in which
 * something has moved are listed, and come with the nodes above them. */
static void updateFirst(Traversal* t, int begin, int end) {
  const Tree* tree = t->tree;
  followLeaves(t);
  if (t->testsToBoxes == 0) {
    return;
  }
  if (t->firstNodesFrom != tree->changes.now) {
    updateFirstNodes(t);
  }
  for (int leaf = begin; leaf < end; leaf++) {
    for (int level = t->firstLevel - 1; level >= 0; level--) {
      updateWorld(t->world, level, tree->levelBegin[level] + (leaf >> TREE_WIDTH_BITS * level));
    }
  }
}

/* Lists the members of nodes [begin, end) of a level that may be near movers, except leaves in which something moves.
 * All nodes are up to date. Returns how many. */
CT_INLINE int listNearBox(Traversal* t, const Movers* movers, int level, int begin, int end, float reach, int* near) {
  const Block* blocks = worldOf(t->world, t->tree->levelBegin[level]);
  const int below = t->tree->levelBegin[level - 1];
  const bool areBoxed = level == 1 && t->testsToBoxes == 0;
  int found = 0;
  for (int i = begin; i < end; i++) {
    const unsigned mask = areBoxed ? belowSixLimits(t->leafBoxes[i].ends, sixLimits(movers->limits))
                                   : nearBoxOfMovers(&blocks[i], &movers->box, reach);
    const unsigned own = level == 1 ? slotBits(movers->firstLeaf, movers->lastLeaf + 1, i * TREE_WIDTH) : 0;
    found += indices16(mask & ~own, below + i * TREE_WIDTH, near + found);
  }
  return found;
}

/* The same for all leaves, by their boxes. Few branches depend on what is found, since processors mispredict these. */
CT_INLINE int listNearBoxes(const Traversal* t, const Movers* movers, int* near) {
  uint64_t masks[MOST_BOXED_NODES / NODES_AT_ONCE];
  const SixLimits limits = sixLimits(movers->limits);
  const int count = boxedNodes(t->tree) / NODES_AT_ONCE;
  for (int i = 0; i < count; i++) {
    uint64_t mask = 0;
    for (int k = NODES_AT_ONCE - 1; k >= 0; k--) {
      mask = mask << TREE_WIDTH | belowSixLimits(t->leafBoxes[i * NODES_AT_ONCE + k].ends, limits);
    }
    masks[i] = mask;
  }
  for (int leaf = movers->firstLeaf; leaf <= movers->lastLeaf; leaf++) {
    masks[leaf / 64] &= ~((uint64_t)1 << leaf % 64);
  }
  int found = 0;
  for (int i = 0; i < count; i++) {
    found += indices64(masks[i], i * NODES_AT_ONCE * TREE_WIDTH, near + found);
  }
  return found;
}

/* Lists members near the movers, below near nodes of a level. All nodes are up to date. Returns how many. */
CT_NOINLINE int listNearOfMany(Traversal* t, Visit* visit, const Movers* movers, int level, int* near) {
  const Tree* tree = t->tree;
  const int parentCount = tree->levelSize[level + 1];
  const int begin = tree->levelBegin[level];
  int nodes[MOST_FIRST_NODES + TREE_WIDTH];
  const int count = listNearBox(t, movers, level + 1, 0, parentCount, visit->reach, nodes);
  int found = 0;
  for (int i = 0; i < count; i++) {
    const int node = nodes[i] - begin;
    found += listNearBox(t, movers, level, node, node + 1, visit->reach, near + found);
  }
  visit->volumeTests += (parentCount + count) * TREE_WIDTH;
  return found;
}

/* True if a test starts with the boxes of all leaves, without nodes. */
static bool areBoxesFirst(const Traversal* t) {
  return t->testsToBoxes == 0 && t->tree->levelSize[1] <= t->mostBoxedNodes;
}

/* The same for all nodes of the level where tests start. */
CT_INLINE int listNearFirst(Traversal* t, Visit* visit, const Movers* movers, int level, int* near) {
  const int count = t->tree->levelSize[level];
  const bool areBoxed = areBoxesFirst(t);
  if (count > t->mostUnaskedNodes && !areBoxed) {
    return listNearOfMany(t, visit, movers, level, near);
  }
  visit->volumeTests += count * TREE_WIDTH;
  return areBoxed ? listNearBoxes(t, movers, near) : listNearBox(t, movers, level, 0, count, visit->reach, near);
}

/* Lists the leaves that may be near movers, and returns them. */
static const int* listNearLeaves(Traversal* t, Visit* visit, const Movers* movers, int* leafCount) {
  const Tree* tree = t->tree;
  const int top = areBoxesFirst(t) ? 1 : t->firstLevel;
  int* nodes = t->nearNodes; /* level by level */
  int count = listNearFirst(t, visit, movers, top, nodes);
  int done = 0;
  for (int level = top - 1; level > 0; level--) {
    const int last = count;
    for (int i = done; i < last; i++) {
      updateWorld(t->world, level, nodes[i]);
    }
    visit->volumeTests += (last - done) * TREE_WIDTH;
    for (; done < last; done++) {
      const int node = nodes[done] - tree->levelBegin[level];
      count += listNearBox(t, movers, level, node, node + 1, visit->reach, nodes + count);
    }
  }
  *leafCount = count - done;
  return nodes + done;
}

/* Tests movers against slots of up to NODES_AT_ONCE leaves near their box; all are static. False ends the search. */
CT_INLINE bool testNearSlots(Traversal* t, Visit* visit, const Movers* movers, const int* leaves, int leafCount,
                             bool areUpToDate) {
  uint64_t mask = 0;
  for (int i = leafCount - 1; i >= 0; i--) {
    if (!areUpToDate) {
      updateWorld(t->world, 0, leaves[i]);
    }
    mask = mask << TREE_WIDTH |
           nearBoxOfMovers(&t->world->members[t->world->entryOf[leaves[i]]], &movers->box, visit->reach);
  }
  for (; mask != 0; mask &= mask - 1) {
    const int i = __builtin_ctzll(mask);
    const int leaf = leaves[coveringNode(i)];
    const Sphere sphere = sphereOf(worldOf(t->world, leaf), memberIndex(i));
    const unsigned near = near16(&movers->block, sphere, visit->reach) & movers->bits;
    visit->particleTests += movers->end - movers->begin;
    if (near != 0 && !meetMovers(t, visit, movers, near, leaf * TREE_WIDTH + memberIndex(i), sphere, 0)) {
      return false;
    }
  }
  return true;
}

/* Tests movers, which have their box, against leaves in which nothing moves. False ends the search. */
static bool testStaticLeaves(Traversal* t, Visit* visit, Movers* movers) {
  if (t->testsToBoxes == 0) {
    limitBoxes(t, visit->reach, movers);
  }
  int leafCount;
  const int* leaves = listNearLeaves(t, visit, movers, &leafCount);
  visit->volumeTests += leafCount * TREE_WIDTH;
  for (int i = 0; i < leafCount; i += NODES_AT_ONCE) {
    const int some = leafCount - i < NODES_AT_ONCE ? leafCount - i : NODES_AT_ONCE;
    if (!(t->testsToBoxes == 0 ? testNearSlots(t, visit, movers, leaves + i, some, true)
                               : testNearSlots(t, visit, movers, leaves + i, some, false))) {
      return false;
    }
  }
  return true;
}

/* Tests movers against all static slots: all but [begin, end). False ends the search. */
static bool testStatic(Traversal* t, Visit* visit, Movers* movers, int begin, int end) {
  for (int leaf = movers->firstLeaf; leaf <= movers->lastLeaf; leaf++) {
    const bool areHere = movers->first == leaf * TREE_WIDTH; /* all that move */
    if (!testLeaf(t, visit, movers, leaf,
                  ~(areHere ? movers->bits : movingBits(t->view, begin, end, leaf * TREE_WIDTH)))) {
      return false;
    }
  }
  movers->box = boxOfMovers(&movers->block);
  return testStaticLeaves(t, visit, movers);
}

/* Takes slots [begin, end), which move, sixteen at a time. Returns how many times. */
static int takeAllMovers(Traversal* t, int begin, int end, Movers movers[MOST_MOVERS / TREE_WIDTH]) {
  updateFirst(t, coveringNode(begin), coveringNode(end - 1) + 1);
  const bool areInOneLeaf = coveringNode(begin) == coveringNode(end - 1);
  int count = 0;
  for (int slot = begin; slot < end; slot = movers[count++].end) {
    const int next = slot + TREE_WIDTH < end ? slot + TREE_WIDTH : end;
    movers[count].firstLeaf = coveringNode(begin);
    movers[count].lastLeaf = coveringNode(end - 1);
    takeMovers(t, slot, next, areInOneLeaf ? coveringNode(slot) * TREE_WIDTH : slot, &movers[count]);
  }
  return count;
}

/* Tests a view in which only slots [begin, end) move. It needs no volumes of mixed nodes. */
static void visitFew(Traversal* t, Visit* visit, int begin, int end) {
  Movers movers[MOST_MOVERS / TREE_WIDTH];
  const int count = takeAllMovers(t, begin, end, movers);
  for (int i = 0; i < count; i++) {
    if (!testStatic(t, visit, &movers[i], begin, end)) {
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

void CT_WIDE(traverseFew)(Traversal* t, const View* view, int begin, int end, CandidateFunction* function,
                          SureClashFunction* clashes, void* context, ctCounts* counts) {
  Visit visit = CT_WIDE(startVisit)(t, view, function, context);
  visit.clashes = clashes;
  visitFew(t, &visit, begin, end);
  addTests(counts, visit.volumeTests, visit.particleTests);
}

void CT_WIDE(traverseProbe)(Traversal* t, const View* view, const double point[3], double radius,
                            CandidateFunction* function, void* context, ctCounts* counts) {
  Visit visit = CT_WIDE(startVisit)(t, view, function, context);
  const double size = t->coordinateBound + sqrt(dot(point, point)) + radius;
  visit.reach = (float)(view->reach + floatMargin(size + fabs(view->reach)));
  Movers probe = {.probe = point, .end = 1, .bits = 1, .firstLeaf = 0, .lastLeaf = -1};
  store16(probe.block.x, all16((float)point[0]));
  store16(probe.block.y, all16((float)point[1]));
  store16(probe.block.z, all16((float)point[2]));
  store16(probe.block.r, blend16(probe.bits, all16(-INFINITY), all16((float)radius)));
  probe.box = boxOfMovers(&probe.block);
  const int root = treeRoot(t->tree);
  if (treeTop(t->tree) == 0) {
    testNearSlots(t, &visit, &probe, &root, 1, false);
  } else {
    updateFirst(t, 0, 0);
    testStaticLeaves(t, &visit, &probe);
  }
  addTests(counts, visit.volumeTests, visit.particleTests);
}

/* ---- Images of movers ---- */

/* Movers and their images. */
typedef struct ImagesOfMovers {
  Visit* visit;
  const PeriodicBox* box;
  Lattice lattice;
  int begin; /* slots [begin, end) move */
  int end;
} ImagesOfMovers;

/* Tests the pairs of a slot of this body with movers (bits) in their nearest images. False ends the search. */
static bool meetImages(Traversal* t, const ImagesOfMovers* images, const Movers* movers, unsigned near, int slot,
                       int body) {
  double positions[2][3];
  if (near != 0) {
    ctPositionInView(t, slot, body, positions[1]);
  }
  for (; near != 0; near &= near - 1) {
    const int slots[2] = {movers->first + __builtin_ctz(near), slot};
    const int excluded = exclusionMask(t->exclusions, coveringNode(slot), coveringNode(slots[0]));
    if ((t->exclusions->mask[excluded][memberIndex(slot)] >> memberIndex(slots[0]) & 1) != 0) {
      continue;
    }
    ctPositionInView(t, slots[0], bodyOfSlot(t->view, slots[0]), positions[0]);
    if (!tellNearestImage(t, images->box, slots, positions, images->visit->function, images->visit->context)) {
      return false;
    }
  }
  return true;
}

/* The movers (bits) that are near a sphere in an image. */
static unsigned nearMovers(const ImagesOfMovers* images, const Movers* movers, Sphere sphere) {
  images->visit->particleTests += TREE_WIDTH;
  return nearImages16(&images->lattice, &movers->block, sphere, images->visit->reach) & movers->bits;
}

/* Tests movers against images of static members of a node. False ends the search. */
static bool testStaticImages(Traversal* t, const ImagesOfMovers* images, const Movers* movers, Sphere around, int level,
                             int node) {
  updateWorld(t->world, level, node);
  const Block* block = worldOf(t->world, node);
  unsigned near = nearImages16(&images->lattice, block, around, images->visit->reach);
  if (level == 0) {
    images->visit->particleTests += TREE_WIDTH;
    near &= ~movingBits(t->view, images->begin, images->end, node * TREE_WIDTH);
    for (; near != 0; near &= near - 1) {
      const int k = __builtin_ctz(near);
      if (!meetImages(t, images, movers, nearMovers(images, movers, sphereOf(block, k)), node * TREE_WIDTH + k, 0)) {
        return false;
      }
      block = worldOf(t->world, node);
    }
    return true;
  }
  images->visit->volumeTests += TREE_WIDTH;
  int count;
  const int first = treeChildren(t->tree, level, node, &count);
  for (; near != 0; near &= near - 1) {
    if (!testStaticImages(t, images, movers, around, level - 1, first + __builtin_ctz(near))) {
      return false;
    }
  }
  return true;
}

/* Tests movers against images of later ones, unless both are of one body that does not turn. False ends the search. */
static bool testImagesOfMovers(Traversal* t, const ImagesOfMovers* images, const Movers* movers, Sphere around,
                               const Movers* others) {
  const unsigned rows = nearMovers(images, others, around) == 0 ? 0 : movers->bits;
  for (unsigned left = rows; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const int body = bodyOfSlot(t->view, movers->first + k);
    unsigned near = nearMovers(images, others, sphereOf(&movers->block, k));
    near &= movers == others ? ~0u << k : ~0u;
    for (unsigned other = near; keepsDirection(t->view, body) && other != 0; other &= other - 1) {
      const int l = __builtin_ctz(other);
      near &= ~((unsigned)(bodyOfSlot(t->view, others->first + l) == body) << l);
    }
    if (!meetImages(t, images, others, near, movers->first + k, body)) {
      return false;
    }
  }
  return true;
}

void CT_WIDE(traverseFewImages)(Traversal* t, const View* view, const PeriodicBox* box, int begin, int end,
                                CandidateFunction* function, void* context, ctCounts* counts) {
  Visit visit = CT_WIDE(startVisit)(t, view, function, context);
  visit.reach = (float)imageReach(t);
  const ImagesOfMovers images = {&visit, box, latticeOf(box), begin, end};
  Movers movers[MOST_MOVERS / TREE_WIDTH];
  const int count = takeAllMovers(t, begin, end, movers);
  bool continues = true;
  for (int i = 0; i < count && continues; i++) {
    const Sphere around = sphereAroundBlock(&movers[i].block);
    continues = testStaticImages(t, &images, &movers[i], around, treeTop(t->tree), treeRoot(t->tree));
    for (int j = i; j < count && continues; j++) {
      continues = testImagesOfMovers(t, &images, &movers[i], around, &movers[j]);
    }
  }
  addTests(counts, visit.volumeTests, visit.particleTests);
}
