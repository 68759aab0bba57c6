/* Sixteen floats at a time, by one of three instruction sets. All give the same bits: every operation rounds each lane
 * once, and none is fused. A file that includes this is compiled once for each, with CT_PATH_AVX512, CT_PATH_AVX2 or
 * neither defined.
 */
#ifndef CT_SIMD_H_
#define CT_SIMD_H_

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "inline.h"

#if defined(CT_PATH_AVX512)

#include <immintrin.h>

typedef __m512 Float16;

static inline Float16 load16(const float* p) {
  return _mm512_loadu_ps(p);
}

static inline void store16(float* p, Float16 a) {
  _mm512_storeu_ps(p, a);
}

static inline Float16 all16(float a) {
  return _mm512_set1_ps(a);
}

static inline Float16 add16(Float16 a, Float16 b) {
  return _mm512_add_ps(a, b);
}

static inline Float16 sub16(Float16 a, Float16 b) {
  return _mm512_sub_ps(a, b);
}

static inline Float16 mul16(Float16 a, Float16 b) {
  return _mm512_mul_ps(a, b);
}

static inline Float16 div16(Float16 a, Float16 b) {
  return _mm512_div_ps(a, b);
}

static inline Float16 sqrt16(Float16 a) {
  return _mm512_sqrt_ps(a);
}

static inline Float16 min16(Float16 a, Float16 b) {
  return _mm512_min_ps(a, b);
}

static inline Float16 absolute16(Float16 a) {
  return _mm512_abs_ps(a);
}

static inline Float16 max16(Float16 a, Float16 b) {
  return _mm512_max_ps(a, b);
}

/* Bit k: a[k] > b[k]. */
static inline unsigned greater16(Float16 a, Float16 b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ);
}

/* Bit k: p[k] == a. */
static inline unsigned equal16(const int* p, int a) {
  return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(p), _mm512_set1_epi32(a));
}

/* b where the mask has a bit, else a. */
static inline Float16 blend16(unsigned mask, Float16 a, Float16 b) {
  return _mm512_mask_blend_ps((__mmask16)mask, a, b);
}

/* Sixteen ints, all equal: to be blended and stored only. */
static inline Float16 allInts16(int a) {
  return _mm512_castsi512_ps(_mm512_set1_epi32(a));
}

static inline void storeInts16(int* p, Float16 a) {
  _mm512_storeu_si512(p, _mm512_castps_si512(a));
}

/* x * row[0] + y * row[1] + z * row[2] + row[3] in double, rounded to float. */
static inline Float16 rounded16(const double* x, const double* y, const double* z, const double row[4]) {
  __m256 halves[2];
  for (int i = 0; i < 2; i++) {
    const __m512d ax = _mm512_mul_pd(_mm512_loadu_pd(x + 8 * i), _mm512_set1_pd(row[0]));
    const __m512d by = _mm512_mul_pd(_mm512_loadu_pd(y + 8 * i), _mm512_set1_pd(row[1]));
    const __m512d cz = _mm512_mul_pd(_mm512_loadu_pd(z + 8 * i), _mm512_set1_pd(row[2]));
    const __m512d sum = _mm512_add_pd(_mm512_add_pd(_mm512_add_pd(ax, by), cz), _mm512_set1_pd(row[3]));
    halves[i] = _mm512_cvtpd_ps(sum);
  }
  const __m512d low = _mm512_castpd256_pd512(_mm256_castps_pd(halves[0]));
  return _mm512_castpd_ps(_mm512_insertf64x4(low, _mm256_castps_pd(halves[1]), 1));
}

/* Writes first + k for each bit k of the mask, ascending; returns how many. May overwrite sixteen entries. */
static inline int indices16(unsigned mask, int first, int* indices) {
  const __m512i all = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i chosen = _mm512_maskz_compress_epi32((__mmask16)mask, all);
  _mm512_storeu_si512(indices, _mm512_add_epi32(chosen, _mm512_set1_epi32(first)));
  return __builtin_popcount(mask);
}

