/* Writing pairs of ids, and distances of pairs, several at a time, by one of the instruction sets of simd.h. */
#ifndef CT_IDS_H_
#define CT_IDS_H_

#include <stddef.h>

#include "../ranks.h"
#include "simd.h"

/* Sixteen ids. closeRanks16 writes those whose bit is set, without gaps; closeNumbers16 writes first + k for each bit
 * k. pairs16 writes the pairs of `id` with those ids, the lower of each to `lower`; pairsBelow16 does so if all are
 * below it. All return how many they have written, and may overwrite sixteen entries. */
#if defined(CT_PATH_AVX512)

typedef __m512i Ids16;

static inline Ids16 loadIds(const int* ids) {
  return _mm512_loadu_si512(ids);
}

CT_INLINE size_t closeRanks16(const Ranks* ranks, unsigned mask, Ids16 ids, int* to) {
  (void)ranks;
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)mask, ids));
  return (size_t)__builtin_popcount(mask);
}

CT_INLINE size_t closeNumbers16(const Ranks* ranks, unsigned mask, int first, int* to) {
  (void)ranks;
  return (size_t)indices16(mask, first, to);
}

CT_INLINE size_t pairsBelow16(const Ranks* ranks, unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  _mm512_storeu_si512(higher, _mm512_set1_epi32(id));
  return closeRanks16(ranks, mask, ids, lower);
}

CT_INLINE size_t pairs16(const Ranks* ranks, unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  const __m512i all = _mm512_set1_epi32(id);
  closeRanks16(ranks, mask, _mm512_max_epi32(ids, all), higher);
  return closeRanks16(ranks, mask, _mm512_min_epi32(ids, all), lower);
}

#elif defined(CT_PATH_AVX2)

typedef struct Ids16 {
  __m256i low;
  __m256i high;
} Ids16;

static inline Ids16 loadIds(const int* ids) {
  return (Ids16){_mm256_loadu_si256((const __m256i*)ids), _mm256_loadu_si256((const __m256i*)(ids + 8))};
}

static inline __m256i bits8(const Ranks* ranks, unsigned byte) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)ranks->bit[byte]));
}

/* Writes two times eight ids that have no gaps. */
CT_INLINE size_t storeClosed(unsigned mask, __m256i low, __m256i high, int* to) {
  _mm256_storeu_si256((__m256i*)to, low);
  _mm256_storeu_si256((__m256i*)(to + __builtin_popcount(mask & 255)), high);
  return (size_t)__builtin_popcount(mask);
}

CT_INLINE size_t closeRanks16(const Ranks* ranks, unsigned mask, Ids16 ids, int* to) {
  const __m256i low = _mm256_permutevar8x32_epi32(ids.low, bits8(ranks, mask & 255));
  const __m256i high = _mm256_permutevar8x32_epi32(ids.high, bits8(ranks, mask >> 8));
  return storeClosed(mask, low, high, to);
}

CT_INLINE size_t closeNumbers16(const Ranks* ranks, unsigned mask, int first, int* to) {
  const __m256i low = _mm256_add_epi32(bits8(ranks, mask & 255), _mm256_set1_epi32(first));
  const __m256i high = _mm256_add_epi32(bits8(ranks, mask >> 8), _mm256_set1_epi32(first + 8));
  return storeClosed(mask, low, high, to);
}

CT_INLINE size_t pairsBelow16(const Ranks* ranks, unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  const __m256i all = _mm256_set1_epi32(id);
  _mm256_storeu_si256((__m256i*)higher, all);
  _mm256_storeu_si256((__m256i*)(higher + 8), all);
  return closeRanks16(ranks, mask, ids, lower);
}

CT_INLINE size_t pairs16(const Ranks* ranks, unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  const __m256i all = _mm256_set1_epi32(id);
  closeRanks16(ranks, mask, (Ids16){_mm256_max_epi32(ids.low, all), _mm256_max_epi32(ids.high, all)}, higher);
  return closeRanks16(ranks, mask, (Ids16){_mm256_min_epi32(ids.low, all), _mm256_min_epi32(ids.high, all)}, lower);
}

#else

typedef const int* Ids16;

static inline Ids16 loadIds(const int* ids) {
  return ids;
}

/* Where the second eight of sixteen are written. */
static inline int* behindFirst8(const Ranks* ranks, unsigned mask, int* to) {
  return to + ranks->count[mask & 255];
}

static inline size_t bitCount16(const Ranks* ranks, unsigned mask) {
  return (size_t)ranks->count[mask & 255] + ranks->count[mask >> 8];
}

static inline size_t closeRanks16(const Ranks* ranks, unsigned mask, Ids16 ids, int* to) {
  int* next = behindFirst8(ranks, mask, to);
  for (int k = 0; k < 8; k++) {
    to[k] = ids[ranks->bit[mask & 255][k]];
  }
  for (int k = 0; k < 8; k++) {
    next[k] = ids[8 + ranks->bit[mask >> 8][k]];
  }
  return bitCount16(ranks, mask);
}

static inline size_t closeNumbers16(const Ranks* ranks, unsigned mask, int first, int* to) {
  int* next = behindFirst8(ranks, mask, to);
  for (int k = 0; k < 8; k++) {
    to[k] = first + ranks->bit[mask & 255][k];
  }
  for (int k = 0; k < 8; k++) {
    next[k] = first + 8 + ranks->bit[mask >> 8][k];
  }
  return bitCount16(ranks, mask);
}

static inline size_t pairsBelow16(const Ranks* ranks, unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  for (int k = 0; k < 16; k++) {
    higher[k] = id;
  }
  return closeRanks16(ranks, mask, ids, lower);
}

static inline size_t pairs16(const Ranks* ranks, unsigned mask, Ids16 ids, int id, int* lower, int* higher) {
  const size_t count = closeRanks16(ranks, mask, ids, lower);
  for (int k = 0; k < 16; k++) {
    const int other = lower[k];
    lower[k] = other < id ? other : id;
    higher[k] = other < id ? id : other;
  }
  return count;
}

#endif

/* The distances of four pairs of points, none above `most`. May read one number beyond the last point. */
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

#endif /* CT_IDS_H_ */
