/* Where all slots are in the world, as of one state: for queries that look at every pair. A snapshot is filled from
 * scratch, and straight from the positions where the state is the reference, so that new positions need no tree. */
#ifndef CT_SNAPSHOT_H_
#define CT_SNAPSHOT_H_

#include "arena.h"
#include "tree.h"

/* Boxes along the world's axes around what lies below each child of a node. */
typedef struct AxisBoxes {
  float low[3][TREE_WIDTH]; /* of centres of particles; above high: there are none */
  float high[3][TREE_WIDTH];
  float r[TREE_WIDTH]; /* no particle has a larger radius; -INFINITY: there are none */
} AxisBoxes;

typedef struct Snapshot {
  Block* leaf;            /* per leaf: floats from `origin`, INFINITY where a slot is empty; and radii */
  AxisBoxes* boxes;       /* per node of a higher level, from levelBegin[1] on */
  const double* position; /* per particle that has a slot, where it is exactly: the reference, or `moved` */
  double origin[3];
  double extent; /* no coordinate from `origin` or radius is larger */
  double band;   /* distances this close to a limit are left to the canonical one */
  double* moved; /* positions that are not the reference, if such have been asked for */
} Snapshot;

/* Makes a snapshot of nothing but radii; false if there is no memory. */
bool ctSnapshotBuild(Snapshot* snapshot, Arena* arena, const Sequence* sequence, const Tree* layout);

/* Makes room for positions that are not the reference; false, and nothing changed, if there is no memory. */
bool ctSnapshotReserve(Snapshot* snapshot, Arena* arena, const Sequence* sequence);

/* Takes the positions of the reference, or of a fresh tree. Floats and boxes are stale then. */
void ctSnapshotTakeReference(Snapshot* snapshot, const Sequence* sequence);
void ctSnapshotTakeTree(Snapshot* snapshot, const Sequence* sequence, const Tree* tree);

/* Boxes of the children of a node. */
static inline AxisBoxes* snapshotBoxes(const Snapshot* snapshot, const Tree* layout, int node) {
  return &snapshot->boxes[node - layout->levelBegin[1]];
}

static inline const double* snapshotPosition(const Snapshot* snapshot, int particle) {
  return snapshot->position + 3 * (size_t)particle;
}

#endif /* CT_SNAPSHOT_H_ */
