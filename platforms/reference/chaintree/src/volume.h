/* Spheres against spheres, sixteen at a time, in float: a filter that may let a pair through and never loses one. */
#ifndef CT_VOLUME_H_
#define CT_VOLUME_H_

#include <math.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "tree.h"

/* Rounding to float, once on each side, and of the test itself, relative to the largest coordinate and reach. */
#define FLOAT_MARGIN 2e-6

/* What two positions of one particle reached by different products of transforms differ by at most, relative to the
 * largest coordinate: some hundred roundings of 1e-16. Nearer than that to a limit the canonical distance decides. */
#define DOUBLE_MARGIN 4e-13

/* Spheres in structure-of-arrays, in runs of TREE_WIDTH. */
typedef struct Spheres {
  float* x;
  float* y;
  float* z;
  float* r;    /* -INFINITY: none, never near anything */
  int* motion; /* which rigid body each belongs to, or STRADDLES */
} Spheres;

enum { STRADDLES = -1 };

/* Bit k is set if sphere first + k is nearer than its radius + reach to (x, y, z). Both paths round alike, lane by
 * lane. */
#ifdef __SSE2__
static inline unsigned near16(const Spheres* spheres, int first, float x, float y, float z, float reach) {
  const float* xs = spheres->x + first;
  const float* ys = spheres->y + first;
  const float* zs = spheres->z + first;
  const float* rs = spheres->r + first;
  const __m128 x4 = _mm_set1_ps(x);
  const __m128 y4 = _mm_set1_ps(y);
  const __m128 z4 = _mm_set1_ps(z);
  const __m128 reach4 = _mm_set1_ps(reach);
  const __m128 zero = _mm_setzero_ps();
  unsigned mask = 0;
  for (unsigned k = 0; k < TREE_WIDTH; k += 4) {
    const __m128 dx = _mm_sub_ps(_mm_loadu_ps(xs + k), x4);
    const __m128 dy = _mm_sub_ps(_mm_loadu_ps(ys + k), y4);
    const __m128 dz = _mm_sub_ps(_mm_loadu_ps(zs + k), z4);
    const __m128 sum = _mm_add_ps(_mm_loadu_ps(rs + k), reach4);
    const __m128 squared = _mm_add_ps(_mm_add_ps(_mm_mul_ps(dx, dx), _mm_mul_ps(dy, dy)), _mm_mul_ps(dz, dz));
    const __m128 near = _mm_and_ps(_mm_cmpgt_ps(sum, zero), _mm_cmpgt_ps(_mm_mul_ps(sum, sum), squared));
    mask |= (unsigned)_mm_movemask_ps(near) << k;
  }
  return mask;
}
#else
static inline unsigned near16(const Spheres* spheres, int first, float x, float y, float z, float reach) {
  const float* xs = spheres->x + first;
  const float* ys = spheres->y + first;
  const float* zs = spheres->z + first;
  const float* rs = spheres->r + first;
  unsigned mask = 0;
  for (unsigned k = 0; k < TREE_WIDTH; k++) {
    const float dx = xs[k] - x;
    const float dy = ys[k] - y;
    const float dz = zs[k] - z;
    const float sum = rs[k] + reach;
    mask |= (unsigned)(sum > 0 && sum * sum > dx * dx + dy * dy + dz * dz) << k;
  }
  return mask;
}
#endif

/* Bit k is set if sphere first + k is of this rigid body. */
static inline unsigned sameBody16(const Spheres* spheres, int first, int motion) {
  unsigned mask = 0;
  for (int k = 0; k < TREE_WIDTH; k++) {
    mask |= (unsigned)(spheres->motion[first + k] == motion) << k;
  }
  return mask;
}

#endif /* CT_VOLUME_H_ */