static inline float least16(Float16 a) {
  return _mm512_reduce_min_ps(a);
}

static inline float most16(Float16 a) {
  return _mm512_reduce_max_ps(a);
}

/* The least lane of each of four vectors. */
static inline void least4x16(const Float16 a[4], float least[4]) {
  const __m512 ab = _mm512_min_ps(_mm512_shuffle_ps(a[0], a[1], 0x44), _mm512_shuffle_ps(a[0], a[1], 0xee));
  const __m512 cd = _mm512_min_ps(_mm512_shuffle_ps(a[2], a[3], 0x44), _mm512_shuffle_ps(a[2], a[3], 0xee));
  const __m512 abcd = _mm512_min_ps(_mm512_shuffle_ps(ab, cd, 0x88), _mm512_shuffle_ps(ab, cd, 0xdd));
  const __m512 two = _mm512_min_ps(abcd, _mm512_shuffle_f32x4(abcd, abcd, 0x4e));
  const __m512 one = _mm512_min_ps(two, _mm512_shuffle_f32x4(two, two, 0xb1));
  _mm_storeu_ps(least, _mm512_castps512_ps128(one));
}

#elif defined(CT_PATH_AVX2)

#include <immintrin.h>

typedef struct Float16 {
  __m256 low;
  __m256 high;
} Float16;

static inline Float16 load16(const float* p) {
  return (Float16){_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)};
}

static inline void store16(float* p, Float16 a) {
  _mm256_storeu_ps(p, a.low);
  _mm256_storeu_ps(p + 8, a.high);
}

static inline Float16 all16(float a) {
  const __m256 all = _mm256_set1_ps(a);
  return (Float16){all, all};
}

static inline Float16 add16(Float16 a, Float16 b) {
  return (Float16){_mm256_add_ps(a.low, b.low), _mm256_add_ps(a.high, b.high)};
}

static inline Float16 sub16(Float16 a, Float16 b) {
  return (Float16){_mm256_sub_ps(a.low, b.low), _mm256_sub_ps(a.high, b.high)};
}

static inline Float16 mul16(Float16 a, Float16 b) {
  return (Float16){_mm256_mul_ps(a.low, b.low), _mm256_mul_ps(a.high, b.high)};
}

static inline Float16 div16(Float16 a, Float16 b) {
  return (Float16){_mm256_div_ps(a.low, b.low), _mm256_div_ps(a.high, b.high)};
}

static inline Float16 sqrt16(Float16 a) {
  return (Float16){_mm256_sqrt_ps(a.low), _mm256_sqrt_ps(a.high)};
}

static inline Float16 min16(Float16 a, Float16 b) {
  return (Float16){_mm256_min_ps(a.low, b.low), _mm256_min_ps(a.high, b.high)};
}

static inline Float16 absolute16(Float16 a) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return (Float16){_mm256_andnot_ps(sign, a.low), _mm256_andnot_ps(sign, a.high)};
}

static inline Float16 max16(Float16 a, Float16 b) {
  return (Float16){_mm256_max_ps(a.low, b.low), _mm256_max_ps(a.high, b.high)};
}

static inline unsigned greater16(Float16 a, Float16 b) {
  const int low = _mm256_movemask_ps(_mm256_cmp_ps(a.low, b.low, _CMP_GT_OQ));
  const int high = _mm256_movemask_ps(_mm256_cmp_ps(a.high, b.high, _CMP_GT_OQ));
  return (unsigned)low | (unsigned)high << 8;
}

static inline unsigned equal16(const int* p, int a) {
  const __m256i all = _mm256_set1_epi32(a);
  const __m256i low = _mm256_cmpeq_epi32(_mm256_loadu_si256((const __m256i*)p), all);
  const __m256i high = _mm256_cmpeq_epi32(_mm256_loadu_si256((const __m256i*)(p + 8)), all);
  return (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(low)) |
         (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(high)) << 8;
}

