/* Pairs of ids and distances of pairs, several at a time, on one of the paths of simd.h. */
#ifndef CT_PAIRS_H_
#define CT_PAIRS_H_

#include <stddef.h>

#include "ranks.h"
#include "simd.h"

/* closeRanks8: writes those of eight ids whose bit is set. pairs8: the pairs of `id` with them. All return how many,
 * and write something up to the eighth place. */
#if defined(CT_PATH_AVX512) || defined(CT_PATH_AVX2)

static inline __m256i bits8(const Ranks* ranks, unsigned byte) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)ranks->bit[byte]));
}

static inline __m256i closed8(const Ranks* ranks, unsigned mask, const int* ids) {
  return _mm256_permutevar8x32_epi32(_mm256_loadu_si256((const __m256i*)ids), bits8(ranks, mask));
}

static inline size_t closeRanks8(const Ranks* ranks, unsigned mask, const int* ids, int* to) {
  _mm256_storeu_si256((__m256i*)to, closed8(ranks, mask, ids));
  return (size_t)__builtin_popcount(mask);
}

static inline size_t pairs8(const Ranks* ranks, unsigned mask, int id, const int* others, int* lower, int* higher) {
  const __m256i chosen = closed8(ranks, mask, others);
  const __m256i own = _mm256_set1_epi32(id);
  _mm256_storeu_si256((__m256i*)lower, _mm256_min_epi32(chosen, own));
  _mm256_storeu_si256((__m256i*)higher, _mm256_max_epi32(chosen, own));
  return (size_t)__builtin_popcount(mask);
}

#else

static inline size_t closeRanks8(const Ranks* ranks, unsigned mask, const int* ids, int* to) {
  for (int k = 0; k < 8; k++) {
    to[k] = ids[ranks->bit[mask][k]];
  }
  return ranks->count[mask];
}

static inline size_t pairs8(const Ranks* ranks, unsigned mask, int id, const int* others, int* lower, int* higher) {
  for (int k = 0; k < 8; k++) {
    const int other = others[ranks->bit[mask][k]];
    lower[k] = other < id ? other : id;
    higher[k] = other < id ? id : other;
  }
  return ranks->count[mask];
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
