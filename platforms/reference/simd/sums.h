/* Sums of what sixteen floats hold, with the same bits on each instruction set of simd.h. */
#ifndef CT_SUMS_H_
#define CT_SUMS_H_

#include <string.h>

#include "simd.h"

/* a where it is below `limit` in lane k of b, and bit k of the mask is set; else 0. */
#if defined(CT_PATH_AVX512)

static inline Float16 keepBelow16(Float16 b, Float16 limit, Float16 a) {
  return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(b, limit, _CMP_LT_OQ), a);
}

static inline Float16 keep16(unsigned mask, Float16 a) {
  return _mm512_maskz_mov_ps((__mmask16)mask, a);
}

/* Both. */
static inline Float16 keepBelowAmong16(unsigned mask, Float16 b, Float16 limit, Float16 a) {
  return _mm512_maskz_mov_ps(_mm512_mask_cmp_ps_mask((__mmask16)mask, b, limit, _CMP_LT_OQ), a);
}

#elif defined(CT_PATH_AVX2)

static inline Float16 keepBelow16(Float16 b, Float16 limit, Float16 a) {
  return (Float16){_mm256_and_ps(_mm256_cmp_ps(b.low, limit.low, _CMP_LT_OQ), a.low),
                   _mm256_and_ps(_mm256_cmp_ps(b.high, limit.high, _CMP_LT_OQ), a.high)};
}

static inline Float16 keep16(unsigned mask, Float16 a) {
  return (Float16){_mm256_and_ps(lanes8(mask), a.low), _mm256_and_ps(lanes8(mask >> 8), a.high)};
}

#else

static inline Float16 keepBelow16(Float16 b, Float16 limit, Float16 a) {
  for (int i = 0; i < 4; i++)
    a.q[i] = (Float4)((b.q[i] < limit.q[i]) & (Int4)a.q[i]);
  return a;
}

static inline Float16 keep16(unsigned mask, Float16 a) {
  const Int4 bits = {1, 2, 4, 8};
  for (int i = 0; i < 4; i++) {
    const int part = (int)(mask >> 4 * i);
    a.q[i] = (Float4)((((Int4){part, part, part, part} & bits) == bits) & (Int4)a.q[i]);
  }
  return a;
}

#endif

#ifndef CT_PATH_AVX512

static inline Float16 keepBelowAmong16(unsigned mask, Float16 b, Float16 limit, Float16 a) {
  return keep16(mask, keepBelow16(b, limit, a));
}

#endif

/* Sixteen sums in double precision. */
#if defined(CT_PATH_AVX512)

typedef struct Sum16 {
  __m512d low;
  __m512d high;
} Sum16;

static inline Sum16 loadSum16(const double* p) {
  return (Sum16){_mm512_loadu_pd(p), _mm512_loadu_pd(p + 8)};
}

static inline void storeSum16(double* p, Sum16 sum) {
  _mm512_storeu_pd(p, sum.low);
  _mm512_storeu_pd(p + 8, sum.high);
}

static inline Sum16 zeroSum16(void) {
  return (Sum16){_mm512_setzero_pd(), _mm512_setzero_pd()};
}

static inline Sum16 addToSum16(Sum16 sum, Float16 a) {
  const __m256 high = _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(a), 1));
  return (Sum16){_mm512_add_pd(sum.low, _mm512_cvtps_pd(_mm512_castps512_ps256(a))),
                 _mm512_add_pd(sum.high, _mm512_cvtps_pd(high))};
}

#elif defined(CT_PATH_AVX2)

typedef struct Sum16 {
  __m256d quarter[4];
} Sum16;

static inline Sum16 loadSum16(const double* p) {
  return (Sum16){{_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4), _mm256_loadu_pd(p + 8), _mm256_loadu_pd(p + 12)}};
}

static inline void storeSum16(double* p, Sum16 sum) {
  for (int i = 0; i < 4; i++) {
    _mm256_storeu_pd(p + 4 * i, sum.quarter[i]);
  }
}

static inline Sum16 zeroSum16(void) {
  const __m256d zero = _mm256_setzero_pd();
  return (Sum16){{zero, zero, zero, zero}};
}

static inline Sum16 addToSum16(Sum16 sum, Float16 a) {
  const __m128 quarter[4] = {_mm256_castps256_ps128(a.low), _mm256_extractf128_ps(a.low, 1),
                             _mm256_castps256_ps128(a.high), _mm256_extractf128_ps(a.high, 1)};
  for (int i = 0; i < 4; i++) {
    sum.quarter[i] = _mm256_add_pd(sum.quarter[i], _mm256_cvtps_pd(quarter[i]));
  }
  return sum;
}

#else

typedef double Double2 __attribute__((vector_size(16)));

typedef struct Sum16 {
  Double2 pair[8];
} Sum16;

static inline Sum16 loadSum16(const double* p) {
  Sum16 sum;
  memcpy(&sum, p, sizeof sum);
  return sum;
}

static inline void storeSum16(double* p, Sum16 sum) {
  memcpy(p, &sum, sizeof sum);
}

static inline Sum16 zeroSum16(void) {
  return (Sum16){{{0, 0}}};
}

static inline Sum16 addToSum16(Sum16 sum, Float16 a) {
  for (int i = 0; i < 4; i++) {
    sum.pair[2 * i] += (Double2){(double)a.q[i][0], (double)a.q[i][1]};
    sum.pair[2 * i + 1] += (Double2){(double)a.q[i][2], (double)a.q[i][3]};
  }
  return sum;
}

#endif