static inline __m256 lanes8(unsigned mask) {
  const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i chosen = _mm256_and_si256(_mm256_set1_epi32((int)mask), bits);
  return _mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, bits));
}

static inline Float16 blend16(unsigned mask, Float16 a, Float16 b) {
  return (Float16){_mm256_blendv_ps(a.low, b.low, lanes8(mask)), _mm256_blendv_ps(a.high, b.high, lanes8(mask >> 8))};
}

static inline Float16 allInts16(int a) {
  const __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(a));
  return (Float16){all, all};
}

static inline void storeInts16(int* p, Float16 a) {
  _mm256_storeu_si256((__m256i*)p, _mm256_castps_si256(a.low));
  _mm256_storeu_si256((__m256i*)(p + 8), _mm256_castps_si256(a.high));
}

static inline Float16 rounded16(const double* x, const double* y, const double* z, const double row[4]) {
  __m128 quarters[4];
  for (int i = 0; i < 4; i++) {
    const __m256d ax = _mm256_mul_pd(_mm256_loadu_pd(x + 4 * i), _mm256_set1_pd(row[0]));
    const __m256d by = _mm256_mul_pd(_mm256_loadu_pd(y + 4 * i), _mm256_set1_pd(row[1]));
    const __m256d cz = _mm256_mul_pd(_mm256_loadu_pd(z + 4 * i), _mm256_set1_pd(row[2]));
    const __m256d sum = _mm256_add_pd(_mm256_add_pd(_mm256_add_pd(ax, by), cz), _mm256_set1_pd(row[3]));
    quarters[i] = _mm256_cvtpd_ps(sum);
  }
  return (Float16){_mm256_set_m128(quarters[1], quarters[0]), _mm256_set_m128(quarters[3], quarters[2])};
}

static inline float least16(Float16 a) {
  const __m256 eight = _mm256_min_ps(a.low, a.high);
  __m128 four = _mm_min_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  four = _mm_min_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_min_ss(four, _mm_shuffle_ps(four, four, 1)));
}

static inline float most16(Float16 a) {
  const __m256 eight = _mm256_max_ps(a.low, a.high);
  __m128 four = _mm_max_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  four = _mm_max_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_max_ss(four, _mm_shuffle_ps(four, four, 1)));
}

static inline void least4x16(const Float16 a[4], float least[4]) {
  __m256 eight[4];
  for (int i = 0; i < 4; i++) {
    eight[i] = _mm256_min_ps(a[i].low, a[i].high);
  }
  const __m256 ab =
      _mm256_min_ps(_mm256_shuffle_ps(eight[0], eight[1], 0x44), _mm256_shuffle_ps(eight[0], eight[1], 0xee));
  const __m256 cd =
      _mm256_min_ps(_mm256_shuffle_ps(eight[2], eight[3], 0x44), _mm256_shuffle_ps(eight[2], eight[3], 0xee));
  const __m256 abcd = _mm256_min_ps(_mm256_shuffle_ps(ab, cd, 0x88), _mm256_shuffle_ps(ab, cd, 0xdd));
  _mm_storeu_ps(least, _mm_min_ps(_mm256_castps256_ps128(abcd), _mm256_extractf128_ps(abcd, 1)));
}

#else

/* Four vectors of four, by the vector extension of gcc and clang: every machine has them. */
#ifdef __SSE2__
#include <emmintrin.h>
#endif

typedef float Float4 __attribute__((vector_size(16)));
typedef int Int4 __attribute__((vector_size(16)));

typedef struct Float16 {
  Float4 q[4];
} Float16;

#define CT_EACH_QUARTER for (int i = 0; i < 4; i++)

static inline Float16 load16(const float* p) {
  Float16 a;
  __builtin_memcpy(&a, p, sizeof a);
  return a;
}

