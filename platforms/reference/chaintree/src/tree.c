#include "tree.h"

#include <string.h>

#include "costs.h"
#include "wide.h"

/* Writes what updates never change: which members there are, and the radii of particles. */
static void clearMembers(Tree* tree, const Sequence* sequence) {
  for (int slot = 0; slot < tree->levelBegin[1] * TREE_WIDTH; slot++) {
    const bool isModelled = slot < tree->slotCount && slotIsModelled(sequence, slot);
    Leaf* leaf = &tree->leaf[coveringNode(slot)];
    leaf->r[memberIndex(slot)] = isModelled ? (float)slotRadius(sequence, slot) : -INFINITY;
  }
  for (int node = tree->levelBegin[1]; node < tree->nodeCount; node++) {
    Members* members = treeMembers(tree, node);
    for (int k = 0; k < TREE_WIDTH; k++) {
      members->block.r[k] = -INFINITY;
      members->centres[k] = -INFINITY;
    }
  }
}

void ctTreeLayOut(Tree* tree, int slotCount) {
  tree->slotCount = slotCount;
  int size = slotCount;
  do {
    size = (size - 1) / TREE_WIDTH + 1;
    tree->levelSize[tree->levelCount] = size;
    const int padded = (size + TREE_WIDTH - 1) / TREE_WIDTH * TREE_WIDTH;
    tree->levelBegin[tree->levelCount + 1] = tree->levelBegin[tree->levelCount] + padded;
    tree->levelCount++;
  } while (size > 1);
  tree->nodeCount = tree->levelBegin[tree->levelCount];
}

bool ctTreeBuild(Tree* tree, Arena* arena, const Sequence* sequence, const struct Wide* wide) {
  tree->wide = wide;
  tree->builtFrom = NO_REVISION;
  tree->knownLink = CT_NULL;
  ctTreeLayOut(tree, sequence->slotCount);
  const size_t nodes = (size_t)tree->nodeCount;
  tree->shortcut = ctArenaAllocate(arena, nodes, sizeof(Frame));
  tree->pose = ctArenaAllocate(arena, nodes, sizeof(Frame));
  tree->bound = ctArenaAllocate(arena, nodes, sizeof(Bound));
  tree->contentRevision = ctArenaAllocate(arena, nodes, sizeof(Revision));
  tree->shortcutRevision = ctArenaAllocate(arena, nodes, sizeof(Revision));
  tree->leaf = ctArenaAllocate(arena, (size_t)tree->levelBegin[1], sizeof(Leaf));
  tree->members = ctArenaAllocate(arena, nodes - (size_t)tree->levelBegin[1], sizeof(Members));
  tree->stem = ctArenaAllocate(arena, (size_t)sequence->openPathCount, sizeof(Frame));
  tree->sum = ctArenaAllocate(arena, nodes, sizeof(double[3]));
  tree->hasSum = ctArenaAllocate(arena, nodes, sizeof(bool));
  tree->particles = ctArenaAllocate(arena, nodes, sizeof(int));
  tree->dirty = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(int));
  tree->loose = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(int));
  tree->isLoose = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(bool));
  tree->changes.shortcutLeaf = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(int));
  tree->changes.shortcutRevision = ctArenaAllocate(arena, (size_t)tree->levelSize[0], sizeof(Revision));
  if (arena->failed) {
    return false;
  }
  ctTreeCountParticles(tree, sequence);
  return true;
}

/* ---- Update, bottom-up ---- */

static void refreshRoot(Tree* tree) {
  tree->pose[treeRoot(tree)] = transformIdentity();
}

/* Begins a change of the state. */
static void beginChange(Tree* tree) {
  tree->changes.ofState = ++tree->changes.now;
}

void ctTreeMakeOutdated(Tree* tree) {
  beginChange(tree);
  noteShortcut(&tree->changes, 0);
}

static void forgetLoose(Tree* tree) {
  for (int i = 0; i < tree->looseCount; i++) {
    tree->isLoose[tree->loose[i]] = false;
  }
  tree->looseCount = 0;
}

void ctTreeRefresh(Tree* tree, const Sequence* sequence) {
  clearMembers(tree, sequence);
  for (int leaf = 0; leaf < tree->levelSize[0]; leaf++) {
    tree->wide->refreshLeaf(tree, sequence, leaf);
  }
  for (int level = 1; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      const int node = tree->levelBegin[level] + i;
      int count;
      const int first = treeChildren(tree, level, node, &count);
      tree->pose[first] = transformIdentity();
      for (int k = 0; k < count; k++) {
        tree->dirty[k] = first + k;
      }
      tree->wide->refreshInnerNode(tree, level, node, tree->dirty, count);
    }
  }
  refreshRoot(tree);
  forgetLoose(tree);
  tree->builtFrom = tree->changes.now;
}

