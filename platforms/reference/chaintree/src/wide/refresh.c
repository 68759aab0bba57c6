/* Recomputes nodes of the tree from what is below them. */
#include <string.h>

#include "../volume.h"
#include "set.h"

/* ---- Bounds ---- */

/* A sphere around the members of a node, whose coordinates in float are from the node's own origin. Room for rounding:
 * 1e-6 is 17 u (u = 2^-24) of B, the sum of the magnitudes of the sphere's centre and radius. The members' centres are
 * rounded (u of B), so are radii (u), and the sphere's radius is computed with up to 5 u of it: 7 u of B. */
static Bound boundOfMembers(const Block* block, const float* centres) {
  const Sphere middle = middleOfBlock(block);
  if (middle.r < 0) {
    return (Bound){0, 0, 0, -INFINITY, -INFINITY};
  }
  /* As radiusAbout, for both radii at a time: the most of a number is the least of its opposite. */
  const Float16 zero = all16(0);
  const Float16 away = sqrt16(squaredFrom(block, middle.x, middle.y, middle.z));
  const Float16 ends[4] = {sub16(zero, add16(away, load16(block->r))), sub16(zero, add16(away, load16(centres))), zero,
                           zero};
  float least[4];
  least4x16(ends, least);
  const float r = -least[0];
  const float rounding = 1e-6f * (fabsf(middle.x) + fabsf(middle.y) + fabsf(middle.z) + r) + FLOAT_FLOOR;
  return (Bound){middle.x, middle.y, middle.z, r + rounding, rounding - least[1]};
}

static Bound boundOfLeaf(const Leaf* leaf) {
  Block block;
  float centres[TREE_WIDTH];
  leafBlock(leaf, &block);
  leafCentres(leaf, centres);
  return boundOfMembers(&block, centres);
}

/* ---- Update, bottom-up ---- */

/* Most links whose local frames are computed one by one. */
enum { FEW_LINKS = 3 };

/* Computes the local frames of torsion joints (bits) among sixteen links, starting at `begin`. */
static void computeTorsionFrames(const Sequence* s, int begin, unsigned torsions, LocalFrames* localFrames) {
  double w[3][TREE_WIDTH];
  for (int i = 0; i < TREE_WIDTH; i++) {
    double offset[3] = {0, 0, 0};
    double vector[3] = {0, 0, 0};
    if ((torsions >> i & 1) != 0) {
      sequenceOffset(s, begin + i, offset);
      sequenceRodrigues(s, begin + i, vector);
    }
    for (int k = 0; k < 3; k++) {
      w[k][i] = vector[k];
      localFrames->m[4 * k + 3][i] = offset[k];
    }
  }
  for (int i = 0; i < TREE_WIDTH; i++) {
    rotationFromRodrigues(w[0][i], w[1][i], w[2][i], &localFrames->m[0][i], TREE_WIDTH);
  }
}

/* Computes the local frames of links [begin, end), all of which have placements. */
static void computePlacedFrames(const Sequence* s, int begin, int end, LocalFrames* localFrames) {
  double q[4][TREE_WIDTH];
  for (int i = 0; i < TREE_WIDTH; i++) {
    const int link = begin + i < end ? begin + i : begin;
    const Placement* placement = placementOf(s, link);
    for (int k = 0; k < 4; k++) {
      q[k][i] = placement->quaternion[k];
    }
    for (int k = 0; k < 3; k++) {
      localFrames->m[4 * k + 3][i] = placement->position[k];
    }
  }
  for (int i = 0; i < TREE_WIDTH; i++) {
    rotationFromUnit(q[0][i], q[1][i], q[2][i], q[3][i], &localFrames->m[0][i], TREE_WIDTH);
  }
}

/* Computes the local frame of one link. */
static void computeLocalFrame(const Sequence* s, int link, LocalFrames* localFrames) {
  const Frame localFrame = sequenceLocalFrame(s, link);
  for (int k = 0; k < 12; k++) {
    localFrames->m[k][link - localFrames->first] = localFrame.m[k / 4][k % 4];
  }
}