static inline void store16(float* p, Float16 a) {
  __builtin_memcpy(p, &a, sizeof a);
}

static inline Float16 all16(float a) {
  const Float4 all = {a, a, a, a};
  return (Float16){{all, all, all, all}};
}

static inline Float16 add16(Float16 a, Float16 b) {
  CT_EACH_QUARTER a.q[i] += b.q[i];
  return a;
}

static inline Float16 sub16(Float16 a, Float16 b) {
  CT_EACH_QUARTER a.q[i] -= b.q[i];
  return a;
}

static inline Float16 mul16(Float16 a, Float16 b) {
  CT_EACH_QUARTER a.q[i] *= b.q[i];
  return a;
}

static inline Float16 div16(Float16 a, Float16 b) {
  CT_EACH_QUARTER a.q[i] /= b.q[i];
  return a;
}

static inline Float16 sqrt16(Float16 a) {
#ifdef __SSE2__
  CT_EACH_QUARTER a.q[i] = _mm_sqrt_ps(a.q[i]);
#else
  CT_EACH_QUARTER {
    for (int k = 0; k < 4; k++) {
      a.q[i][k] = sqrtf(a.q[i][k]);
    }
  }
#endif
  return a;
}

/* Bit k is the sign of lane k. */
static inline unsigned bits4(Int4 lanes) {
#ifdef __SSE2__
  return (unsigned)_mm_movemask_ps((Float4)lanes);
#else
  unsigned mask = 0;
  for (int k = 0; k < 4; k++) {
    mask |= (unsigned)lanes[k] >> 31 << k;
  }
  return mask;
#endif
}

static inline unsigned greater16(Float16 a, Float16 b) {
  return bits4(a.q[0] > b.q[0]) | bits4(a.q[1] > b.q[1]) << 4 | bits4(a.q[2] > b.q[2]) << 8 |
         bits4(a.q[3] > b.q[3]) << 12;
}

static inline unsigned equal16(const int* p, int a) {
  const Int4 all = {a, a, a, a};
  unsigned mask = 0;
  CT_EACH_QUARTER {
    Int4 q;
    __builtin_memcpy(&q, p + 4 * i, sizeof q);
    mask |= bits4(q == all) << 4 * i;
  }
  return mask;
}

static inline Float16 blend16(unsigned mask, Float16 a, Float16 b) {
  const Int4 bits = {1, 2, 4, 8};
  CT_EACH_QUARTER {
    const int nibble = (int)(mask >> 4 * i);
    const Int4 chosen = (((Int4){nibble, nibble, nibble, nibble}) & bits) == bits;
    a.q[i] = (Float4)(((Int4)a.q[i] & ~chosen) | ((Int4)b.q[i] & chosen));
  }
  return a;
}

static inline Float16 allInts16(int a) {
  const Int4 all = {a, a, a, a};
  return (Float16){{(Float4)all, (Float4)all, (Float4)all, (Float4)all}};
}

static inline void storeInts16(int* p, Float16 a) {
  __builtin_memcpy(p, &a, sizeof a);
}

static inline Float16 rounded16(const double* x, const double* y, const double* z, const double row[4]) {
  float rounded[16];
  for (int k = 0; k < 16; k++) {
    rounded[k] = (float)(x[k] * row[0] + y[k] * row[1] + z[k] * row[2] + row[3]);
  }
  return load16(rounded);
}

static inline Float16 absolute16(Float16 a) {
  const Int4 mask = {0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff};
  CT_EACH_QUARTER a.q[i] = (Float4)((Int4)a.q[i] & mask);
  return a;
}

static inline Float4 min4(Float4 a, Float4 b) {
#ifdef __SSE2__
  return __builtin_ia32_minps(a, b);
#else
  const Int4 chosen = a < b;
  return (Float4)(((Int4)a & chosen) | ((Int4)b & ~chosen));
#endif
}

