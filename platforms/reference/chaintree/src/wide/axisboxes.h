/* Boxes along the world's axes around points and boxes, and gaps between boxes. */
#ifndef CT_AXISBOXES_H_
#define CT_AXISBOXES_H_

#include "../volume.h"
#include "set.h"
#include "simd.h"

/* Coordinates of the slots of a leaf, from worldOrigin. */
typedef struct LeafPoints {
  float x[3][TREE_WIDTH];
} LeafPoints;

/* Room for the rounding to float in a box of particles: half a unit in the last place. */
#define BOX_MARGIN 1.2e-7f

/* Writes the box around lows and highs as member k. */
CT_INLINE void storeBox(const Float16 lows[3], const Float16 highs[3], AxisBoxes* around, int k) {
  /* Four at a time; the most of a number is the least of its opposite. */
  const Float16 zero = all16(0);
  const Float16 first[4] = {lows[0], lows[1], lows[2], sub16(zero, highs[0])};
  const Float16 last[4] = {sub16(zero, highs[1]), sub16(zero, highs[2]), zero, zero};
  float least[8];
  least4x16(first, least);
  least4x16(last, least + 4);
  for (int d = 0; d < 3; d++) {
    around->low[d][k] = least[d];
    around->high[d][k] = -least[3 + d];
  }
}

/* Writes the box around the occupied slots (bits) of a leaf as member k of its parent. */
CT_INLINE void boxPoints(const float* const axes[3], unsigned occupied, AxisBoxes* around, int k) {
  Float16 lows[3];
  Float16 highs[3];
  for (int d = 0; d < 3; d++) {
    const Float16 x = load16(axes[d]);
    lows[d] = occupied == 0xffff ? x : blend16(occupied, all16(INFINITY), x);
    highs[d] = occupied == 0xffff ? x : blend16(occupied, all16(-INFINITY), x);
  }
  storeBox(lows, highs, around, k);
}

/* The same, a little larger. */
CT_INLINE void boxPointsLoosely(const LeafPoints* points, unsigned occupied, AxisBoxes* around, int k) {
  const float* const axes[3] = {points->x[0], points->x[1], points->x[2]};
  boxPoints(axes, occupied, around, k);
  for (int d = 0; d < 3; d++) {
    around->low[d][k] -= BOX_MARGIN * fabsf(around->low[d][k]);
    around->high[d][k] += BOX_MARGIN * fabsf(around->high[d][k]);
  }
}

/* Writes the box around the members of a node as member k of its parent. */
static inline void boxMembers(const AxisBoxes* members, AxisBoxes* around, int k) {
  Float16 lows[3];
  Float16 highs[3];
  for (int d = 0; d < 3; d++) {
    lows[d] = load16(members->low[d]);
    highs[d] = load16(members->high[d]);
  }
  storeBox(lows, highs, around, k);
}

/* Sets the positions of slots that hold no particle to 0. */
static inline void clearEmpty(ctLeafPositions* leaf, unsigned occupied) {
  for (unsigned empty = ~occupied & 0xffff; empty != 0; empty &= empty - 1) {
    const int k = __builtin_ctz(empty);
    leaf->x[k] = 0;
    leaf->y[k] = 0;
    leaf->z[k] = 0;
  }
}

/* Squared gaps between a box and sixteen others. */
CT_INLINE Float16 squaredGaps(const AxisBoxes* row, int k, const AxisBoxes* others) {
  Float16 gap[3];
  for (int d = 0; d < 3; d++) {
    const Float16 below = sub16(load16(others->low[d]), all16(row->high[d][k]));
    const Float16 above = sub16(all16(row->low[d][k]), load16(others->high[d]));
    gap[d] = max16(max16(below, above), all16(0));
  }
  return squared16(gap[0], gap[1], gap[2]);
}

/* Squared gaps of sixteen points from a box. */
CT_INLINE Float16 squaredGapsOfPoints(const Float16 x[3], const float low[3], const float high[3]) {
  Float16 gap[3];
  for (int d = 0; d < 3; d++) {
    gap[d] = sub16(x[d], min16(max16(x[d], all16(low[d])), all16(high[d])));
  }
  return squared16(gap[0], gap[1], gap[2]);
}

#endif /* CT_AXISBOXES_H_ */
