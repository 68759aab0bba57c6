/* Spheres against spheres, sixteen at a time, in float: a filter that may let a pair through and never loses one. */
#ifndef CT_VOLUME_H_
#define CT_VOLUME_H_

#include <math.h>

#include "tree.h"

/* Rounding to float, once on each side, and of the test itself, relative to the largest coordinate and reach. */
#define FLOAT_MARGIN 2e-6

/* What two positions of one particle reached by different products of transforms differ by at most, relative to the
 * largest coordinate: some hundred roundings of 1e-16. Nearer than that to a limit the canonical distance decides. */
#define DOUBLE_MARGIN 4e-13

/* Bit k is set if sphere k is nearer than r[k] + reach to (x, y, z). A radius of -INFINITY is never near. */
static inline unsigned near16(const float* xs, const float* ys, const float* zs, const float* rs, float x, float y,
                              float z, float reach) {
  float inside[TREE_WIDTH];
  for (int k = 0; k < TREE_WIDTH; k++) {
    const float dx = xs[k] - x;
    const float dy = ys[k] - y;
    const float dz = zs[k] - z;
    const float sum = rs[k] + reach;
    inside[k] = sum * fabsf(sum) - (dx * dx + dy * dy + dz * dz);
  }
  unsigned mask = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    mask |= (unsigned)(inside[k] > 0) << k;
  }
  return mask;
}

#endif /* CT_VOLUME_H_ */