/* Computes the local frames of links [begin, end), at most TREE_WIDTH. */
static void computeLocalFrames(const Sequence* s, int begin, int end, LocalFrames* localFrames) {
  localFrames->first = begin;
  if (end - begin <= FEW_LINKS) {
    for (int link = begin; link < end; link++) {
      computeLocalFrame(s, link, localFrames);
    }
    return;
  }
  const unsigned all = (1u << (end - begin)) - 1;
  unsigned torsions = 0;
  for (int link = begin; link < end; link++) {
    torsions |= (unsigned)hasAngle(s, link) << (link - begin);
  }
  if (torsions == 0) {
    computePlacedFrames(s, begin, end, localFrames);
    return;
  }
  computeTorsionFrames(s, begin, torsions, localFrames);
  for (unsigned left = all & ~torsions; left != 0; left &= left - 1) {
    computeLocalFrame(s, begin + __builtin_ctz(left), localFrames);
  }
}

/* If a walk is at the head of a side branch, stores the frame of the link on which that hangs. */
CT_INLINE void keepStem(Tree* tree, const Sequence* s, const Walk* walk) {
  if (s->sideBranchPart[walk->link] == beginsSideBranch) {
    tree->stem[sequenceOpenPath(s, walk->link)] = frameOfColumns(&walk->stem[0]);
  }
}

/* Computes the position of a particle of a link, which has this frame, and puts it into its leaf. */
CT_INLINE void placeParticle(const Sequence* s, const Columns* frame, int link, int slot, Leaf* leaf, double x[3]) {
  sequenceLocal(s, link, s->slotParticle[slot], x);
  columnsPoint(frame, x, x);
  leaf->x[memberIndex(slot)] = x[0];
  leaf->y[memberIndex(slot)] = x[1];
  leaf->z[memberIndex(slot)] = x[2];
}

/* Computes the positions of slots [begin, end) of a leaf. Takes the walk from the link of the first one to that of the
 * last; the local frames between are known. Inlined: a call would put the walk's frame into memory. */
CT_INLINE void positionSlots(Tree* tree, const Sequence* s, Walk* walk, const LocalFrames* localFrames, int begin,
                             int end) {
  Leaf* leaf = &tree->leaf[coveringNode(begin)];
  if (s->slotBegin[walk->link] == begin) {
    keepStem(tree, s, walk);
  }
  for (int slot = begin; slot < end; slot++) {
    if (walk->link < s->slotLink[slot]) {
      walkToNext(walk, s, &localFrames->m[0][walk->link + 1 - localFrames->first], TREE_WIDTH);
      keepStem(tree, s, walk);
    }
    if (s->slotParticle[slot] != CT_NULL) {
      double x[3];
      placeParticle(s, &walk->frame, walk->link, slot, leaf, x);
    }
  }
}

/* Takes a walk from a leaf's last link to the frame of the next leaf, whose first link has a known local frame. */
CT_INLINE void walkToLeaf(Walk* walk, const Sequence* s, const LocalFrames* localFrames, int leaf) {
  const int link = s->slotLink[leaf * TREE_WIDTH];
  const SideBranchPart part = s->sideBranchPart[link];
  if (part != notInSideBranch && (part != beginsSideBranch || walk->link == link)) {
    walk->frame = walk->stem[0];
  } else if (walk->link < link) {
    walkLeave(walk, s);
    if (part == notInSideBranch) {
      walkEnter(walk, s, link, &localFrames->m[0][link - localFrames->first], TREE_WIDTH);
    }
  }
}

/* Recomputes the bound of a leaf. */
void CT_WIDE(refreshLeafBound)(Tree* tree, int leaf) {
  tree->bound[leaf] = boundOfLeaf(&tree->leaf[leaf]);
}

/* The frame of a link in the frame of a leaf that holds it. Opens all links there up to `end`. */
CT_INLINE Frame walkToLink(const Sequence* sequence, int link, int leaf, int end, LocalFrames* localFrames) {
  Walk walk;
  treeWalk(&walk, sequence, leaf);
  computeLocalFrames(sequence, walk.link + 1, end, localFrames);
  while (walk.link < link) {
    walkToNext(&walk, sequence, &localFrames->m[0][walk.link + 1 - localFrames->first], TREE_WIDTH);
  }
  return frameOfColumns(&walk.frame);
}