/* Recomputes the leaf that holds the step from a link to the next, once an update. Dirty leaves are listed: returns how
 * many there are. */
static int refreshStep(Tree* tree, const Sequence* s, int link, int dirty) {
  const int leaf = coveringNode(s->slotBegin[link + 1] - 1);
  if (tree->contentRevision[leaf] != tree->changes.now) {
    tree->dirty[dirty++] = leaf;
    tree->wide->refreshLeaf(tree, s, leaf);
  }
  return dirty;
}

/* The steps at both ends of the intervals that these links move. */
static int refreshSteps(Tree* tree, const Sequence* s, const int* links, int count) {
  int dirty = 0;
  for (int i = 0; i < count; i++) {
    const int end = sequenceEnd(s, links[i]);
    if (s->sideBranchPart[links[i]] == notInSideBranch) {
      dirty = refreshStep(tree, s, links[i] - 1, dirty);
      if (end < s->linkCount) {
        dirty = refreshStep(tree, s, end - 1, dirty);
      }
    }
  }
  return dirty;
}

/* Recomputes what these links move, if they are in side branches. Call after whole leaves have been recomputed: side
 * branches start from them. If bounds may be loose, they are only widened. */
static int refreshSideBranches(Tree* tree, const Sequence* s, const int* links, int count, int dirty,
                               bool areBoundsLoose) {
  int done = 0; /* all before this link has been recomputed */
  for (int i = 0; i < count; i++) {
    const int link = links[i];
    if (s->sideBranchPart[link] != notInSideBranch && link >= done) {
      done = sequenceEnd(s, link);
      for (int leaf = coveringNode(s->slotBegin[link]); leaf * TREE_WIDTH < s->slotBegin[done]; leaf++) {
        if (tree->contentRevision[leaf] != tree->changes.now) {
          tree->dirty[dirty++] = leaf;
        }
        const bool holds = tree->wide->refreshSideBranch(tree, s, link, leaf);
        if (!areBoundsLoose) {
          tree->wide->refreshLeafBound(tree, leaf);
        } else if (!holds) {
          tree->wide->widenAbove(tree, leaf);
        }
      }
    }
  }
  return dirty;
}

/* Lists the leaves of the intervals that these links move. What lies behind them moves by rounding alone, since
 * positions are a function of the state. */
static void listIntervals(Tree* tree, const Sequence* s, const int* links, int count) {
  for (int i = 0; i < count; i++) {
    const int begin = coveringNode(s->slotBegin[links[i]]);
    const int end = coveringNode(s->slotBegin[sequenceEnd(s, links[i])] - 1) + 1;
    if (end - begin > MOST_LEAVES_LISTED) {
      tree->changes.unlisted = tree->changes.now;
      return;
    }
    for (int leaf = begin; leaf < end; leaf++) {
      listLeaf(&tree->changes, leaf);
    }
  }
}

/* Recomputes the nodes over dirty ones of a level, level by level; returns how many. */
static int refreshAbove(Tree* tree, int level, int dirty) {
  int updated = 0;
  for (level++; level < tree->levelCount; level++) {
    int parents = 0;
    int end;
    for (int i = 0; i < dirty; i = end) {
      const int parent = treeParent(tree, level - 1, tree->dirty[i]);
      for (end = i + 1; end < dirty && treeParent(tree, level - 1, tree->dirty[end]) == parent; end++) {
      }
      tree->wide->refreshInnerNode(tree, level, parent, tree->dirty + i, end - i);
      tree->dirty[parents++] = parent;
    }
    dirty = parents;
    updated += dirty;
  }
  return updated;
}

/* Notes that dirty leaves have loose bounds; returns how many nodes are over them. */
static int noteLoose(Tree* tree, int dirty) {
  int loose = 0;
  for (int i = 0; i < dirty; i++) {
    int node = tree->dirty[i];
    int before = i > 0 ? tree->dirty[i - 1] : CT_NULL;
    if (!tree->isLoose[node]) {
      tree->isLoose[node] = true;
      tree->loose[tree->looseCount++] = node;
    }
    for (int level = 0; level < treeTop(tree); level++) {
      node = treeParent(tree, level, node);
      before = before == CT_NULL ? CT_NULL : treeParent(tree, level, before);
      if (node == before) {
        break;
      }
      loose++;
    }
  }
  return loose;
}

