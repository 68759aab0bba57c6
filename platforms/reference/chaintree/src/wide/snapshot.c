/* Floats and boxes of snapshots. */
#include "../volume.h"
#include "ids.h"
#include "set.h"

/* Rounds the positions of a leaf's particles to float. Empty slots are at infinity. */
static void fillLeaf(const Snapshot* snapshot, const int* particle, Block* leaf) {
  const unsigned empty = greater16(all16(0), load16(leaf->r));
  float* axes[3] = {leaf->x, leaf->y, leaf->z};
  for (int k = 0; k < TREE_WIDTH; k += 4) {
    const double* points[4];
    for (int l = 0; l < 4; l++) {
      points[l] = snapshotPosition(snapshot, (empty >> (k + l) & 1) != 0 ? 0 : particle[k + l]);
    }
    floats4(points, snapshot->origin, leaf->x + k, leaf->y + k, leaf->z + k);
  }
  for (int d = 0; d < 3 && empty != 0; d++) {
    store16(axes[d], blend16(empty, load16(axes[d]), all16(INFINITY)));
  }
}

static void boundLeaf(const Block* leaf, SnapshotBoxes* around, int k) {
  const unsigned empty = greater16(all16(0), load16(leaf->r));
  const float* axes[3] = {leaf->x, leaf->y, leaf->z};
  for (int d = 0; d < 3; d++) {
    around->centres.low[d][k] = least16(load16(axes[d]));
    around->centres.high[d][k] = most16(blend16(empty, load16(axes[d]), all16(-INFINITY)));
  }
  around->r[k] = most16(load16(leaf->r));
}

static void boundInnerNode(const SnapshotBoxes* members, SnapshotBoxes* around, int k) {
  for (int d = 0; d < 3; d++) {
    around->centres.low[d][k] = least16(load16(members->centres.low[d]));
    around->centres.high[d][k] = most16(load16(members->centres.high[d]));
  }
  around->r[k] = most16(load16(members->r));
}

/* A length that no coordinate or radius of member k exceeds. */
static double coordinateBoundOf(const SnapshotBoxes* around, int k) {
  double corner[3] = {0, 0, 0};
  for (int d = 0; d < 3 && around->r[k] >= 0; d++) {
    corner[d] = larger(fabs((double)around->centres.low[d][k]), fabs((double)around->centres.high[d][k]));
  }
  return sqrt(dot(corner, corner)) + larger((double)around->r[k], 0);
}

void CT_WIDE(boundSnapshot)(Snapshot* snapshot, const Sequence* sequence, const Tree* layout) {
  SnapshotBoxes root; /* the root is member 0 of this */
  for (int level = 0; level < layout->levelCount; level++) {
    for (int i = 0; i < layout->levelSize[level]; i++) {
      const int node = layout->levelBegin[level] + i;
      const bool isRoot = level == treeTop(layout);
      SnapshotBoxes* around = isRoot ? &root : snapshotBoxes(snapshot, layout, treeParent(layout, level, node));
      if (level == 0) {
        Block* leaf = &snapshot->leaf[node];
        fillLeaf(snapshot, sequence->slotParticle + node * TREE_WIDTH, leaf);
        boundLeaf(leaf, around, memberIndex(i));
      } else {
        boundInnerNode(snapshotBoxes(snapshot, layout, node), around, memberIndex(i));
      }
    }
  }
  snapshot->coordinateBound = coordinateBoundOf(&root, 0);
  snapshot->tieBand = DOUBLE_MARGIN * snapshot->coordinateBound;
}
