/* Pairs of ids and distances of pairs, several at a time, on one of the paths of simd.h. */
#ifndef CT_PAIRS_H_
#define CT_PAIRS_H_

#include <stddef.h>

#include "simd.h"

/* loadIds16: sixteen ids. pairs16: the pairs of `id` with those of them whose bit is set; returns how many, and may
 * write what is not wanted up to the sixteenth. */
#if defined(CT_PATH_AVX512)

typedef __m512i Ids16;

static inline Ids16 loadIds16(const int* p) {
  return _mm512_loadu_si512(p);
}

static inline int pairs16(unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  const __m512i others = _mm512_maskz_compress_epi32((__mmask16)mask, ids);
  const __m512i own = _mm512_set1_epi32(id);
  _mm512_storeu_si512(lower, _mm512_min_epi32(others, own));
  _mm512_storeu_si512(higher, _mm512_max_epi32(others, own));
  return __builtin_popcount(mask);
}

#else

typedef const int* Ids16;

static inline Ids16 loadIds16(const int* p) {
  return p;
}

static inline int pairs16(unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  const int count = __builtin_popcount(mask);
  /* Eight at once, wanted or not: how many there are is hard to foresee. */
  for (int i = 0; i < count; i += 8) {
    for (int k = i; k < i + 8; k++) {
      const int other = ids[__builtin_ctz(mask | 0x8000u)];
      lower[k] = other < id ? other : id;
      higher[k] = other < id ? id : other;
      mask &= mask - 1;
    }
  }
  return count;
}

#endif

/* The distances of four pairs of points, none above `most`. Reads one number beyond the last point. */
#if defined(CT_PATH_AVX512) || defined(CT_PATH_AVX2)

static inline void distances4(const double* points, const int* a, const int* b, double most, double* distances) {
  __m256d squares[4];
  for (int i = 0; i < 4; i++) {
    const __m256d apart =
        _mm256_sub_pd(_mm256_loadu_pd(points + 3 * (size_t)a[i]), _mm256_loadu_pd(points + 3 * (size_t)b[i]));
    squares[i] = _mm256_mul_pd(apart, apart);
  }
  const __m256d xz01 = _mm256_unpacklo_pd(squares[0], squares[1]);
  const __m256d y01 = _mm256_unpackhi_pd(squares[0], squares[1]);
  const __m256d xz23 = _mm256_unpacklo_pd(squares[2], squares[3]);
  const __m256d y23 = _mm256_unpackhi_pd(squares[2], squares[3]);
  const __m256d x = _mm256_permute2f128_pd(xz01, xz23, 0x20);
  const __m256d y = _mm256_permute2f128_pd(y01, y23, 0x20);
  const __m256d z = _mm256_permute2f128_pd(xz01, xz23, 0x31);
  const __m256d squared = _mm256_add_pd(_mm256_add_pd(x, y), z);
  _mm256_storeu_pd(distances, _mm256_min_pd(_mm256_sqrt_pd(squared), _mm256_set1_pd(most)));
}

#else

static inline void distances4(const double* points, const int* a, const int* b, double most, double* distances) {
  for (int i = 0; i < 4; i++) {
    const double* p = points + 3 * (size_t)a[i];
    const double* q = points + 3 * (size_t)b[i];
    const double x = p[0] - q[0];
    const double y = p[1] - q[1];
    const double z = p[2] - q[2];
    const double distance = sqrt(x * x + y * y + z * z);
    distances[i] = distance < most ? distance : most;
  }
}

#endif

#endif /* CT_PAIRS_H_ */
