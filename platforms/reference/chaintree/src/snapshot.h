/* The positions of all slots in the world, of one state, for queries that look at every pair. A snapshot is filled from
 * scratch. If the state is the reference, it is filled from the reference positions, so that new positions need no
 * tree. */
#ifndef CT_SNAPSHOT_H_
#define CT_SNAPSHOT_H_

#include "arena.h"
#include "axisbox.h"
#include "world.h"

/* Boxes of centres around the members of a node. */
typedef struct SnapshotBoxes {
  AxisBoxes centres;
  float r[TREE_WIDTH]; /* no particle has a larger radius; -INFINITY: no particles */
} SnapshotBoxes;

typedef struct Snapshot {
  Revision builtFrom;
  Block* leaf;            /* per leaf: positions from `origin`, INFINITY where no particle is modelled; and radii */
  SnapshotBoxes* boxes;   /* per inner node, from levelBegin[1] on */
  const double* position; /* per particle that has a slot, in double: the reference, or `moved` */
  double origin[3];
  double coordinateBound; /* no coordinate from `origin` or radius is larger */
  double tieBand;         /* the canonical distance decides about distances this close to a limit */
  double* moved;          /* positions that are not the reference; NULL: not needed yet */
} Snapshot;

/* Makes a snapshot with radii but without positions; false if there is no memory. */
bool ctSnapshotBuild(Snapshot* snapshot, Arena* arena, const Sequence* sequence, const Tree* layout);

/* Makes room for positions that are not the reference; false, and nothing changed, if there is no memory. */
bool ctSnapshotReserve(Snapshot* snapshot, Arena* arena, const Sequence* sequence);

/* Takes the positions of the reference, or of an up-to-date tree. Floats and boxes are outdated until ctSweepBound. */
void ctSnapshotTakeReference(Snapshot* snapshot, const Sequence* sequence);
void ctSnapshotTakeTree(Snapshot* snapshot, const Sequence* sequence, World* world);

/* The boxes of the children of an inner node. */
static inline SnapshotBoxes* snapshotBoxes(const Snapshot* snapshot, const Tree* layout, int node) {
  return &snapshot->boxes[node - layout->levelBegin[1]];
}

static inline const double* snapshotPosition(const Snapshot* snapshot, int particle) {
  return snapshot->position + 3 * (size_t)particle;
}

#endif /* CT_SNAPSHOT_H_ */
