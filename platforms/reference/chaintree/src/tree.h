/* The tree over the sequence. A node is a leaf (level 0), which covers TREE_WIDTH slots, or an inner node, which covers
 * TREE_WIDTH nodes of the level below. All leaves are at one level.
 *
 * Node i of a level covers nodes TREE_WIDTH * i ... of the level below. The nodes of all levels share one numbering, so
 * that the children of a node are neighbours in every array. The members of a node are the slots of a leaf, or the
 * children of an inner node.
 *
 * The frame of a node is the frame of the link of its first slot. If that link is in a side branch, it is the frame of
 * the link on which the side branch hangs: so it does not move with the side branch. For each node the tree keeps the
 * shortcut across it, its pose in the parent's frame (a product of its siblings' shortcuts), and a bounding sphere; for
 * each slot the position in the leaf's frame. Each is a pure function of the sequence's state and of the nodes below.
 */
#ifndef CT_TREE_H_
#define CT_TREE_H_

#include "changes.h"
#include "costs.h"
#include "images.h"
#include "order.h"
#include "sequence.h"

enum { TREE_MAX_LEVELS = 8 };

/* The spheres of a node's members, in its own frame, in the world or in a view. r < 0: no member. */
typedef struct Block {
  float x[TREE_WIDTH];
  float y[TREE_WIDTH];
  float z[TREE_WIDTH];
  float r[TREE_WIDTH]; /* of spheres around all particles with their radii; -INFINITY: no particles */
} Block;

/* The children of an inner node. */
typedef struct Members {
  Block block;
  float centres[TREE_WIDTH]; /* radii of spheres around the centres of all particles; -INFINITY: no particles */
} Members;

/* The slots of a leaf, in its frame. */
typedef struct Leaf {
  double x[TREE_WIDTH];
  double y[TREE_WIDTH];
  double z[TREE_WIDTH];
  float r[TREE_WIDTH]; /* of the particle; -INFINITY: none, or one that is not modelled */
} Leaf;

/* A sphere around the members of a node in its own frame; radii as in Members. */
typedef struct Bound {
  float x;
  float y;
  float z;
  float r;
  float centres;
} Bound;

/* The local frames of consecutive links, as a structure of arrays: by entries of Frame.m. */
typedef struct LocalFrames {
  int first; /* link */
  double m[12][TREE_WIDTH];
} LocalFrames;

/* Longest interval whose leaves are listed one by one. */
enum { MOST_LEAVES_LISTED = LISTED_LEAVES / 2 };

struct Wide;

typedef struct Tree {
  const struct Wide* wide;
  int levelCount;
  int levelBegin[TREE_MAX_LEVELS + 1]; /* first node of each level; a level is padded to a multiple of TREE_WIDTH */
  int levelSize[TREE_MAX_LEVELS];
  int nodeCount; /* with padding */
  int slotCount;

  Frame* shortcut;  /* per node: the frame of the next node of its level in its own frame; the last one's is unused */
  Frame* pose;      /* per node: its frame in its parent's frame */
  Leaf* leaf;       /* per node of level 0 */
  Members* members; /* per inner node, from levelBegin[1] on */
  Bound* bound;     /* per node */
  Frame* stem; /* per path without return frame, if a side branch begins with it: the frame of the link on which the
                  branch hangs, in the frame of the leaf where the branch begins */

  /* Sums of positions, made on first use. */
  double (*sum)[3]; /* per node: of the positions of all its particles, modelled or not, in its own frame */
  bool* hasSum;     /* per node; revisions would take eight times the memory */
  int* particles;   /* per node: how many particles; one without a slot counts where its link begins */

  /* During an update by one change: a link of no side branch whose frame in its leaf is known, and before which nothing
   * changes. CT_NULL: none. The walk through that leaf begins there. */
  int knownLink;
  int knownChange; /* the link that changes */
  Frame knownInLeaf;
  LocalFrames knownLocalFrames; /* of the links of that leaf, before the change */

  int* dirty; /* scratch: nodes of one level */

  /* A turn in a side branch only widens bounds that it sticks out of, until tight ones are needed: soon a leaf has a
   * bound that holds its side branches however they turn, and another turn changes no node but the leaf. */
  int looseCount; /* leaves with bounds that may be loose, as may be those of the nodes over them */
  int* loose;
  bool* isLoose; /* per leaf */

  /* When each part last changed. */
  Changes changes;
  Revision builtFrom;         /* the content is of this revision; the layout is always right */
  Revision* contentRevision;  /* per node: when its members were last recomputed */
  Revision* shortcutRevision; /* per node: when its shortcut last changed */
} Tree;