void ctTreeTighten(Tree* tree) {
  if (tree->looseCount > 0) {
    tree->changes.now++; /* caches of the widened bounds take the tight ones */
    ctSortInts(tree->loose, tree->looseCount);
    for (int i = 0; i < tree->looseCount; i++) {
      tree->dirty[i] = tree->loose[i];
      tree->wide->refreshLeafBound(tree, tree->loose[i]);
    }
    refreshAbove(tree, 0, tree->looseCount);
    forgetLoose(tree);
  }
}

/* True if these links move nothing but side branches. */
static bool moveSideBranches(const Sequence* s, const int* links, int count) {
  for (int i = 0; i < count; i++) {
    if (s->sideBranchPart[links[i]] == notInSideBranch) {
      return false;
    }
  }
  return true;
}

int ctTreeUpdate(Tree* tree, const Sequence* sequence, const int* links, int count) {
  beginChange(tree);
  tree->builtFrom = tree->changes.now;
  if (moveSideBranches(sequence, links, count)) {
    const int leaves = refreshSideBranches(tree, sequence, links, count, 0, true);
    return leaves + noteLoose(tree, leaves);
  }
  int dirty = refreshSteps(tree, sequence, links, count);
  dirty = refreshSideBranches(tree, sequence, links, count, dirty, false);
  listIntervals(tree, sequence, links, count);
  ctSortInts(tree->dirty, dirty);
  for (int i = 0; i < dirty; i++) {
    if (tree->shortcutRevision[tree->dirty[i]] == tree->changes.now) {
      noteShortcut(&tree->changes, tree->dirty[i]);
      break;
    }
  }
  return dirty + refreshAbove(tree, 0, dirty);
}

int ctTreeDisplace(Tree* tree, const Sequence* sequence, const int* particles, const Frame* inLeaf, int count) {
  beginChange(tree);
  tree->builtFrom = tree->changes.now;
  int dirty = 0;
  for (int i = 0; i < count; i++) {
    const int leaf = particleLeaf(sequence, particles[i]);
    const int slot = particleSlot(sequence, particles[i]);
    if (tree->contentRevision[leaf] != tree->changes.now) {
      noteLeaf(tree, leaf);
      tree->dirty[dirty++] = leaf;
    }
    if (slot != CT_NULL && !tree->wide->refreshSlot(tree, sequence, slot, &inLeaf[i])) {
      tree->wide->widenAbove(tree, leaf);
    }
  }
  ctSortInts(tree->dirty, dirty);
  return dirty + noteLoose(tree, dirty);
}

/* ---- Frames ---- */

Frame ctTreeFrame(const Tree* tree, int level, int node) {
  int path[TREE_MAX_LEVELS];
  for (int l = level; l < treeTop(tree); l++) {
    path[l] = node;
    node = treeParent(tree, l, node);
  }
  Frame frame = tree->pose[node];
  for (int l = treeTop(tree) - 1; l >= level; l--) {
    frame = transformCompose(&frame, &tree->pose[path[l]]);
  }
  return frame;
}

Frame ctTreeLinkInLeaf(const Tree* tree, const Sequence* sequence, int link) {
  return ctTreeLinkInThisLeaf(tree, sequence, link, coveringNode(sequence->slotBegin[link]));
}

Frame ctTreeLinkInThisLeaf(const Tree* tree, const Sequence* sequence, int link, int leaf) {
  return tree->wide->linkInLeaf(sequence, link, leaf);
}

Frame ctTreeKnowLink(Tree* tree, const Sequence* sequence, int link, int change) {
  tree->knownLink = link;
  tree->knownChange = change;
  tree->knownInLeaf = tree->wide->linkAndLocalFrames(sequence, link, &tree->knownLocalFrames);
  return tree->knownInLeaf;
}

/* The frame of the parent of a link in a side branch, in the frame of the leaf where the link begins. */
static Frame sideBranchParentInLeaf(const Tree* tree, const Sequence* sequence, int link) {
  const int parent = sequence->parent[link];
  const int head = sideBranchHead(sequence, link);
  const bool beginsHere = coveringNode(sequence->slotBegin[head]) == coveringNode(sequence->slotBegin[link]);
  const Frame stem = beginsHere ? tree->stem[sequenceOpenPath(sequence, head)] : transformIdentity();
  if (link == head) {
    return stem;
  }
  Walk walk;
  walkBeginInSideBranch(&walk, sequence, parent, &stem);
  return frameOfColumns(&walk.frame);
}

/* The same in a flexible scene: the line through the axis particles where they are now. */
static void walkToAxisNow(const Tree* tree, const Sequence* sequence, int link, double point[3], double direction[3]) {
  const Frame frame = ctTreeLinkInLeaf(tree, sequence, link);
  double from[3];
  sequenceAxisEnds(sequence, link, from, point);
  subtract(point, from, direction);
  rotate(&frame, direction, direction);
  transformPoint(&frame, point, point);
}

