/* Positions of leaves in the world and boxes around them, compiled once for each instruction set by the file that
 * includes this. */
#ifndef CT_LEAVES_BODY_H_
#define CT_LEAVES_BODY_H_

#include "instructions.h"
#include "leaves.h"
#include "simd.h"
#include "volume.h"

/* A coordinate of some particles, from worldOrigin. */
typedef struct LeafPoints {
  float x[3][TREE_WIDTH];
} LeafPoints;

/* What the roundings to float may take from a box of particles: half a unit in the last place. */
#define BOX_MARGIN 1.2e-7f

/* Writes the box around lows and highs as member k, a little larger. */
CT_INLINE void storeBox(const Float16 lows[3], const Float16 highs[3], float margin, LeafBoxes* around, int k) {
  const Float16 zero = all16(0);
  const Float16 first[4] = {lows[0], lows[1], lows[2], sub16(zero, highs[0])};
  const Float16 last[4] = {sub16(zero, highs[1]), sub16(zero, highs[2]), zero, zero};
  float least[8];
  least4x16(first, least);
  least4x16(last, least + 4);
  for (int d = 0; d < 3; d++) {
    around->low[d][k] = least[d] - margin * fabsf(least[d]);
    around->high[d][k] = margin * fabsf(least[3 + d]) - least[3 + d];
  }
}

/* Writes the box around the points of a leaf as member k of its parent. */
CT_INLINE void boxPoints(const LeafPoints* points, unsigned occupied, LeafBoxes* around, int k) {
  Float16 lows[3];
  Float16 highs[3];
  for (int d = 0; d < 3; d++) {
    const Float16 x = load16(points->x[d]);
    lows[d] = occupied == 0xffff ? x : blend16(occupied, all16(INFINITY), x);
    highs[d] = occupied == 0xffff ? x : blend16(occupied, all16(-INFINITY), x);
  }
  storeBox(lows, highs, BOX_MARGIN, around, k);
}

/* Writes the box around the members of a node as member k of its parent. */
static void boxMembers(const LeafBoxes* members, LeafBoxes* around, int k) {
  Float16 lows[3];
  Float16 highs[3];
  for (int d = 0; d < 3; d++) {
    lows[d] = load16(members->low[d]);
    highs[d] = load16(members->high[d]);
  }
  storeBox(lows, highs, 0, around, k);
}

/* Sets the positions of slots that hold no particle to 0. */
static void clearEmpty(ctLeafPositions* leaf, unsigned occupied) {
  for (unsigned empty = ~occupied & 0xffff; empty != 0; empty &= empty - 1) {
    const int k = __builtin_ctz(empty);
    leaf->x[k] = 0;
    leaf->y[k] = 0;
    leaf->z[k] = 0;
  }
}

/* ---- The state ---- */

/* Computes the positions of a leaf, by the sums that ctGetPositions makes. */
static void placeLeaf(Leaves* leaves, const Tree* tree, const Sequence* s, int leaf, const Frame* frame,
                      LeafPoints* points) {
  const Leaf* restrict own = &tree->leaf[leaf];
  ctLeafPositions* restrict to = &leaves->state[leaf];
  const Frame f = *frame;
  const double* o = s->worldOrigin;
  double x[3][TREE_WIDTH];
  for (int k = 0; k < TREE_WIDTH; k++) {
    for (int d = 0; d < 3; d++) {
      x[d][k] = f.m[d][0] * own->x[k] + f.m[d][1] * own->y[k] + f.m[d][2] * own->z[k] + f.m[d][3];
    }
  }
  for (int d = 0; d < 3; d++) {
    for (int k = 0; k < TREE_WIDTH; k++) {
      points->x[d][k] = (float)x[d][k];
    }
  }
  for (int k = 0; k < TREE_WIDTH; k++) {
    to->x[k] = x[0][k] + o[0];
    to->y[k] = x[1][k] + o[1];
    to->z[k] = x[2][k] + o[2];
  }
  clearEmpty(to, leaves->occupied[leaf]);
}

/* True if all slots of a node are at rest. */
static bool isAtRest(const LeafUpdate* u, int level, int node) {
  int end;
  const int begin = treeSlots(u->tree, level, node, &end);
  for (int p = u->pieceCount - 1; p >= 0; p--) {
    if (u->pieces[p].slotBegin < end) {
      if (u->pieces[p].body != 0) {
        return false;
      }
      end = u->pieces[p].slotBegin;
    }
    if (end <= begin) {
      break;
    }
  }
  return true;
}

/* True if a node has not changed or moved since positions were computed. */
static bool nodeStays(const LeafUpdate* u, int level, int node) {
  if (u->pieceCount > 0) {
    return isAtRest(u, level, node);
  }
  const int leafEnd = (node - u->tree->levelBegin[level] + 1) << TREE_WIDTH_BITS * level;
  return u->tree->contentTime[node] <= u->leaves->time && leafEnd <= u->firstMoved;
}

/* Brings the leaves below a node up to date, and its own box, which is member k of its parent. */
static void updateNode(const LeafUpdate* u, int level, int node, const Frame* frame) {
  Leaves* leaves = u->leaves;
  const Tree* tree = u->tree;
  const bool isBoxed = leaves->boxes != NULL && leaves->occupied[node] != 0;
  LeafBoxes* around = isBoxed ? leafBoxes(leaves, tree, treeParent(tree, level, node)) : NULL;
  const int k = memberIndex(node - tree->levelBegin[level]);
  if (level == 0) {
    LeafPoints points;
    placeLeaf(leaves, tree, u->sequence, node, frame, &points);
    if (around != NULL) {
      boxPoints(&points, leaves->occupied[node], around, k);
      leaves->differs[treeParent(tree, 0, node) - tree->levelBegin[1]] |= (uint16_t)(1u << k);
    }
    return;
  }
  int count;
  const int first = treeChildren(tree, level, node, &count);
  for (int child = first; child < first + count; child++) {
    if (!nodeStays(u, level - 1, child)) {
      const Frame inWorld = transformCompose(frame, &tree->pose[child]);
      updateNode(u, level - 1, child, &inWorld);
    }
  }
  if (around != NULL) {
    boxMembers(leafBoxes(leaves, tree, node), around, k);
  }
}

static void updateLeaves(const LeafUpdate* u) {
  const int root = treeRoot(u->tree);
  updateNode(u, treeTop(u->tree), root, &u->tree->pose[root]);
}

#endif /* CT_LEAVES_BODY_H_ */
