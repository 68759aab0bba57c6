#include "tree.h"

#include <string.h>

static const Bound EMPTY_BOUND = {{0, 0, 0}, -1, -1};

/* Rounding of a few operations on coordinates of this size, with room to spare. */
static double slack(const Bound* bound) {
  return 1e-14 * (fabs(bound->centre[0]) + fabs(bound->centre[1]) + fabs(bound->centre[2]) + bound->surfaces);
}

/* Particles of a link that have no slot, if the link begins at this slot. */
static int idleAt(const Sequence* sequence, int slot, const int** idle) {
  const int link = sequence->slotLink[slot];
  const int begin = sequence->idleBegin[link];
  *idle = sequence->idleParticle + begin;
  return sequence->slotBegin[link] == slot ? sequence->idleBegin[link + 1] - begin : 0;
}

static void countParticles(Tree* tree, const Sequence* sequence) {
  const int* idle;
  for (int slot = 0; slot < sequence->slotCount; slot++) {
    tree->particles[slot / TREE_WIDTH] += (sequence->slotParticle[slot] != CT_NULL) + idleAt(sequence, slot, &idle);
  }
  for (int level = 1; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level - 1]; i++) {
      const int child = tree->levelBegin[level - 1] + i;
      tree->particles[treeParent(tree, level - 1, child)] += tree->particles[child];
    }
  }
}

bool ctTreeBuild(Tree* tree, Arena* arena, const Sequence* sequence) {
  tree->slotCount = sequence->slotCount;
  int size = sequence->slotCount;
  do {
    size = (size - 1) / TREE_WIDTH + 1;
    tree->levelSize[tree->levelCount] = size;
    const int padded = (size + TREE_WIDTH - 1) / TREE_WIDTH * TREE_WIDTH;
    tree->levelBegin[tree->levelCount + 1] = tree->levelBegin[tree->levelCount] + padded;
    tree->levelCount++;
  } while (size > 1);
  tree->itemCount = tree->levelBegin[tree->levelCount];
  const size_t items = (size_t)tree->itemCount;
  const size_t slots = (size_t)tree->levelSize[0] * TREE_WIDTH;
  tree->shortcut = ctArenaAllocate(arena, items, sizeof(ctTransform));
  tree->pose = ctArenaAllocate(arena, items, sizeof(ctTransform));
  tree->bound = ctArenaAllocate(arena, items, sizeof(Bound));
  tree->sum = ctArenaAllocate(arena, items, sizeof(double[3]));
  tree->particles = ctArenaAllocate(arena, items, sizeof(int));
  tree->x = ctArenaAllocate(arena, items, sizeof(float));
  tree->y = ctArenaAllocate(arena, items, sizeof(float));
  tree->z = ctArenaAllocate(arena, items, sizeof(float));
  tree->surfaces = ctArenaAllocate(arena, items, sizeof(float));
  tree->centres = ctArenaAllocate(arena, items, sizeof(float));
  tree->local = ctArenaAllocate(arena, slots, sizeof(double[3]));
  tree->dirty = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(int));
  tree->changedLeaf = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(int));
  tree->changeTime = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(int64_t));
  if (arena->failed) {
    return false;
  }
  countParticles(tree, sequence);
  return true;
}

/* ---- Bounds ---- */

/* About the middle of the box around spheres. `member` k has a centre and two radii; negative ones are left out. */
static Bound boundAround(const Bound* member, int count) {
  double low[3] = {0, 0, 0};
  double high[3] = {0, 0, 0};
  bool empty = true;
  for (int i = 0; i < count; i++) {
    if (member[i].surfaces < 0) {
      continue;
    }
    for (int k = 0; k < 3; k++) {
      const double from = member[i].centre[k] - member[i].surfaces;
      const double to = member[i].centre[k] + member[i].surfaces;
      low[k] = empty || from < low[k] ? from : low[k];
      high[k] = empty || to > high[k] ? to : high[k];
    }
    empty = false;
  }
  if (empty) {
    return EMPTY_BOUND;
  }
  Bound bound = {{0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])}, 0, 0};
  for (int i = 0; i < count; i++) {
    if (member[i].surfaces < 0) {
      continue;
    }
    const double distance = sqrt(squaredDistance(bound.centre, member[i].centre));
    bound.surfaces = larger(bound.surfaces, distance + member[i].surfaces);
    bound.centres = larger(bound.centres, distance + member[i].centres);
  }
  const double rounding = slack(&bound);
  bound.surfaces += rounding;
  bound.centres += rounding;
  return bound;
}