void ctTreeWalkToAxis(const Tree* tree, const Sequence* sequence, int link, double point[3], double direction[3]) {
  if (sequence->isFlexible) {
    walkToAxisNow(tree, sequence, link, point, direction);
    return;
  }
  sequenceAxis(sequence, link, sequence->reference, direction);
  if (sequence->sideBranchPart[link] != notInSideBranch) {
    const Frame parent = sideBranchParentInLeaf(tree, sequence, link);
    sequenceOffset(sequence, link, point);
    transformPoint(&parent, point, point);
    rotate(&parent, direction, direction);
  } else {
    const Frame frame = ctTreeLinkInLeaf(tree, sequence, link);
    translationOf(&frame, point);
    rotate(&frame, direction, direction);
  }
}

double ctTreeSquaredDistance(const Tree* tree, int slotA, int slotB) {
  double a[3];
  double b[3];
  treeLocal(tree, slotA, a);
  treeLocal(tree, slotB, b);
  int nodeA = coveringNode(slotA);
  int nodeB = coveringNode(slotB);
  for (int level = 0; nodeA != nodeB; level++) {
    transformPoint(&tree->pose[nodeA], a, a);
    transformPoint(&tree->pose[nodeB], b, b);
    nodeA = treeParent(tree, level, nodeA);
    nodeB = treeParent(tree, level, nodeB);
  }
  return squaredDistance(a, b);
}

void ctTreeSlotInWorld(const Tree* tree, int slot, double position[3]) {
  treeLocal(tree, slot, position);
  int node = coveringNode(slot);
  for (int level = 0; level < tree->levelCount; level++) {
    transformPoint(&tree->pose[node], position, position);
    node = level < treeTop(tree) ? treeParent(tree, level, node) : node;
  }
}

double ctTreeSquaredImageDistance(const Tree* tree, int slotA, int slotB, const Image* image) {
  double a[3];
  double b[3];
  ctTreeSlotInWorld(tree, slotA, a);
  ctTreeSlotInWorld(tree, slotB, b);
  return squaredImageDistance(a, b, image);
}

Frame ctTreeRelative(const Tree* tree, const Sequence* sequence, int linkA, int linkB) {
  Frame a = ctTreeLinkInLeaf(tree, sequence, linkA);
  Frame b = ctTreeLinkInLeaf(tree, sequence, linkB);
  int nodeA = coveringNode(sequence->slotBegin[linkA]);
  int nodeB = coveringNode(sequence->slotBegin[linkB]);
  for (int level = 0; nodeA != nodeB; level++) {
    a = transformCompose(&tree->pose[nodeA], &a);
    b = transformCompose(&tree->pose[nodeB], &b);
    nodeA = treeParent(tree, level, nodeA);
    nodeB = treeParent(tree, level, nodeB);
  }
  const Frame inverse = transformInverse(&a);
  return transformCompose(&inverse, &b);
}

/* ---- Validation ---- */

/* True if the bound of a node holds all particles below it. */
static bool nodeHolds(const Tree* tree, const Sequence* sequence, int level, int node) {
  int end;
  const int begin = treeSlots(tree, level, node, &end);
  const Frame frame = ctTreeFrame(tree, level, node);
  const Bound* bound = &tree->bound[node];
  double centre[3] = {bound->x, bound->y, bound->z};
  transformPoint(&frame, centre, centre);
  for (int slot = begin; slot < end; slot++) {
    if (!slotIsModelled(sequence, slot)) {
      continue;
    }
    const Frame leaf = ctTreeFrame(tree, 0, coveringNode(slot));
    double x[3];
    treeLocal(tree, slot, x);
    transformPoint(&leaf, x, x);
    const double distance = sqrt(squaredDistance(x, centre));
    /* Both positions went through up to 9 products to the world, each off by some v = 2^-53 of the coordinates. 1e-13
     * is 900 v. */
    const double rounding = 1e-13 * (sqrt(dot(x, x)) + sqrt(dot(centre, centre)) + (double)bound->r);
    if (distance > (double)bound->centres + rounding ||
        distance + slotRadius(sequence, slot) > (double)bound->r + rounding) {
      return false;
    }
  }
  return true;
}

bool ctTreeBoundsHold(const Tree* tree, const Sequence* sequence) {
  for (int level = 0; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      if (!nodeHolds(tree, sequence, level, tree->levelBegin[level] + i)) {
        return false;
      }
    }
  }
  return true;
}
