/* Floats and boxes of snapshots. */
#include "axisboxes.h"
#include "ids.h"

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

/* Writes the box around a leaf as member k of its parent. */
static void boxSnapshotLeaf(const Block* leaf, SnapshotBoxes* around, int k) {
  const float* const axes[3] = {leaf->x, leaf->y, leaf->z};
  boxPoints(axes, ~greater16(all16(0), load16(leaf->r)) & 0xffff, &around->centres, k);
  around->r[k] = most16(load16(leaf->r));
}

/* The same of an inner node. */
static void boxSnapshotNode(const SnapshotBoxes* members, SnapshotBoxes* around, int k) {
  boxMembers(&members->centres, &around->centres, k);
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
        boxSnapshotLeaf(leaf, around, memberIndex(i));
      } else {
        boxSnapshotNode(snapshotBoxes(snapshot, layout, node), around, memberIndex(i));
      }
    }
  }
  snapshot->coordinateBound = coordinateBoundOf(&root, 0);
  snapshot->tieBand = DOUBLE_MARGIN * snapshot->coordinateBound;
}