/* ---- Update, bottom-up ---- */

static int firstLink(const Tree* tree, const Sequence* sequence, int leaf) {
  return leaf < tree->levelSize[0] ? sequence->slotLink[leaf * TREE_WIDTH] : CT_NULL;
}

static void add(double sum[3], const double x[3]) {
  sum[0] += x[0];
  sum[1] += x[1];
  sum[2] += x[2];
}

/* Adds the positions of a slot's particle and of the idle ones of a link that begins there; `frame` is the link's. */
static void addSlot(const Tree* tree, const Sequence* sequence, int slot, const ctTransform* frame, double sum[3]) {
  if (sequence->slotParticle[slot] != CT_NULL) {
    add(sum, tree->local[slot]);
  }
  const int* idle;
  const int count = idleAt(sequence, slot, &idle);
  for (int i = 0; i < count; i++) {
    double x[3];
    sequenceLocal(sequence, idle[i], x);
    transformPoint(frame, x, x);
    add(sum, x);
  }
}

static void refreshLeaf(Tree* tree, const Sequence* sequence, int leaf) {
  const int begin = leaf * TREE_WIDTH;
  const int end = begin + TREE_WIDTH < tree->slotCount ? begin + TREE_WIDTH : tree->slotCount;
  int link = firstLink(tree, sequence, leaf);
  ctTransform frame = transformIdentity();
  Bound member[TREE_WIDTH];
  double sum[3] = {0, 0, 0};
  for (int slot = begin; slot < end; slot++) {
    for (; link < sequence->slotLink[slot]; link++) {
      const ctTransform step = ctSequenceStep(sequence, link);
      frame = transformCompose(&frame, &step);
    }
    const int particle = sequence->slotParticle[slot];
    Bound* sphere = &member[slot - begin];
    *sphere = EMPTY_BOUND;
    if (particle != CT_NULL) {
      sequenceLocal(sequence, particle, tree->local[slot]);
      transformPoint(&frame, tree->local[slot], tree->local[slot]);
      memcpy(sphere->centre, tree->local[slot], sizeof sphere->centre);
      sphere->surfaces = sequence->slotRadius[slot];
      sphere->centres = 0;
    }
    addSlot(tree, sequence, slot, &frame, sum);
  }
  for (const int next = firstLink(tree, sequence, leaf + 1); link < next; link++) {
    const ctTransform step = ctSequenceStep(sequence, link);
    frame = transformCompose(&frame, &step);
  }
  tree->shortcut[leaf] = frame;
  memcpy(tree->sum[leaf], sum, sizeof sum);
  tree->bound[leaf] = boundAround(member, end - begin);
}

/* Adds the sum of an item's positions as its parent's frame has them. */
static void addItem(const Tree* tree, int item, const double own[3], int particles, double sum[3]) {
  double x[3];
  rotate(tree->pose[item].rotation, own, x);
  for (int k = 0; k < 3; k++) {
    sum[k] += x[k] + particles * tree->pose[item].translation[k];
  }
}

static void refreshNode(Tree* tree, int level, int item) {
  int count;
  const int first = treeChildren(tree, level, item, &count);
  ctTransform pose = transformIdentity();
  Bound member[TREE_WIDTH];
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < count; i++) {
    const int child = first + i;
    const Bound* own = &tree->bound[child];
    tree->pose[child] = pose;
    member[i] = *own;
    transformPoint(&pose, own->centre, member[i].centre);
    tree->x[child] = (float)member[i].centre[0];
    tree->y[child] = (float)member[i].centre[1];
    tree->z[child] = (float)member[i].centre[2];
    tree->surfaces[child] = (float)own->surfaces;
    tree->centres[child] = (float)own->centres;
    addItem(tree, child, tree->sum[child], tree->particles[child], sum);
    pose = transformCompose(&pose, &tree->shortcut[child]);
  }
  tree->shortcut[item] = pose;
  memcpy(tree->sum[item], sum, sizeof sum);
  tree->bound[item] = boundAround(member, count);
}

