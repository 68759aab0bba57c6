/* Sums of floats as whole multiples of 2^-30: they have the same bits whatever the order, on each instruction set
 * of simd.h. */
#ifndef CT_EXACTSUMS_H_
#define CT_EXACTSUMS_H_

#include <string.h>

#include "simd.h"

/* What no summand may reach, so that 2^12 of them are within 64 bits. */
#define EXACT_LIMIT 0x1p20f

/* Added to a number, it brings the number's multiple of 2^-30 to the end of the bits. */
#define EXACT_SHIFT 0x1.8p22

/* What a sum of so many begins with: without the bits of EXACT_SHIFT that each of them brings along. It may wrap. */
static inline int64_t exactBegin(int count) {
  const double shift = EXACT_SHIFT;
  uint64_t bits;
  memcpy(&bits, &shift, sizeof bits);
  return (int64_t)(0 - (uint64_t)count * bits);
}

/* Sixteen sums. */
#if defined(CT_PATH_AVX512)

typedef struct Exact16 {
  __m512i low;
  __m512i high;
} Exact16;

/* For so many summands in each lane. */
static inline Exact16 beginExact16(int count) {
  const __m512i begin = _mm512_set1_epi64(exactBegin(count));
  return (Exact16){begin, begin};
}

static inline Exact16 addToExact16(Exact16 sum, Float16 a) {
  const __m512d shift = _mm512_set1_pd(EXACT_SHIFT);
  const __m256 high = _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(a), 1));
  const __m512d ofLow = _mm512_add_pd(_mm512_cvtps_pd(_mm512_castps512_ps256(a)), shift);
  const __m512d ofHigh = _mm512_add_pd(_mm512_cvtps_pd(high), shift);
  return (Exact16){_mm512_add_epi64(sum.low, _mm512_castpd_si512(ofLow)),
                   _mm512_add_epi64(sum.high, _mm512_castpd_si512(ofHigh))};
}

/* The sums of the lanes of each of four masks. */
static inline void sumsOfExact16(Exact16 sum, const uint16_t masks[4], int64_t sums[4]) {
  __m512i eight[4];
  for (int i = 0; i < 4; i++) {
    const unsigned mask = masks[i];
    eight[i] = _mm512_add_epi64(_mm512_maskz_mov_epi64((__mmask8)mask, sum.low),
                                _mm512_maskz_mov_epi64((__mmask8)(mask >> 8), sum.high));
  }
  const __m512i ab =
      _mm512_add_epi64(_mm512_unpacklo_epi64(eight[0], eight[1]), _mm512_unpackhi_epi64(eight[0], eight[1]));
  const __m512i cd =
      _mm512_add_epi64(_mm512_unpacklo_epi64(eight[2], eight[3]), _mm512_unpackhi_epi64(eight[2], eight[3]));
  const __m256i ab4 = _mm256_add_epi64(_mm512_castsi512_si256(ab), _mm512_extracti64x4_epi64(ab, 1));
  const __m256i cd4 = _mm256_add_epi64(_mm512_castsi512_si256(cd), _mm512_extracti64x4_epi64(cd, 1));
  const __m256i all =
      _mm256_add_epi64(_mm256_permute2x128_si256(ab4, cd4, 0x20), _mm256_permute2x128_si256(ab4, cd4, 0x31));
  _mm256_storeu_si256((__m256i*)sums, all);
}

static inline int64_t totalOfExact16(Exact16 sum) {
  return _mm512_reduce_add_epi64(_mm512_add_epi64(sum.low, sum.high));
}

/* The lanes of which a mask has a bit, from consecutive floats; the others are 0. Sixteen floats are read. */
static inline Float16 unpack16(unsigned mask, const float* packed) {
  return _mm512_maskz_expand_ps((__mmask16)mask, _mm512_loadu_ps(packed));
}

#elif defined(CT_PATH_AVX2)

typedef struct Exact16 {
  __m256i quarter[4];
} Exact16;

static inline Exact16 beginExact16(int count) {
  const __m256i begin = _mm256_set1_epi64x(exactBegin(count));
  return (Exact16){{begin, begin, begin, begin}};
}

static inline Exact16 addToExact16(Exact16 sum, Float16 a) {
  const __m256d shift = _mm256_set1_pd(EXACT_SHIFT);
  const __m128 quarter[4] = {_mm256_castps256_ps128(a.low), _mm256_extractf128_ps(a.low, 1),
                             _mm256_castps256_ps128(a.high), _mm256_extractf128_ps(a.high, 1)};
  for (int i = 0; i < 4; i++) {
    const __m256d shifted = _mm256_add_pd(_mm256_cvtps_pd(quarter[i]), shift);
    sum.quarter[i] = _mm256_add_epi64(sum.quarter[i], _mm256_castpd_si256(shifted));
  }
  return sum;
}