static inline Float4 max4(Float4 a, Float4 b) {
#ifdef __SSE2__
  return __builtin_ia32_maxps(a, b);
#else
  const Int4 chosen = a > b;
  return (Float4)(((Int4)a & chosen) | ((Int4)b & ~chosen));
#endif
}

static inline Float16 min16(Float16 a, Float16 b) {
  CT_EACH_QUARTER a.q[i] = min4(a.q[i], b.q[i]);
  return a;
}

static inline Float16 max16(Float16 a, Float16 b) {
  CT_EACH_QUARTER a.q[i] = max4(a.q[i], b.q[i]);
  return a;
}

static inline float least16(Float16 a) {
  const Float4 four = min4(min4(a.q[0], a.q[1]), min4(a.q[2], a.q[3]));
  const float low = four[0] < four[1] ? four[0] : four[1];
  const float high = four[2] < four[3] ? four[2] : four[3];
  return low < high ? low : high;
}

static inline float most16(Float16 a) {
  const Float4 four = max4(max4(a.q[0], a.q[1]), max4(a.q[2], a.q[3]));
  const float low = four[0] > four[1] ? four[0] : four[1];
  const float high = four[2] > four[3] ? four[2] : four[3];
  return low > high ? low : high;
}

static inline void least4x16(const Float16 a[4], float least[4]) {
#ifdef __SSE2__
  __m128 four[4];
  for (int i = 0; i < 4; i++) {
    four[i] = (__m128)min4(min4(a[i].q[0], a[i].q[1]), min4(a[i].q[2], a[i].q[3]));
  }
  _MM_TRANSPOSE4_PS(four[0], four[1], four[2], four[3]);
  _mm_storeu_ps(least, _mm_min_ps(_mm_min_ps(four[0], four[1]), _mm_min_ps(four[2], four[3])));
#else
  for (int i = 0; i < 4; i++) {
    least[i] = least16(a[i]);
  }
#endif
}

#undef CT_EACH_QUARTER

#endif

#ifndef CT_PATH_AVX512

static inline int indices16(unsigned mask, int first, int* indices) {
  int count = 0;
  for (; mask != 0; mask &= mask - 1) {
    indices[count++] = first + __builtin_ctz(mask);
  }
  return count;
}

#endif

/* The same for 64 bits. Where that is a loop, one of 64 is mispredicted less often than four of sixteen. */
static inline int indices64(uint64_t mask, int first, int* indices) {
  int count = 0;
#ifdef CT_PATH_AVX512
  for (int i = 0; i < 64; i += 16) {
    count += indices16((unsigned)(mask >> i & 0xffff), first + i, indices + count);
  }
#else
  for (; mask != 0; mask &= mask - 1) {
    indices[count++] = first + __builtin_ctzll(mask);
  }
#endif
  return count;
}

/* ---- Limits ---- */

/* Which numbers are under a limit, and whether some of them may not have been under a lower one. */
#if defined(CT_PATH_AVX512)

typedef struct Under {
  __m512 limit;
  __m512i least; /* of numbers minus the limit, as integers: those of negative floats fall as the floats rise */
  __m512i doubt; /* the lower limit minus the limit */
} Under;

static inline Under underLimits16(float limit, float lower) {
  const __m512 limits = _mm512_set1_ps(limit);
  return (Under){limits, _mm512_setzero_si512(), _mm512_castps_si512(_mm512_sub_ps(_mm512_set1_ps(lower), limits))};
}

/* Bit k: a[k] is under the limit. */
static inline unsigned under16(Under* under, Float16 a) {
  under->least = _mm512_min_epi32(under->least, _mm512_castps_si512(_mm512_sub_ps(a, under->limit)));
  return _mm512_cmp_ps_mask(a, under->limit, _CMP_LT_OQ);
}

/* May be true though all have been under the lower limit. */
static inline bool someBetween16(const Under* under) {
  return _mm512_cmple_epi32_mask(under->least, under->doubt) != 0;
}