static void refreshRoot(Tree* tree) {
  tree->pose[treeRoot(tree)] = transformIdentity();
}

static void noteChange(Tree* tree, int firstLeaf) {
  while (tree->changeCount > 0 && tree->changedLeaf[tree->changeCount - 1] >= firstLeaf) {
    tree->changeCount--;
  }
  tree->changedLeaf[tree->changeCount] = firstLeaf;
  tree->changeTime[tree->changeCount++] = ++tree->time;
}

void ctTreeRefresh(Tree* tree, const Sequence* sequence) {
  for (int leaf = 0; leaf < tree->levelSize[0]; leaf++) {
    refreshLeaf(tree, sequence, leaf);
  }
  for (int level = 1; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      refreshNode(tree, level, tree->levelBegin[level] + i);
    }
  }
  refreshRoot(tree);
  noteChange(tree, 0);
}

int ctTreeUpdate(Tree* tree, const Sequence* sequence, int* leaves, int count) {
  ctSortInts(leaves, count);
  int dirty = 0;
  for (int i = 0; i < count; i++) {
    if (dirty == 0 || tree->dirty[dirty - 1] != leaves[i]) {
      tree->dirty[dirty++] = leaves[i];
      refreshLeaf(tree, sequence, leaves[i]);
    }
  }
  if (dirty > 0) {
    noteChange(tree, tree->dirty[0]);
  }
  int updated = dirty;
  for (int level = 1; level < tree->levelCount; level++) {
    int parents = 0;
    for (int i = 0; i < dirty; i++) {
      const int parent = treeParent(tree, level - 1, tree->dirty[i]);
      if (parents == 0 || tree->dirty[parents - 1] != parent) {
        tree->dirty[parents++] = parent;
        refreshNode(tree, level, parent);
      }
    }
    dirty = parents;
    updated += dirty;
  }
  return updated;
}

/* ---- Frames ---- */

ctTransform ctTreeFrame(const Tree* tree, int level, int item) {
  int path[TREE_MAX_LEVELS];
  for (int l = level; l < treeTop(tree); l++) {
    path[l] = item;
    item = treeParent(tree, l, item);
  }
  ctTransform frame = tree->pose[item];
  for (int l = treeTop(tree) - 1; l >= level; l--) {
    frame = transformCompose(&frame, &tree->pose[path[l]]);
  }
  return frame;
}

ctTransform ctTreeLinkInLeaf(const Sequence* sequence, int link) {
  const int leaf = sequence->slotBegin[link] / TREE_WIDTH;
  ctTransform frame = transformIdentity();
  for (int l = sequence->slotLink[leaf * TREE_WIDTH]; l < link; l++) {
    const ctTransform step = ctSequenceStep(sequence, l);
    frame = transformCompose(&frame, &step);
  }
  return frame;
}

double ctTreeSquaredDistance(const Tree* tree, int slotA, int slotB) {
  double a[3];
  double b[3];
  memcpy(a, tree->local[slotA], sizeof a);
  memcpy(b, tree->local[slotB], sizeof b);
  int itemA = slotA / TREE_WIDTH;
  int itemB = slotB / TREE_WIDTH;
  for (int level = 0; itemA != itemB; level++) {
    transformPoint(&tree->pose[itemA], a, a);
    transformPoint(&tree->pose[itemB], b, b);
    itemA = treeParent(tree, level, itemA);
    itemB = treeParent(tree, level, itemB);
  }
  return squaredDistance(a, b);
}