static inline int treeTop(const Tree* tree) {
  return tree->levelCount - 1;
}

static inline int treeRoot(const Tree* tree) {
  return tree->levelBegin[treeTop(tree)];
}

/* The parent of a node of a level below the top. */
static inline int treeParent(const Tree* tree, int level, int node) {
  return tree->levelBegin[level + 1] + coveringNode(node - tree->levelBegin[level]);
}

/* First child of a node of level > 0, and how many it has. */
static inline int treeChildren(const Tree* tree, int level, int node, int* count) {
  const int first = (node - tree->levelBegin[level]) * TREE_WIDTH;
  const int left = tree->levelSize[level - 1] - first;
  *count = left < TREE_WIDTH ? left : TREE_WIDTH;
  return tree->levelBegin[level - 1] + first;
}

/* First slot of a node, and one past its last. */
static inline int treeSlots(const Tree* tree, int level, int node, int* end) {
  const int64_t width = (int64_t)TREE_WIDTH << TREE_WIDTH_BITS * level;
  const int64_t begin = (node - tree->levelBegin[level]) * width;
  *end = (int)(begin + width < tree->slotCount ? begin + width : tree->slotCount);
  return (int)begin;
}

/* How many members a node has: children, or slots of a leaf. */
static inline int treeMemberCount(const Tree* tree, int level, int node) {
  const int all = level == 0 ? tree->slotCount : tree->levelSize[level - 1];
  const int left = all - (node - tree->levelBegin[level]) * TREE_WIDTH;
  return left < TREE_WIDTH ? left : TREE_WIDTH;
}

/* The members of an inner node. */
static inline Members* treeMembers(const Tree* tree, int node) {
  return &tree->members[node - tree->levelBegin[1]];
}

/* A slot's position in the frame of its leaf. */
static inline void treeLocal(const Tree* tree, int slot, double local[3]) {
  const Leaf* leaf = &tree->leaf[coveringNode(slot)];
  local[0] = leaf->x[memberIndex(slot)];
  local[1] = leaf->y[memberIndex(slot)];
  local[2] = leaf->z[memberIndex(slot)];
}

/* True if a node, or something below it, may have moved with a leaf before it since a revision. */
static inline bool nodeMovedSince(const Tree* tree, int level, int node, Revision since) {
  const int leafEnd = (node - tree->levelBegin[level] + 1) << TREE_WIDTH_BITS * level;
  return leavesMovedSince(&tree->changes, since, leafEnd);
}

/* Numbers the nodes of a zeroed tree over one slot or more. */
void ctTreeLayOut(Tree* layout, int slotCount);

/* Lays out a tree over a sequence of one slot or more, without content. False if there is no memory. */
bool ctTreeBuild(Tree* tree, Arena* arena, const Sequence* sequence, const struct Wide* wide);

/* Call when the sequence has a new state: no content is of it until it is refreshed. */
void ctTreeMakeOutdated(Tree* tree);

/* Recomputes everything from the sequence's state: O(N). */
void ctTreeRefresh(Tree* tree, const Sequence* sequence);

/* Makes loose bounds tight. */
void ctTreeTighten(Tree* tree);

/* Recomputes the nodes that depend on the joints of these links (ascending): leaves, then the nodes over them, level by
 * level, each once (section 3.1), or notes that their bounds are loose. Returns how many. */
int ctTreeUpdate(Tree* tree, const Sequence* sequence, const int* links, int count);

/* Recomputes what depends on the reference positions of these particles. `inLeaf`: the frames of their links in the
 * frames of their leaves. Bounds may be loose then. Returns how many nodes. */
int ctTreeDisplace(Tree* tree, const Sequence* sequence, const int* particles, const Frame* inLeaf, int count);

/* The frame of a node in the world. O(level count). */
Frame ctTreeFrame(const Tree* tree, int level, int node);

/* Notes that particles of a leaf have new positions in its frame. */
static inline void noteLeaf(Tree* tree, int leaf) {
  tree->contentRevision[leaf] = tree->changes.now;
  tree->hasSum[leaf] = false;
  listLeaf(&tree->changes, leaf);
}