#elif defined(CT_PATH_AVX2)

typedef struct Under {
  __m256 limit;
  __m256i least;
  __m256i doubt;
} Under;

static inline Under underLimits16(float limit, float lower) {
  const __m256 limits = _mm256_set1_ps(limit);
  return (Under){limits, _mm256_setzero_si256(), _mm256_castps_si256(_mm256_sub_ps(_mm256_set1_ps(lower), limits))};
}

static inline unsigned under16(Under* under, Float16 a) {
  const __m256 low = _mm256_sub_ps(a.low, under->limit);
  const __m256 high = _mm256_sub_ps(a.high, under->limit);
  const __m256i least = _mm256_min_epi32(_mm256_castps_si256(low), _mm256_castps_si256(high));
  under->least = _mm256_min_epi32(under->least, least);
  return (unsigned)_mm256_movemask_ps(low) | (unsigned)_mm256_movemask_ps(high) << 8;
}

static inline bool someBetween16(const Under* under) {
  return _mm256_movemask_epi8(_mm256_cmpgt_epi32(under->least, under->doubt)) != -1;
}

#else

typedef struct Under {
  Float4 limit;
  Float4 least; /* distance of a number from the limit, on either side */
  float doubt;
} Under;

static inline Under underLimits16(float limit, float lower) {
  const Float4 none = {INFINITY, INFINITY, INFINITY, INFINITY};
  return (Under){{limit, limit, limit, limit}, none, limit - lower};
}

static inline unsigned under16(Under* under, Float16 a) {
  const Int4 magnitude = {0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff};
  unsigned mask = 0;
  for (int i = 0; i < 4; i++) {
    const Float4 above = a.q[i] - under->limit;
    under->least = min4((Float4)((Int4)above & magnitude), under->least); /* in this order NaN changes nothing */
    mask |= bits4((Int4)above) << 4 * i;
  }
  return mask;
}

static inline bool someBetween16(const Under* under) {
  const Float4 doubts = {under->doubt, under->doubt, under->doubt, under->doubt};
  return bits4(under->least <= doubts) != 0;
}

#endif

/* x * x + y * y + z * z */
static inline Float16 squared16(Float16 x, Float16 y, Float16 z) {
  return add16(add16(mul16(x, x), mul16(y, y)), mul16(z, z));
}

/* ---- Sixteen unsigned shorts ---- */

#if defined(CT_PATH_AVX512) || defined(CT_PATH_AVX2)

typedef __m256i Short16;

static inline Short16 loadShorts(const uint16_t* p) {
  return _mm256_loadu_si256((const __m256i*)p);
}

static inline void storeShorts(uint16_t* p, Short16 a) {
  _mm256_storeu_si256((__m256i*)p, a);
}

static inline Short16 allShorts(uint16_t a) {
  return _mm256_set1_epi16((short)a);
}

static inline Short16 minShorts(Short16 a, Short16 b) {
  return _mm256_min_epu16(a, b);
}

static inline Short16 maxShorts(Short16 a, Short16 b) {
  return _mm256_max_epu16(a, b);
}

/* a - b, or 0 if that is negative. */
static inline Short16 lessShorts(Short16 a, Short16 b) {
  return _mm256_subs_epu16(a, b);
}

/* a + b, or the most that there is. */
static inline Short16 moreShorts(Short16 a, Short16 b) {
  return _mm256_adds_epu16(a, b);
}

/* Rounded down; all lie within the range. */
static inline Short16 shortsOf16(Float16 a) {
#ifdef CT_PATH_AVX512
  return _mm512_cvtepi32_epi16(_mm512_cvttps_epi32(a));
#else
  const __m256i packed = _mm256_packus_epi32(_mm256_cvttps_epi32(a.low), _mm256_cvttps_epi32(a.high));
  return _mm256_permute4x64_epi64(packed, 0xd8);
#endif
}