/* The sum of all sixteen: of lanes eight apart, then four, two and one. */
#if defined(CT_PATH_AVX512) || defined(CT_PATH_AVX2)

static inline double total16(Sum16 sum) {
#ifdef CT_PATH_AVX512
  const __m512d eight = _mm512_add_pd(sum.low, sum.high);
  const __m256d four = _mm256_add_pd(_mm512_castpd512_pd256(eight), _mm512_extractf64x4_pd(eight, 1));
#else
  const __m256d four =
      _mm256_add_pd(_mm256_add_pd(sum.quarter[0], sum.quarter[2]), _mm256_add_pd(sum.quarter[1], sum.quarter[3]));
#endif
  const __m128d two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd(four, 1));
  return _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)));
}

#else

static inline double total16(Sum16 sum) {
  for (int width = 4; width > 0; width /= 2) {
    for (int i = 0; i < width; i++) {
      sum.pair[i] += sum.pair[i + width];
    }
  }
  return sum.pair[0][0] + sum.pair[0][1];
}

#endif

/* The sum of each of sixteen rows, in single precision: of lanes eight apart, then four, two and one. */
#if defined(CT_PATH_AVX512)

static inline Float16 sums16x16(const float rows[16][16]) {
  __m512 fours[4]; /* of rows i, i + 4, i + 8 and i + 12, four lanes each */
  for (int i = 0; i < 4; i++) {
    const __m512 a = _mm512_loadu_ps(rows[i]);
    const __m512 b = _mm512_loadu_ps(rows[i + 4]);
    const __m512 c = _mm512_loadu_ps(rows[i + 8]);
    const __m512 d = _mm512_loadu_ps(rows[i + 12]);
    const __m512 ab = _mm512_add_ps(_mm512_shuffle_f32x4(a, b, 0x44), _mm512_shuffle_f32x4(a, b, 0xee));
    const __m512 cd = _mm512_add_ps(_mm512_shuffle_f32x4(c, d, 0x44), _mm512_shuffle_f32x4(c, d, 0xee));
    fours[i] = _mm512_add_ps(_mm512_shuffle_f32x4(ab, cd, 0x88), _mm512_shuffle_f32x4(ab, cd, 0xdd));
  }
  const __m512 s =
      _mm512_add_ps(_mm512_shuffle_ps(fours[0], fours[1], 0x44), _mm512_shuffle_ps(fours[0], fours[1], 0xee));
  const __m512 t =
      _mm512_add_ps(_mm512_shuffle_ps(fours[2], fours[3], 0x44), _mm512_shuffle_ps(fours[2], fours[3], 0xee));
  return _mm512_add_ps(_mm512_shuffle_ps(s, t, 0x88), _mm512_shuffle_ps(s, t, 0xdd));
}

#elif defined(__SSE2__)

static inline Float16 sums16x16(const float rows[16][16]) {
  float sums[16];
  for (int i = 0; i < 16; i += 4) {
    __m128 four[4];
    for (int k = 0; k < 4; k++) {
      const float* row = rows[i + k];
      four[k] = _mm_add_ps(_mm_add_ps(_mm_loadu_ps(row), _mm_loadu_ps(row + 8)),
                           _mm_add_ps(_mm_loadu_ps(row + 4), _mm_loadu_ps(row + 12)));
    }
    _MM_TRANSPOSE4_PS(four[0], four[1], four[2], four[3]);
    _mm_storeu_ps(sums + i, _mm_add_ps(_mm_add_ps(four[0], four[2]), _mm_add_ps(four[1], four[3])));
  }
  return load16(sums);
}

#else

static inline Float16 sums16x16(const float rows[16][16]) {
  float sums[16];
  for (int i = 0; i < 16; i++) {
    float lanes[8];
    for (int k = 0; k < 8; k++) {
      lanes[k] = rows[i][k] + rows[i][k + 8];
    }
    for (int width = 4; width > 0; width /= 2) {
      for (int k = 0; k < width; k++) {
        lanes[k] += lanes[k + width];
      }
    }
    sums[i] = lanes[0];
  }
  return load16(sums);
}

#endif

/* The sum of each of four vectors, in the same order. */
#if defined(CT_PATH_AVX512)

static inline void total4x16(const Float16 a[4], float totals[4]) {
  const __m512 ab = _mm512_add_ps(_mm512_shuffle_f32x4(a[0], a[1], 0x44), _mm512_shuffle_f32x4(a[0], a[1], 0xee));
  const __m512 cd = _mm512_add_ps(_mm512_shuffle_f32x4(a[2], a[3], 0x44), _mm512_shuffle_f32x4(a[2], a[3], 0xee));
  const __m512 four = _mm512_add_ps(_mm512_shuffle_f32x4(ab, cd, 0x88), _mm512_shuffle_f32x4(ab, cd, 0xdd));
  const __m512 two = _mm512_add_ps(four, _mm512_shuffle_ps(four, four, 0x4e));
  const __m512 one = _mm512_add_ps(two, _mm512_shuffle_ps(two, two, 0xb1));
  const __m512i firsts = _mm512_setr_epi32(0, 4, 8, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
  _mm_storeu_ps(totals, _mm512_castps512_ps128(_mm512_permutexvar_ps(firsts, one)));
}

#else

static inline void total4x16(const Float16 a[4], float totals[4]) {
  for (int i = 0; i < 4; i++) {
    float lanes[16];
    store16(lanes, a[i]);
    for (int width = 8; width > 0; width /= 2) {
      for (int k = 0; k < width; k++) {
        lanes[k] += lanes[k + width];
      }
    }
    totals[i] = lanes[0];
  }
}

#endif

#endif /* CT_SUMS_H_ */
