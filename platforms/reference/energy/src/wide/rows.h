/* Rows: particles of one leaf, each with all particles of another. */
#ifndef CT_ROWS_H_
#define CT_ROWS_H_

#include "../leafpair.h"
#include "simd.h"

/* Rows that are summed in single precision before they are added in double. */
enum { ROWS_IN_FLOAT = 4 };

/* From the centre of leaf a to that of leaf b. */
static inline void shiftBetween(const LeafFrame* a, const LeafFrame* b, float shift[3]) {
  for (int d = 0; d < 3; d++) {
    shift[d] = (float)(b->centre[d] - a->centre[d]);
  }
}

/* Squared distances of the particles of leaf a from the box of leaf b, which is shifted. */
CT_INLINE Float16 squaredFromBox(const LeafFrame* a, const LeafFrame* b, const float shift[3]) {
  const float* axes[3] = {a->x, a->y, a->z};
  Float16 squared = all16(0);
  for (int d = 0; d < 3; d++) {
    const Float16 x = load16(axes[d]);
    const Float16 below = sub16(all16(b->low[d] + shift[d]), x);
    const Float16 above = sub16(x, all16(b->high[d] + shift[d]));
    const Float16 apart = max16(max16(below, above), all16(0));
    squared = add16(squared, mul16(apart, apart));
  }
  return squared;
}

/* Slots of leaf a that may be within this squared distance of some particle of leaf b, as bits; b's box is shifted. */
CT_INLINE unsigned rowsNear(const LeafFrame* a, const LeafFrame* b, const float shift[3], float squaredReach) {
  return ~greater16(squaredFromBox(a, b, shift), all16(squaredReach * ROUNDING_OF_BOXES));
}

#endif /* CT_ROWS_H_ */
