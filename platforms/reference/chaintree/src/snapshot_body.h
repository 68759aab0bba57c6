/* Floats and bounds of snapshots, compiled once for each instruction set by the file that includes this. */
#include <string.h>

#include "instructions.h"
#include "volume.h"

/* Floats of an octet's particles, and the box around them. */
static void fillOctet(const Snapshot* snapshot, const int* particle, int size, float* x, Extent* box) {
  float low[3] = {INFINITY, INFINITY, INFINITY};
  float high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int k = 0; k < OCTET_WIDTH; k++) {
    const bool empty = k >= size || particle[k] == CT_NULL;
    const double* position = snapshotPosition(snapshot, empty ? 0 : particle[k]);
    for (int d = 0; d < 3; d++) {
      const float place = (float)(position[d] - snapshot->origin[d]);
      x[d * TREE_WIDTH + k] = empty ? INFINITY : place;
      low[d] = empty || low[d] < place ? low[d] : place;
      high[d] = empty || high[d] > place ? high[d] : place;
    }
  }
  memcpy(box->low, low, sizeof low);
  memcpy(box->high, high, sizeof high);
}

static void boundLeaf(const Extent* octets, Extents* around, int k) {
  for (int d = 0; d < 3; d++) {
    around->low[d][k] = octets[octets[1].low[d] < octets[0].low[d]].low[d];
    around->high[d][k] = octets[octets[1].high[d] > octets[0].high[d]].high[d];
  }
  around->r[k] = octets[octets[1].r > octets[0].r].r;
}

static void boundNode(const Extents* members, Extents* around, int k) {
  for (int d = 0; d < 3; d++) {
    around->low[d][k] = least16(load16(members->low[d]));
    around->high[d][k] = most16(load16(members->high[d]));
  }
  around->r[k] = most16(load16(members->r));
}

/* No coordinate or radius of member k is larger. */
static double extentOf(const Extents* around, int k) {
  double corner[3] = {0, 0, 0};
  for (int d = 0; d < 3 && around->r[k] >= 0; d++) {
    corner[d] = larger(fabs((double)around->low[d][k]), fabs((double)around->high[d][k]));
  }
  return sqrt(dot(corner, corner)) + larger((double)around->r[k], 0);
}

static void boundSnapshot(Snapshot* snapshot, const Sequence* sequence, const Tree* layout) {
  Extents root; /* the root is member 0 of this */
  for (int level = 0; level < layout->levelCount; level++) {
    for (int i = 0; i < layout->levelSize[level]; i++) {
      const int item = layout->levelBegin[level] + i;
      const bool isRoot = level == treeTop(layout);
      Extents* around = isRoot ? &root : snapshotExtents(snapshot, layout, treeParent(layout, level, item));
      if (level == 0) {
        Extent* octets = &snapshot->octet[OCTETS * item];
        for (int c = 0; c < OCTETS; c++) {
          const int slot = item * TREE_WIDTH + c * OCTET_WIDTH;
          fillOctet(snapshot, sequence->slotParticle + slot, layout->slotCount - slot,
                    snapshot->leaf[item].x + c * OCTET_WIDTH, &octets[c]);
        }
        boundLeaf(octets, around, i % TREE_WIDTH);
      } else {
        boundNode(snapshotExtents(snapshot, layout, item), around, i % TREE_WIDTH);
      }
    }
  }
  snapshot->extent = extentOf(&root, 0);
  snapshot->band = DOUBLE_MARGIN * snapshot->extent;
}