Frame CT_WIDE(linkInLeaf)(const Sequence* sequence, int link, int leaf) {
  LocalFrames localFrames;
  return walkToLink(sequence, link, leaf, link + 1, &localFrames);
}

/* One past the last link that a walk through a leaf opens, which is the first of the next leaf. */
static int endOfLocalFrames(const Sequence* sequence, int leaf) {
  const int next = (leaf + 1) * TREE_WIDTH;
  return sequence->slotLink[next < sequence->slotCount ? next : sequence->slotCount - 1] + 1;
}

/* The frame of a link in the frame of its leaf, and the local frames of all links there. */
Frame CT_WIDE(linkAndLocalFrames)(const Sequence* sequence, int link, LocalFrames* localFrames) {
  const int leaf = coveringNode(sequence->slotBegin[link]);
  return walkToLink(sequence, link, leaf, endOfLocalFrames(sequence, leaf), localFrames);
}

/* Recomputes a leaf, and its shortcut. */
void CT_WIDE(refreshLeaf)(Tree* tree, const Sequence* sequence, int leaf) {
  int begin = leaf * TREE_WIDTH;
  const int end = begin + TREE_WIDTH < tree->slotCount ? begin + TREE_WIDTH : tree->slotCount;
  const int endOfLinks = endOfLocalFrames(sequence, leaf);
  Walk walk;
  LocalFrames own;
  LocalFrames* localFrames = &own;
  if (tree->knownLink != CT_NULL && coveringNode(sequence->slotBegin[tree->knownLink]) == leaf) {
    localFrames = &tree->knownLocalFrames;
    walkBegin(&walk, tree->knownLink);
    columnsOf(&tree->knownInLeaf, &walk.frame);
    begin = sequence->slotBegin[tree->knownLink];
    if (tree->knownChange < endOfLinks) {
      computeLocalFrame(sequence, tree->knownChange, localFrames);
    }
  } else {
    treeWalk(&walk, sequence, leaf);
    computeLocalFrames(sequence, walk.link + 1, endOfLinks, localFrames);
  }
  positionSlots(tree, sequence, &walk, localFrames, begin, end);
  if (end < tree->slotCount) {
    walkToLeaf(&walk, sequence, localFrames, leaf + 1);
  }
  const Frame shortcut = frameOfColumns(&walk.frame);
  /* Compares bits: 0 and -0 differ. NOLINTNEXTLINE(bugprone-suspicious-memory-comparison) */
  if (memcmp(tree->shortcut[leaf].m, shortcut.m, sizeof shortcut.m) != 0) {
    tree->shortcut[leaf] = shortcut;
    tree->shortcutRevision[leaf] = tree->changes.now;
  }
  CT_WIDE(refreshLeafBound)(tree, leaf);
  noteLeaf(tree, leaf);
}

/* Widens the bound of a leaf so that it holds these of its slots, with the room of boundOfMembers. */
static void widenBound(Tree* tree, int leaf, int begin, int end) {
  const Leaf* own = &tree->leaf[leaf];
  Bound* bound = &tree->bound[leaf];
  const double centre[3] = {bound->x, bound->y, bound->z};
  for (int k = memberIndex(begin); k < memberIndex(begin) + end - begin; k++) {
    if (own->r[k] >= 0) {
      const double x[3] = {own->x[k], own->y[k], own->z[k]};
      const float away = (float)sqrt(squaredDistance(x, centre));
      const float rounding =
          1e-6f * (fabsf(bound->x) + fabsf(bound->y) + fabsf(bound->z) + away + own->r[k]) + FLOAT_FLOOR;
      bound->r = fmaxf(bound->r, away + own->r[k] + rounding);
      bound->centres = fmaxf(bound->centres, away + rounding);
    }
  }
}