/* The sums of lanes that are two apart. */
static inline __m128i halved(__m256i a) {
  return _mm_add_epi64(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
}

static inline void sumsOfExact16(Exact16 sum, const uint16_t masks[4], int64_t sums[4]) {
  const __m256i bits = _mm256_setr_epi64x(1, 2, 4, 8);
  for (int i = 0; i < 4; i++) {
    __m256i four = _mm256_setzero_si256();
    for (int q = 0; q < 4; q++) {
      const __m256i mask = _mm256_and_si256(_mm256_set1_epi64x(masks[i] >> 4 * q), bits);
      four = _mm256_add_epi64(four, _mm256_and_si256(_mm256_cmpeq_epi64(mask, bits), sum.quarter[q]));
    }
    const __m128i two = halved(four);
    sums[i] = _mm_cvtsi128_si64(_mm_add_epi64(two, _mm_unpackhi_epi64(two, two)));
  }
}

static inline int64_t totalOfExact16(Exact16 sum) {
  const __m256i low = _mm256_add_epi64(sum.quarter[0], sum.quarter[1]);
  const __m128i two = halved(_mm256_add_epi64(low, _mm256_add_epi64(sum.quarter[2], sum.quarter[3])));
  return _mm_cvtsi128_si64(_mm_add_epi64(two, _mm_unpackhi_epi64(two, two)));
}

/* How many of the bits below each of a byte are set, four bits each from the lowest on. */
#define CT_RANKS(byte)                                                                                   \
  (((byte)&1) * 0x11111110u + ((byte) >> 1 & 1) * 0x11111100u + ((byte) >> 2 & 1) * 0x11111000u +        \
   ((byte) >> 3 & 1) * 0x11110000u + ((byte) >> 4 & 1) * 0x11100000u + ((byte) >> 5 & 1) * 0x11000000u + \
   ((byte) >> 6 & 1) * 0x10000000u)
#define CT_RANKS_4(byte) CT_RANKS(byte), CT_RANKS(byte + 1u), CT_RANKS(byte + 2u), CT_RANKS(byte + 3u)
#define CT_RANKS_16(byte) CT_RANKS_4(byte), CT_RANKS_4(byte + 4u), CT_RANKS_4(byte + 8u), CT_RANKS_4(byte + 12u)
#define CT_RANKS_64(byte) CT_RANKS_16(byte), CT_RANKS_16(byte + 16u), CT_RANKS_16(byte + 32u), CT_RANKS_16(byte + 48u)

static inline __m256 unpack8(unsigned mask, const float* packed) {
  static const uint32_t ranksOfBits[256] = {CT_RANKS_64(0u), CT_RANKS_64(64u), CT_RANKS_64(128u), CT_RANKS_64(192u)};
  const __m256i shifts = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28);
  const __m256i ranks = _mm256_srlv_epi32(_mm256_set1_epi32((int)ranksOfBits[mask]), shifts);
  return _mm256_and_ps(lanes8(mask), _mm256_permutevar8x32_ps(_mm256_loadu_ps(packed), ranks));
}

static inline Float16 unpack16(unsigned mask, const float* packed) {
  const float* rest = packed + __builtin_popcount(mask & 255);
  return (Float16){unpack8(mask & 255, packed), unpack8(mask >> 8 & 255, rest)};
}

#else

typedef struct Exact16 {
  uint64_t lanes[16];
} Exact16;

static inline Exact16 beginExact16(int count) {
  Exact16 sum;
  for (int k = 0; k < 16; k++) {
    sum.lanes[k] = (uint64_t)exactBegin(count);
  }
  return sum;
}

static inline Exact16 addToExact16(Exact16 sum, Float16 a) {
  float lanes[16];
  store16(lanes, a);
  for (int k = 0; k < 16; k++) {
    const double shifted = (double)lanes[k] + EXACT_SHIFT;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    sum.lanes[k] += bits;
  }
  return sum;
}

static inline void sumsOfExact16(Exact16 sum, const uint16_t masks[4], int64_t sums[4]) {
  for (int i = 0; i < 4; i++) {
    uint64_t total = 0;
    for (unsigned mask = masks[i]; mask != 0; mask &= mask - 1) {
      total += sum.lanes[__builtin_ctz(mask)];
    }
    sums[i] = (int64_t)total;
  }
}

static inline int64_t totalOfExact16(Exact16 sum) {
  uint64_t total = 0;
  for (int k = 0; k < 16; k++) {
    total += sum.lanes[k];
  }
  return (int64_t)total;
}

static inline Float16 unpack16(unsigned mask, const float* packed) {
  float lanes[16];
  /* Without branches, which would be mispredicted. */
  for (int k = 0; k < 16; k++) {
    const float value = *packed;
    lanes[k] = (mask >> k & 1) != 0 ? value : 0;
    packed += mask >> k & 1;
  }
  return load16(lanes);
}

#endif

#endif /* CT_EXACTSUMS_H_ */
