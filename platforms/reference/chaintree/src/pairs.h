/* Pairs of ids and distances of pairs, several at a time, on one of the paths of simd.h. */
#ifndef CT_PAIRS_H_
#define CT_PAIRS_H_

#include <stddef.h>

#include "simd.h"

/* loadIds16: sixteen ids. pairs16: the pairs of `id` with those of them whose bit is set, the lower first; returns how
 * many, and may write what is not wanted up to the sixteenth. */
#if defined(CT_PATH_AVX512)

typedef __m512i Ids16;

static inline Ids16 loadIds16(const int* p) {
  return _mm512_loadu_si512(p);
}

static inline int pairs16(unsigned mask, Ids16 ids, int id, int (*pairs)[2]) {
  const __m512i others = _mm512_maskz_compress_epi32((__mmask16)mask, ids);
  const __m512i own = _mm512_set1_epi32(id);
  const __m512i low = _mm512_min_epi32(others, own);
  const __m512i high = _mm512_max_epi32(others, own);
  const __m512i first = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const __m512i second = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  _mm512_storeu_si512(pairs[0], _mm512_permutex2var_epi32(low, first, high));
  _mm512_storeu_si512(pairs[8], _mm512_permutex2var_epi32(low, second, high));
  return __builtin_popcount(mask);
}

#else

typedef const int* Ids16;

static inline Ids16 loadIds16(const int* p) {
  return p;
}

static inline int pairs16(unsigned mask, Ids16 ids, int id, int (*pairs)[2]) {
  const int count = __builtin_popcount(mask);
  /* Eight at once, wanted or not: how many there are is hard to foresee. */
  for (int i = 0; i < count; i += 8) {
    for (int k = i; k < i + 8; k++) {
      const int other = ids[__builtin_ctz(mask | 0x8000u)];
      pairs[k][0] = other < id ? other : id;
      pairs[k][1] = other < id ? id : other;
      mask &= mask - 1;
    }
  }
  return count;
}

#endif

/* The distances of four pairs of points, none above `most`. Reads one number beyond the last point. */
#if defined(CT_PATH_AVX512) || defined(CT_PATH_AVX2)

static inline void distances4(const double* points, const int (*pairs)[2], double most, double* distances) {
  __m256d squares[4];
  for (int i = 0; i < 4; i++) {
    const __m256d a = _mm256_loadu_pd(points + 3 * (size_t)pairs[i][0]);
    const __m256d b = _mm256_loadu_pd(points + 3 * (size_t)pairs[i][1]);
    const __m256d apart = _mm256_sub_pd(a, b);
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

static inline void distances4(const double* points, const int (*pairs)[2], double most, double* distances) {
  for (int i = 0; i < 4; i++) {
    const double* a = points + 3 * (size_t)pairs[i][0];
    const double* b = points + 3 * (size_t)pairs[i][1];
    const double x = a[0] - b[0];
    const double y = a[1] - b[1];
    const double z = a[2] - b[2];
    const double distance = sqrt(x * x + y * y + z * z);
    distances[i] = distance < most ? distance : most;
  }
}

#endif

#endif /* CT_PAIRS_H_ */