/* True if a bound holds a particle at x, or the particle is not modelled. */
CT_INLINE bool holdsParticle(const Bound* bound, const double x[3], float radius) {
  const double centre[3] = {bound->x, bound->y, bound->z};
  const double away = squaredDistance(x, centre);
  const double room = (double)bound->r - (double)radius;
  const double centres = bound->centres;
  return (radius < 0) | ((room >= 0) & (away <= room * room) & (away <= centres * centres));
}

/* Computes the positions of slots that a link in a side branch moves, up to `end`, in the leaf where the link begins:
 * first the frames of all links, then the slots, since loops within loops are mispredicted. `stem` as in
 * sideBranchParent. True if the leaf's bound holds them. */
static bool positionSideBranch(Tree* tree, const Sequence* s, int link, const Frame* stem, int end) {
  Columns frames[TREE_WIDTH + 1]; /* of the parent, then of links from this one on */
  const int begin = s->slotBegin[link];
  const int last = s->slotLink[end - 1];
  Leaf* leaf = &tree->leaf[coveringNode(begin)];
  const Bound bound = tree->bound[coveringNode(begin)];
  sideBranchParent(s, link, stem, &frames[0]);
  for (int l = link; l <= last; l++) {
    const Frame localFrame = sequenceLocalFrame(s, l);
    Columns frame = frames[l == link ? 0 : s->parent[l] - link + 1];
    columnsCompose(&frame, localFrame.m[0], 1);
    frames[l - link + 1] = frame;
  }
  bool holds = true;
  for (int slot = begin; slot < end; slot++) {
    if (s->slotParticle[slot] != CT_NULL) {
      const int own = s->slotLink[slot];
      double x[3];
      placeParticle(s, &frames[own - link + 1], own, slot, leaf, x);
      holds &= holdsParticle(&bound, x, leaf->r[memberIndex(slot)]);
    }
  }
  return holds;
}

/* The same for all slots of a leaf that a link moves which begins in an earlier leaf. */
static bool positionRest(Tree* tree, const Sequence* s, const Frame* stem, int begin, int end) {
  const Leaf* leaf = &tree->leaf[coveringNode(begin)];
  Walk walk;
  walkBeginInSideBranch(&walk, s, s->slotLink[begin], stem);
  LocalFrames localFrames;
  computeLocalFrames(s, walk.link + 1, s->slotLink[end - 1] + 1, &localFrames);
  positionSlots(tree, s, &walk, &localFrames, begin, end);
  bool holds = true;
  for (int slot = begin; slot < end; slot++) {
    double x[3];
    treeLocal(tree, slot, x);
    holds &= holdsParticle(&tree->bound[coveringNode(begin)], x, leaf->r[memberIndex(slot)]);
  }
  return holds;
}

/* Recomputes the slots of one leaf that a link in a side branch moves. The leaf's bound is only widened: false if that
 * was necessary. */
bool CT_WIDE(refreshSideBranch)(Tree* tree, const Sequence* sequence, int link, int leaf) {
  const int slotBegin = sequence->slotBegin[link];
  const int slotEnd = sequence->slotBegin[sequenceEnd(sequence, link)];
  const int begin = slotBegin > leaf * TREE_WIDTH ? slotBegin : leaf * TREE_WIDTH;
  const int end = slotEnd < (leaf + 1) * TREE_WIDTH ? slotEnd : (leaf + 1) * TREE_WIDTH;
  const int head = sideBranchHead(sequence, link);
  const bool beginsHere = sequence->slotBegin[head] >= leaf * TREE_WIDTH;
  const Frame stem = beginsHere ? tree->stem[sequenceOpenPath(sequence, head)] : transformIdentity();
  const bool holds = begin == slotBegin ? positionSideBranch(tree, sequence, link, &stem, end)
                                        : positionRest(tree, sequence, &stem, begin, end);
  noteLeaf(tree, leaf);
  if (!holds) {
    widenBound(tree, leaf, begin, end);
  }
  return holds;
}

/* Recomputes the position of one slot from the frame of its link in its leaf. The leaf's bound is only widened: false
 * if that was necessary. */