/* Begins a walk at the first link of a leaf. Its frame is that of the leaf. */
CT_INLINE void treeWalk(Walk* walk, const Sequence* sequence, int leaf) {
  const int link = sequence->slotLink[leaf * TREE_WIDTH];
  if (sequence->sideBranchPart[link] == notInSideBranch) {
    walkBegin(walk, link);
  } else {
    const Frame stem = transformIdentity();
    walkBeginInSideBranch(walk, sequence, link, &stem);
  }
}

/* The frame of a link in the frame of the leaf where it begins, or of another that holds some of its slots. */
Frame ctTreeLinkInLeaf(const Tree* tree, const Sequence* sequence, int link);
Frame ctTreeLinkInThisLeaf(const Tree* tree, const Sequence* sequence, int link, int leaf);

/* The same of a link of no side branch, which is kept as knownLink for an update by one change. */
Frame ctTreeKnowLink(Tree* tree, const Sequence* sequence, int link, int change);

/* An axis is taken from the positions of its two particles if its squared length is more than this share of the squared
 * distance from the leaf's origin. Positions in a leaf are off by up to 16 products of transforms, some 4 v of that
 * distance (v = 2^-53). The direction of a line that is 32 times shorter is off by 128 v, 1/84 of DOUBLE_MARGIN. */
#define LEAST_LINE (1.0 / 1024)

/* A point of a link's torsion axis, and a vector along it, in the frame of the leaf where the link begins. For axes
 * whose particles are not both there, or so close together that the rounding of their positions would turn the line. */
void ctTreeWalkToAxis(const Tree* tree, const Sequence* sequence, int link, double point[3], double direction[3]);

/* The same for any torsion. Inlined, since every turn starts with it: its numbers stay in registers. */
CT_INLINE void treeAxis(const Tree* tree, const Sequence* sequence, int link, double point[3], double direction[3]) {
  const int leaf = coveringNode(sequence->slotBegin[link]);
  const int places = sequence->axisPlaces[link];
  double near[3];
  double far[3];
  treeLocal(tree, leaf * TREE_WIDTH + places / TREE_WIDTH, near);
  treeLocal(tree, leaf * TREE_WIDTH + places % TREE_WIDTH, far);
  subtract(far, near, direction);
  point[0] = far[0];
  point[1] = far[1];
  point[2] = far[2];
  if (places == axisElsewhere || !(dot(direction, direction) > LEAST_LINE * dot(point, point))) {
    double walked[2][3];
    ctTreeWalkToAxis(tree, sequence, link, walked[0], walked[1]);
    point[0] = walked[0][0];
    point[1] = walked[0][1];
    point[2] = walked[0][2];
    direction[0] = walked[1][0];
    direction[1] = walked[1][1];
    direction[2] = walked[1][2];
  }
}

/* The squared canonical distance of two slots: computed in the frame of the lowest node over both, so that it is a pure
 * function of the state. */
double ctTreeSquaredDistance(const Tree* tree, int slotA, int slotB);

/* The position of a slot in the world, from worldOrigin. */
void ctTreeSlotInWorld(const Tree* tree, int slot, double position[3]);

/* The same of an image of the first, computed in the world. */
double ctTreeSquaredImageDistance(const Tree* tree, int slotA, int slotB, const Image* image);

/* The frame of linkB in that of linkA, by way of the lowest node over both (section 2.1). O(log N). */
Frame ctTreeRelative(const Tree* tree, const Sequence* sequence, int linkA, int linkB);

/* Part of ctTreeBuild: counts the particles of all nodes. */
void ctTreeCountParticles(Tree* tree, const Sequence* sequence);

/* The sum of the positions of all particles of links [linkBegin, linkEnd) in the world, and how many they are. O(log
 * N). */
int ctTreeSum(Tree* tree, const Sequence* sequence, int linkBegin, int linkEnd, double sum[3]);

/* Computes all sums that are not known yet. */
void ctTreeCompleteSums(Tree* tree, const Sequence* sequence);

/* True if the bound of every node holds the particles below it. O(N log N). */
bool ctTreeBoundsHold(const Tree* tree, const Sequence* sequence);

#endif /* CT_TREE_H_ */