ctTransform ctTreeRelative(const Tree* tree, const Sequence* sequence, int linkA, int linkB) {
  ctTransform a = ctTreeLinkInLeaf(sequence, linkA);
  ctTransform b = ctTreeLinkInLeaf(sequence, linkB);
  int itemA = sequence->slotBegin[linkA] / TREE_WIDTH;
  int itemB = sequence->slotBegin[linkB] / TREE_WIDTH;
  for (int level = 0; itemA != itemB; level++) {
    a = transformCompose(&tree->pose[itemA], &a);
    b = transformCompose(&tree->pose[itemB], &b);
    itemA = treeParent(tree, level, itemA);
    itemB = treeParent(tree, level, itemB);
  }
  const ctTransform inverse = transformInverse(&a);
  return transformCompose(&inverse, &b);
}

/* ---- Sums ---- */

/* Slots [slotBegin, slotEnd) of an item: adds their particles' positions to sum, in the item's frame; returns how many.
 */
static int sumItem(const Tree* tree, const Sequence* sequence, int level, int item, int slotBegin, int slotEnd,
                   double sum[3]) {
  int end;
  const int begin = treeSlots(tree, level, item, &end);
  if (slotEnd <= begin || end <= slotBegin) {
    return 0;
  }
  if (slotBegin <= begin && end <= slotEnd) {
    add(sum, tree->sum[item]);
    return tree->particles[item];
  }
  int particles = 0;
  if (level == 0) {
    for (int slot = begin > slotBegin ? begin : slotBegin; slot < end && slot < slotEnd; slot++) {
      const int* idle;
      const int idleCount = idleAt(sequence, slot, &idle);
      const ctTransform frame =
          idleCount > 0 ? ctTreeLinkInLeaf(sequence, sequence->slotLink[slot]) : transformIdentity();
      addSlot(tree, sequence, slot, &frame, sum);
      particles += (sequence->slotParticle[slot] != CT_NULL) + idleCount;
    }
    return particles;
  }
  int count;
  const int first = treeChildren(tree, level, item, &count);
  for (int child = first; child < first + count; child++) {
    double own[3] = {0, 0, 0};
    const int inChild = sumItem(tree, sequence, level - 1, child, slotBegin, slotEnd, own);
    if (inChild > 0) {
      addItem(tree, child, own, inChild, sum);
      particles += inChild;
    }
  }
  return particles;
}

int ctTreeSum(const Tree* tree, const Sequence* sequence, int linkBegin, int linkEnd, double sum[3]) {
  sum[0] = sum[1] = sum[2] = 0;
  return sumItem(tree, sequence, treeTop(tree), treeRoot(tree), sequence->slotBegin[linkBegin],
                 sequence->slotBegin[linkEnd], sum);
}

/* ---- Validation ---- */

/* Bounds of this item and the particles below it, which lie in [begin, end) and `frame` takes to a common frame. */
static bool itemHolds(const Tree* tree, const Sequence* sequence, int level, int item) {
  int end;
  const int begin = treeSlots(tree, level, item, &end);
  const ctTransform frame = ctTreeFrame(tree, level, item);
  const Bound* bound = &tree->bound[item];
  double centre[3];
  transformPoint(&frame, bound->centre, centre);
  for (int slot = begin; slot < end; slot++) {
    if (sequence->slotParticle[slot] == CT_NULL) {
      continue;
    }
    const ctTransform leaf = ctTreeFrame(tree, 0, slot / TREE_WIDTH);
    double x[3];
    transformPoint(&leaf, tree->local[slot], x);
    const double distance = sqrt(squaredDistance(x, centre));
    /* Both positions went through frames in the world: allow for their rounding. */
    const double rounding = 1e-13 * (sqrt(dot(x, x)) + sqrt(dot(centre, centre)) + bound->surfaces);
    if (distance > bound->centres + rounding || distance + sequence->slotRadius[slot] > bound->surfaces + rounding) {
      return false;
    }
  }
  return true;
}

bool ctTreeBoundsHold(const Tree* tree, const Sequence* sequence) {
  for (int level = 0; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      if (!itemHolds(tree, sequence, level, tree->levelBegin[level] + i)) {
        return false;
      }
    }
  }
  return true;
}