bool CT_WIDE(refreshSlot)(Tree* tree, const Sequence* sequence, int slot, const Frame* inLeaf) {
  Leaf* leaf = &tree->leaf[coveringNode(slot)];
  Columns frame;
  double x[3];
  columnsOf(inLeaf, &frame);
  placeParticle(sequence, &frame, sequence->slotLink[slot], slot, leaf, x);
  const bool holds = holdsParticle(&tree->bound[coveringNode(slot)], x, leaf->r[memberIndex(slot)]);
  if (!holds) {
    widenBound(tree, coveringNode(slot), slot, slot + 1);
  }
  return holds;
}

/* Makes the sphere of a child that of its parent's member. */
CT_INLINE void placeMember(Tree* tree, const Columns* pose, int child, int k, Members* members) {
  const Bound* own = &tree->bound[child];
  double centre[3] = {own->x, own->y, own->z};
  columnsPoint(pose, centre, centre);
  members->block.x[k] = (float)centre[0];
  members->block.y[k] = (float)centre[1];
  members->block.z[k] = (float)centre[2];
  members->block.r[k] = own->r;
  members->centres[k] = own->centres;
}

/* Recomputes the members of the nodes over a leaf whose bound has been widened, and widens their bounds, as far up as
 * something sticks out. A little more, for roundings. */
void CT_WIDE(widenAbove)(Tree* tree, int leaf) {
  int child = leaf;
  for (int level = 0; level < treeTop(tree); level++) {
    const int node = treeParent(tree, level, child);
    const int k = memberIndex(child - tree->levelBegin[level]);
    Members* members = treeMembers(tree, node);
    Bound* bound = &tree->bound[node];
    Columns pose;
    columnsOf(&tree->pose[child], &pose);
    placeMember(tree, &pose, child, k, members);
    tree->contentRevision[node] = tree->changes.now;
    const float x = members->block.x[k] - bound->x;
    const float y = members->block.y[k] - bound->y;
    const float z = members->block.z[k] - bound->z;
    const float away = sqrtf(x * x + y * y + z * z);
    const float rounding = 1e-6f * (fabsf(bound->x) + fabsf(bound->y) + fabsf(bound->z) + away + members->block.r[k]);
    const float r = away + members->block.r[k] + rounding + FLOAT_FLOOR;
    const float centres = away + members->centres[k] + rounding + FLOAT_FLOOR;
    if (r <= bound->r && centres <= bound->centres) {
      return;
    }
    bound->r = fmaxf(bound->r, r);
    bound->centres = fmaxf(bound->centres, centres);
    child = node;
  }
}

/* Recomputes an inner node of which these children (ascending) have changed. Children after one whose shortcut has
 * changed have another pose, too. */
void CT_WIDE(refreshInnerNode)(Tree* tree, int level, int node, const int* changed, int count) {
  int childCount;
  const int first = treeChildren(tree, level, node, &childCount);
  const int last = first + childCount - 1;
  Members* members = treeMembers(tree, node);
  Columns pose;
  bool moved = false;
  int done = 0; /* how many of the changed ones are done, as long as none has moved the others */
  for (int child = changed[0]; child <= last;) {
    if (moved) {
      columnsCompose(&pose, tree->shortcut[child - 1].m[0], 1);
      tree->pose[child] = frameOfColumns(&pose);
    } else {
      columnsOf(&tree->pose[child], &pose);
    }
    placeMember(tree, &pose, child, child - first, members);
    moved = moved || tree->shortcutRevision[child] == tree->changes.now;
    child = moved ? child + 1 : ++done < count ? changed[done] : last + 1;
  }
  if (moved) {
    columnsCompose(&pose, tree->shortcut[last].m[0], 1);
    tree->shortcut[node] = frameOfColumns(&pose);
    tree->shortcutRevision[node] = tree->changes.now;
  }
  tree->bound[node] = boundOfMembers(&members->block, members->centres);
  tree->contentRevision[node] = tree->changes.now;
  tree->hasSum[node] = false;
}
