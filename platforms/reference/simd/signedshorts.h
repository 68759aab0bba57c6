/* Sixteen signed shorts at a time against six limits: boxes against a box. */
#ifndef CT_SIGNED_SHORTS_H_
#define CT_SIGNED_SHORTS_H_

#include "simd.h"

/* Eight floats times a factor, plus a summand, as shorts: rounded towards 0, then shifted. What is beyond the range
 * ends at its end, before the shift and after it. */
static inline void storeSignedShorts8(int16_t* to, const float* from, float factor, float summand, int16_t shift) {
#ifdef __SSE2__
  __m128i rounded[2];
  for (int i = 0; i < 2; i++) {
    const __m128 product = _mm_mul_ps(_mm_loadu_ps(from + 4 * i), _mm_set1_ps(factor));
    const __m128 sum = _mm_add_ps(product, _mm_set1_ps(summand));
    rounded[i] = _mm_cvttps_epi32(_mm_min_ps(sum, _mm_set1_ps(1e9f))); /* far below it becomes the least int */
  }
  const __m128i shorts = _mm_packs_epi32(rounded[0], rounded[1]);
  _mm_storeu_si128((__m128i*)to, _mm_adds_epi16(shorts, _mm_set1_epi16(shift)));
#else
  for (int i = 0; i < 8; i++) {
    const float sum = from[i] * factor + summand;
    const int shifted = shift + (sum >= INT16_MAX ? INT16_MAX : sum > INT16_MIN ? (int)sum : INT16_MIN);
    to[i] = (int16_t)(shifted > INT16_MAX ? INT16_MAX : shifted < INT16_MIN ? INT16_MIN : shifted);
  }
#endif
}

/* Six limits. */
#if defined(CT_PATH_AVX512)

typedef struct SixLimits {
  __m512i two[3]; /* sixteen times one of them, then sixteen times the next */
} SixLimits;

static inline SixLimits sixLimits(const int16_t limits[6]) {
  SixLimits six;
  for (int i = 0; i < 3; i++) {
    const __m512i low = _mm512_castsi256_si512(_mm256_set1_epi16(limits[2 * i]));
    six.two[i] = _mm512_inserti64x4(low, _mm256_set1_epi16(limits[2 * i + 1]), 1);
  }
  return six;
}

/* Bit k: row[i][k] is below limit i, for all i. */
static inline unsigned belowSixLimits(const int16_t row[6][16], SixLimits six) {
  __mmask32 mask = 0xffffffff;
  for (int i = 0; i < 3; i++) {
    mask = _mm512_mask_cmplt_epi16_mask(mask, _mm512_loadu_si512(row[2 * i]), six.two[i]);
  }
  return mask & mask >> 16;
}

#elif defined(CT_PATH_AVX2)

typedef struct SixLimits {
  __m256i limit[6];
} SixLimits;

static inline SixLimits sixLimits(const int16_t limits[6]) {
  SixLimits six;
  for (int i = 0; i < 6; i++) {
    six.limit[i] = _mm256_set1_epi16(limits[i]);
  }
  return six;
}

static inline unsigned belowSixLimits(const int16_t row[6][16], SixLimits six) {
  __m256i all = _mm256_set1_epi16(-1);
  for (int i = 0; i < 6; i++) {
    all = _mm256_and_si256(all, _mm256_cmpgt_epi16(six.limit[i], _mm256_loadu_si256((const __m256i*)row[i])));
  }
  const __m128i bytes = _mm_packs_epi16(_mm256_castsi256_si128(all), _mm256_extracti128_si256(all, 1));
  return (unsigned)_mm_movemask_epi8(bytes);
}

#else

typedef struct SixLimits {
  int16_t limit[6];
} SixLimits;

static inline SixLimits sixLimits(const int16_t limits[6]) {
  SixLimits six;
  __builtin_memcpy(six.limit, limits, sizeof six.limit);
  return six;
}

static inline unsigned belowSixLimits(const int16_t row[6][16], SixLimits six) {
  unsigned mask = 0;
#ifdef __SSE2__
  __m128i all[2] = {_mm_set1_epi16(-1), _mm_set1_epi16(-1)};
  for (int i = 0; i < 6; i++) {
    for (int half = 0; half < 2; half++) {
      const __m128i eight = _mm_loadu_si128((const __m128i*)(row[i] + 8 * half));
      all[half] = _mm_and_si128(all[half], _mm_cmplt_epi16(eight, _mm_set1_epi16(six.limit[i])));
    }
  }
  mask = (unsigned)_mm_movemask_epi8(_mm_packs_epi16(all[0], all[1]));
#else
  for (int k = 0; k < 16; k++) {
    unsigned all = 1;
    for (int i = 0; i < 6; i++) {
      all &= row[i][k] < six.limit[i];
    }
    mask |= all << k;
  }
#endif
  return mask;
}

#endif

#endif /* CT_SIGNED_SHORTS_H_ */