/* Bit k: a[k] == 0. */
static inline unsigned zeroShorts(Short16 a) {
  const __m256i zero = _mm256_cmpeq_epi16(a, _mm256_setzero_si256());
  const __m128i bytes = _mm_packs_epi16(_mm256_castsi256_si128(zero), _mm256_extracti128_si256(zero, 1));
  return (unsigned)_mm_movemask_epi8(bytes);
}

/* b where the mask has a bit, else a. */
static inline Short16 blendShorts(unsigned mask, Short16 a, Short16 b) {
  const __m256i bits = _mm256_setr_epi16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, -32768);
  const __m256i chosen = _mm256_cmpeq_epi16(_mm256_and_si256(_mm256_set1_epi16((short)mask), bits), bits);
  return _mm256_blendv_epi8(a, b, chosen);
}

#else

typedef uint16_t Short8 __attribute__((vector_size(16)));

typedef struct Short16 {
  Short8 h[2];
} Short16;

static inline Short16 loadShorts(const uint16_t* p) {
  Short16 a;
  __builtin_memcpy(&a, p, sizeof a);
  return a;
}

static inline void storeShorts(uint16_t* p, Short16 a) {
  __builtin_memcpy(p, &a, sizeof a);
}

static inline Short16 allShorts(uint16_t a) {
  const Short8 all = {a, a, a, a, a, a, a, a};
  return (Short16){{all, all}};
}

/* a - b, or 0: SSE2 has no other comparison of unsigned shorts. */
static inline Short8 lessShort8(Short8 a, Short8 b) {
#ifdef __SSE2__
  return (Short8)_mm_subs_epu16((__m128i)a, (__m128i)b);
#else
  return (a - b) & (Short8)(a > b);
#endif
}

static inline Short16 lessShorts(Short16 a, Short16 b) {
  return (Short16){{lessShort8(a.h[0], b.h[0]), lessShort8(a.h[1], b.h[1])}};
}

static inline Short16 minShorts(Short16 a, Short16 b) {
  return (Short16){{a.h[0] - lessShort8(a.h[0], b.h[0]), a.h[1] - lessShort8(a.h[1], b.h[1])}};
}

static inline Short16 maxShorts(Short16 a, Short16 b) {
  return (Short16){{b.h[0] + lessShort8(a.h[0], b.h[0]), b.h[1] + lessShort8(a.h[1], b.h[1])}};
}

static inline Short16 moreShorts(Short16 a, Short16 b) {
  return (Short16){{~lessShort8(~a.h[0], b.h[0]), ~lessShort8(~a.h[1], b.h[1])}};
}

static inline Short16 shortsOf16(Float16 a) {
  Short16 shorts;
#ifdef __SSE2__
  /* Packing saturates as if numbers were signed, so they are shifted. */
  const __m128i half = _mm_set1_epi32(1 << 15);
  for (int i = 0; i < 2; i++) {
    const __m128i low = _mm_sub_epi32(_mm_cvttps_epi32((__m128)a.q[2 * i]), half);
    const __m128i high = _mm_sub_epi32(_mm_cvttps_epi32((__m128)a.q[2 * i + 1]), half);
    shorts.h[i] = (Short8)_mm_packs_epi32(low, high) ^ (uint16_t)(1 << 15);
  }
#else
  for (int k = 0; k < 16; k++) {
    shorts.h[k / 8][k % 8] = (uint16_t)(int)a.q[k / 4][k % 4];
  }
#endif
  return shorts;
}

static inline unsigned zeroShorts(Short16 a) {
#ifdef __SSE2__
  return (unsigned)_mm_movemask_epi8(_mm_packs_epi16((__m128i)(a.h[0] == 0), (__m128i)(a.h[1] == 0)));
#else
  unsigned mask = 0;
  for (unsigned k = 0; k < 16; k++) {
    mask |= (unsigned)(a.h[k / 8][k % 8] == 0) << k;
  }
  return mask;
#endif
}

