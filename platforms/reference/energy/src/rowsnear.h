/* Which particles of a leaf may be near those of another. */
#ifndef CT_ROWSNEAR_H_
#define CT_ROWSNEAR_H_

#include "leafpair.h"
#include "simd.h"

/* Slots of leaf a that may be within a cutoff of some particle of leaf b, as bits; b's box is shifted. */
CT_INLINE unsigned rowsNear(float squaredCutoff, const LeafFrame* a, const LeafFrame* b, const float shift[3]) {
  const float* axes[3] = {a->x, a->y, a->z};
  Float16 squared = all16(0);
  for (int d = 0; d < 3; d++) {
    const Float16 x = load16(axes[d]);
    const Float16 below = sub16(all16(b->low[d] + shift[d]), x);
    const Float16 above = sub16(x, all16(b->high[d] + shift[d]));
    const Float16 apart = max16(max16(below, above), all16(0));
    squared = add16(squared, mul16(apart, apart));
  }
  /* Rounding must not lose a row. */
  return ~greater16(squared, all16(squaredCutoff * 1.0001f));
}

#endif /* CT_ROWSNEAR_H_ */
