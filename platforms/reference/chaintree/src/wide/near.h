/* Filters of sweeps: which nodes and slots of a snapshot are near others. */
#ifndef CT_NEAR_H_
#define CT_NEAR_H_

#include <float.h>

#include "../volume.h"
#include "axisboxes.h"
#include "ids.h"
#include "set.h"

/* Functions that are compiled twice, for clashes and for neighbours: `surfaces` is a constant in each use. */
#define CT_FOR_BOTH CT_INLINE

/* ---- Filters ---- */

typedef struct Pass {
  Sweep* sweep;
  SweepTask* task;
  float reach;       /* with FLOAT_MARGIN */
  float nearSquared; /* its square: centres farther apart are no pair */
  float sureSquared; /* centres nearer than its root are a pair for sure */
} Pass;

/* The members (bits) whose boxes are within reach of box k of others. */
CT_FOR_BOTH unsigned membersNear(const Pass* pass, const SnapshotBoxes* members, const SnapshotBoxes* others, int k,
                                 bool surfaces) {
  const Float16 squared = squaredGaps(&others->centres, k, &members->centres);
  if (!surfaces) {
    return greater16(all16(pass->nearSquared), squared);
  }
  const Float16 sum = max16(add16(load16(members->r), all16(others->r[k] + pass->reach)), all16(0));
  return greater16(mul16(sum, sum), squared);
}

/* The slots of a leaf, in registers. */
typedef struct Slots {
  Float16 x[3];
  Float16 r;
} Slots;

CT_INLINE Slots slotsOf(const Block* leaf) {
  return (Slots){{load16(leaf->x), load16(leaf->y), load16(leaf->z)}, load16(leaf->r)};
}

/* A box along the world's axes. */
typedef struct AxisBox {
  float low[3];
  float high[3];
  float r; /* as in SnapshotBoxes */
} AxisBox;

static inline AxisBox memberOf(const SnapshotBoxes* boxes, int k) {
  const AxisBoxes* centres = &boxes->centres;
  return (AxisBox){{centres->low[0][k], centres->low[1][k], centres->low[2][k]},
                   {centres->high[0][k], centres->high[1][k], centres->high[2][k]},
                   boxes->r[k]};
}

/* The slots (bits) that are within reach of a box. */
CT_FOR_BOTH unsigned slotsNear(const Pass* pass, const Slots* slots, const AxisBox* box, bool surfaces) {
  const Float16 squared = squaredGapsOfPoints(slots->x, box->low, box->high);
  if (!surfaces) {
    return greater16(all16(pass->nearSquared), squared);
  }
  const Float16 sum = max16(add16(slots->r, all16(box->r + pass->reach)), all16(0));
  return greater16(mul16(sum, sum), squared);
}

static inline int sizeOfLeaf(const Tree* layout, int leaf) {
  int end;
  const int begin = treeSlots(layout, 0, leaf, &end);
  return end - begin;
}

static inline double squaredApart(const Pass* pass, int slotA, int slotB) {
  const Snapshot* snapshot = &pass->sweep->snapshot;
  const int* particle = pass->sweep->sequence->slotParticle;
  return squaredDistance(snapshotPosition(snapshot, particle[slotA]), snapshotPosition(snapshot, particle[slotB]));
}

/* Begins a sweep. Floats are positions from the snapshot's origin, rounded once, and extremes of these, which are
 * exact: of the 67 u of FLOAT_MARGIN (see there) a sweep needs the 2 u of positions and the 12 u of the test. */
static inline Pass startPass(Sweep* sweep, SweepTask* task) {
  const double margin = floatMargin(sweep->snapshot.coordinateBound + fabs(task->reach));
  const float near = (float)(task->reach + margin);
  const float sure = (float)larger(task->reach - margin, 0);
  /* Empty slots are at infinity, out of reach of the widest cutoff. */
  return (Pass){sweep, task, near, near * near < FLT_MAX ? near * near : FLT_MAX, sure * sure};
}

#endif /* CT_NEAR_H_ */