static inline Short16 blendShorts(unsigned mask, Short16 a, Short16 b) {
  const Short8 bits = {1, 2, 4, 8, 16, 32, 64, 128};
  for (int i = 0; i < 2; i++) {
    const uint16_t byte = (uint16_t)(mask >> 8 * i & 255);
    const Short8 chosen = (Short8)((((Short8){byte, byte, byte, byte, byte, byte, byte, byte}) & bits) == bits);
    a.h[i] = (b.h[i] & chosen) | (a.h[i] & ~chosen);
  }
  return a;
}

#endif

/* Bit k of 32 is set if a[k] <= min(b[k], most). */
#if defined(CT_PATH_AVX512)

static inline uint32_t within32(const uint16_t* a, const uint16_t* b, uint16_t most) {
  const __m512i least = _mm512_min_epu16(_mm512_loadu_si512(b), _mm512_set1_epi16((short)most));
  return _mm512_cmple_epu16_mask(_mm512_loadu_si512(a), least);
}

#else

static inline uint32_t within32(const uint16_t* a, const uint16_t* b, uint16_t most) {
  uint32_t mask = 0;
  for (int k = 0; k < 32; k += 16) {
    const Short16 least = minShorts(loadShorts(b + k), allShorts(most));
    mask |= (uint32_t)zeroShorts(lessShorts(loadShorts(a + k), least)) << k;
  }
  return mask;
}

#endif

/* ---- Points ---- */

/* Four points from an origin, rounded to float. May read one number beyond each point. */
#if defined(CT_PATH_AVX512) || defined(CT_PATH_AVX2)

static inline void floats4(const double* const points[4], const double origin[3], float* x, float* y, float* z) {
  const __m256d about = _mm256_setr_pd(origin[0], origin[1], origin[2], 0);
  __m128 rows[4];
  for (int i = 0; i < 4; i++) {
    rows[i] = _mm256_cvtpd_ps(_mm256_sub_pd(_mm256_loadu_pd(points[i]), about));
  }
  _MM_TRANSPOSE4_PS(rows[0], rows[1], rows[2], rows[3]);
  _mm_storeu_ps(x, rows[0]);
  _mm_storeu_ps(y, rows[1]);
  _mm_storeu_ps(z, rows[2]);
}

#else

static inline void floats4(const double* const points[4], const double origin[3], float* x, float* y, float* z) {
  for (int i = 0; i < 4; i++) {
    x[i] = (float)(points[i][0] - origin[0]);
    y[i] = (float)(points[i][1] - origin[1]);
    z[i] = (float)(points[i][2] - origin[2]);
  }
}

#endif

/* ---- Bits ---- */

/* Bit l of column k is bit k of row l. */
static inline void transposeBits(const uint16_t rows[16], uint16_t columns[16]) {
#ifdef __SSE2__
  const __m128i first = _mm_loadu_si128((const __m128i*)rows);
  const __m128i last = _mm_loadu_si128((const __m128i*)(rows + 8));
  const __m128i byte = _mm_set1_epi16(255);
  __m128i low = _mm_packus_epi16(_mm_and_si128(first, byte), _mm_and_si128(last, byte));
  __m128i high = _mm_packus_epi16(_mm_srli_epi16(first, 8), _mm_srli_epi16(last, 8));
  for (int k = 7; k >= 0; k--) {
    columns[k] = (uint16_t)_mm_movemask_epi8(low);
    columns[k + 8] = (uint16_t)_mm_movemask_epi8(high);
    low = _mm_add_epi8(low, low);
    high = _mm_add_epi8(high, high);
  }
#else
  for (int k = 0; k < 16; k++) {
    unsigned column = 0;
    for (int l = 0; l < 16; l++) {
      column |= (rows[l] >> k & 1u) << l;
    }
    columns[k] = (uint16_t)column;
  }
#endif
}

#endif /* CT_SIMD_H_ */
