/* Sixteen ints, the bits of sixteen floats, and choices lane by lane, with the same bits on each instruction set of
 * simd.h. */
#ifndef CT_INTS_H_
#define CT_INTS_H_

#include <string.h>

#include "simd.h"

#if defined(CT_PATH_AVX512)

typedef __m512i Int16;

static inline Int16 allInts(int a) {
  return _mm512_set1_epi32(a);
}

/* The bits of floats as ints, and back. */
static inline Int16 bitsOf16(Float16 a) {
  return _mm512_castps_si512(a);
}

static inline Float16 floatsOfBits(Int16 a) {
  return _mm512_castsi512_ps(a);
}

static inline Int16 addInts(Int16 a, Int16 b) {
  return _mm512_add_epi32(a, b);
}

static inline Int16 subInts(Int16 a, Int16 b) {
  return _mm512_sub_epi32(a, b);
}

static inline Int16 andInts(Int16 a, Int16 b) {
  return _mm512_and_si512(a, b);
}

static inline Int16 orInts(Int16 a, Int16 b) {
  return _mm512_or_si512(a, b);
}

static inline Int16 xorInts(Int16 a, Int16 b) {
  return _mm512_xor_si512(a, b);
}

static inline Int16 shiftLeftInts(Int16 a, int by) {
  return _mm512_slli_epi32(a, (unsigned)by);
}

/* Keeps the sign. */
static inline Int16 shiftRightInts(Int16 a, int by) {
  return _mm512_srai_epi32(a, (unsigned)by);
}

/* The nearest floats. */
static inline Float16 floatsOfInts(Int16 a) {
  return _mm512_cvtepi32_ps(a);
}

/* Without what is behind the point; all lie within the range. */
static inline Int16 intsOf16(Float16 a) {
  return _mm512_cvttps_epi32(a);
}

/* p[a[k]] in each lane k. */
static inline Float16 gather16(const float* p, Int16 a) {
  return _mm512_i32gather_ps(a, p, 4);
}

/* In each lane: yes where a < b, else no. */
static inline Float16 chooseBelow16(Float16 a, Float16 b, Float16 yes, Float16 no) {
  return _mm512_mask_blend_ps(_mm512_cmp_ps_mask(a, b, _CMP_LT_OQ), no, yes);
}

/* In each lane: yes where a == b, else no. */
static inline Float16 chooseEqual16(Float16 a, Float16 b, Float16 yes, Float16 no) {
  return _mm512_mask_blend_ps(_mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ), no, yes);
}

static inline Int16 loadInts(const int* p) {
  return _mm512_loadu_si512(p);
}

/* p[k] of sixteen numbers, where k are the lowest four bits of each index. */
static inline Float16 lookup16(const float* p, Int16 indices) {
  return _mm512_permutexvar_ps(indices, _mm512_loadu_ps(p));
}

/* Writes the lanes of a for which the mask has a bit, ascending, and `first` plus their numbers; returns how many. May
 * overwrite sixteen entries. */
static inline int pack16(unsigned mask, Float16 a, int first, float* packed, int* places) {
  const __m512i all = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i chosen = _mm512_maskz_compress_epi32((__mmask16)mask, _mm512_add_epi32(all, _mm512_set1_epi32(first)));
  _mm512_storeu_ps(packed, _mm512_maskz_compress_ps((__mmask16)mask, a));
  _mm512_storeu_si512(places, chosen);
  return __builtin_popcount(mask);
}

#elif defined(CT_PATH_AVX2)

typedef struct Int16 {
  __m256i low;
  __m256i high;
} Int16;

static inline Int16 allInts(int a) {
  const __m256i all = _mm256_set1_epi32(a);
  return (Int16){all, all};
}

static inline Int16 bitsOf16(Float16 a) {
  return (Int16){_mm256_castps_si256(a.low), _mm256_castps_si256(a.high)};
}

static inline Float16 floatsOfBits(Int16 a) {
  return (Float16){_mm256_castsi256_ps(a.low), _mm256_castsi256_ps(a.high)};
}

static inline Int16 addInts(Int16 a, Int16 b) {
  return (Int16){_mm256_add_epi32(a.low, b.low), _mm256_add_epi32(a.high, b.high)};
}

static inline Int16 subInts(Int16 a, Int16 b) {
  return (Int16){_mm256_sub_epi32(a.low, b.low), _mm256_sub_epi32(a.high, b.high)};
}

static inline Int16 andInts(Int16 a, Int16 b) {
  return (Int16){_mm256_and_si256(a.low, b.low), _mm256_and_si256(a.high, b.high)};
}

static inline Int16 orInts(Int16 a, Int16 b) {
  return (Int16){_mm256_or_si256(a.low, b.low), _mm256_or_si256(a.high, b.high)};
}

static inline Int16 xorInts(Int16 a, Int16 b) {
  return (Int16){_mm256_xor_si256(a.low, b.low), _mm256_xor_si256(a.high, b.high)};
}

static inline Int16 shiftLeftInts(Int16 a, int by) {
  return (Int16){_mm256_slli_epi32(a.low, by), _mm256_slli_epi32(a.high, by)};
}

static inline Int16 shiftRightInts(Int16 a, int by) {
  return (Int16){_mm256_srai_epi32(a.low, by), _mm256_srai_epi32(a.high, by)};
}

static inline Float16 floatsOfInts(Int16 a) {
  return (Float16){_mm256_cvtepi32_ps(a.low), _mm256_cvtepi32_ps(a.high)};
}

static inline Int16 intsOf16(Float16 a) {
  return (Int16){_mm256_cvttps_epi32(a.low), _mm256_cvttps_epi32(a.high)};
}

static inline Float16 gather16(const float* p, Int16 a) {
  return (Float16){_mm256_i32gather_ps(p, a.low, 4), _mm256_i32gather_ps(p, a.high, 4)};
}

static inline Float16 chooseBelow16(Float16 a, Float16 b, Float16 yes, Float16 no) {
  return (Float16){_mm256_blendv_ps(no.low, yes.low, _mm256_cmp_ps(a.low, b.low, _CMP_LT_OQ)),
                   _mm256_blendv_ps(no.high, yes.high, _mm256_cmp_ps(a.high, b.high, _CMP_LT_OQ))};
}

static inline Float16 chooseEqual16(Float16 a, Float16 b, Float16 yes, Float16 no) {
  return (Float16){_mm256_blendv_ps(no.low, yes.low, _mm256_cmp_ps(a.low, b.low, _CMP_EQ_OQ)),
                   _mm256_blendv_ps(no.high, yes.high, _mm256_cmp_ps(a.high, b.high, _CMP_EQ_OQ))};
}

static inline Int16 loadInts(const int* p) {
  return (Int16){_mm256_loadu_si256((const __m256i*)p), _mm256_loadu_si256((const __m256i*)(p + 8))};
}

static inline __m256 lookup8(__m256 low, __m256 high, __m256i indices) {
  const __m256 isHigh = _mm256_castsi256_ps(_mm256_slli_epi32(indices, 28));
  return _mm256_blendv_ps(_mm256_permutevar8x32_ps(low, indices), _mm256_permutevar8x32_ps(high, indices), isHigh);
}

static inline Float16 lookup16(const float* p, Int16 indices) {
  const __m256 low = _mm256_loadu_ps(p);
  const __m256 high = _mm256_loadu_ps(p + 8);
  return (Float16){lookup8(low, high, indices.low), lookup8(low, high, indices.high)};
}

/* The numbers of the bits of a byte that are set, ascending, four bits each from the lowest on. */
#define CT_ORDER_BIT(byte, k, higher) (((higher) << 4 * ((byte) >> (k)&1)) | ((byte) >> (k)&1) * (k))
#define CT_ORDER_HIGH(byte) \
  CT_ORDER_BIT(byte, 4u, CT_ORDER_BIT(byte, 5u, CT_ORDER_BIT(byte, 6u, CT_ORDER_BIT(byte, 7u, 0u))))
#define CT_ORDER(byte) \
  CT_ORDER_BIT(byte, 0u, CT_ORDER_BIT(byte, 1u, CT_ORDER_BIT(byte, 2u, CT_ORDER_BIT(byte, 3u, CT_ORDER_HIGH(byte)))))
#define CT_ORDER_4(byte) CT_ORDER(byte), CT_ORDER(byte + 1u), CT_ORDER(byte + 2u), CT_ORDER(byte + 3u)
#define CT_ORDER_16(byte) CT_ORDER_4(byte), CT_ORDER_4(byte + 4u), CT_ORDER_4(byte + 8u), CT_ORDER_4(byte + 12u)
#define CT_ORDER_64(byte) CT_ORDER_16(byte), CT_ORDER_16(byte + 16u), CT_ORDER_16(byte + 32u), CT_ORDER_16(byte + 48u)

static const uint32_t orderOfBits[256] = {CT_ORDER_64(0u), CT_ORDER_64(64u), CT_ORDER_64(128u), CT_ORDER_64(192u)};

static inline void pack8(unsigned mask, __m256 a, int first, float* packed, int* places) {
  const __m256i shifts = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28);
  const __m256i order = _mm256_srlv_epi32(_mm256_set1_epi32((int)orderOfBits[mask]), shifts);
  const __m256i within = _mm256_and_si256(order, _mm256_set1_epi32(7));
  _mm256_storeu_ps(packed, _mm256_permutevar8x32_ps(a, within));
  _mm256_storeu_si256((__m256i*)places, _mm256_add_epi32(within, _mm256_set1_epi32(first)));
}

static inline int pack16(unsigned mask, Float16 a, int first, float* packed, int* places) {
  const int low = __builtin_popcount(mask & 255);
  pack8(mask & 255, a.low, first, packed, places);
  pack8(mask >> 8 & 255, a.high, first + 8, packed + low, places + low);
  return __builtin_popcount(mask);
}

#else

/* Unsigned, so that sums may wrap. */
typedef unsigned Unsigned4 __attribute__((vector_size(16)));

typedef struct Int16 {
  Unsigned4 q[4];
} Int16;

#define CT_EACH_QUARTER for (int i = 0; i < 4; i++)

static inline Int16 allInts(int a) {
  const unsigned u = (unsigned)a;
  const Unsigned4 all = {u, u, u, u};
  return (Int16){{all, all, all, all}};
}

static inline Int16 bitsOf16(Float16 a) {
  return (Int16){{(Unsigned4)a.q[0], (Unsigned4)a.q[1], (Unsigned4)a.q[2], (Unsigned4)a.q[3]}};
}

static inline Float16 floatsOfBits(Int16 a) {
  return (Float16){{(Float4)a.q[0], (Float4)a.q[1], (Float4)a.q[2], (Float4)a.q[3]}};
}

static inline Int16 addInts(Int16 a, Int16 b) {
  CT_EACH_QUARTER a.q[i] += b.q[i];
  return a;
}

static inline Int16 subInts(Int16 a, Int16 b) {
  CT_EACH_QUARTER a.q[i] -= b.q[i];
  return a;
}

static inline Int16 andInts(Int16 a, Int16 b) {
  CT_EACH_QUARTER a.q[i] &= b.q[i];
  return a;
}

static inline Int16 orInts(Int16 a, Int16 b) {
  CT_EACH_QUARTER a.q[i] |= b.q[i];
  return a;
}

static inline Int16 xorInts(Int16 a, Int16 b) {
  CT_EACH_QUARTER a.q[i] ^= b.q[i];
  return a;
}

static inline Int16 shiftLeftInts(Int16 a, int by) {
  CT_EACH_QUARTER a.q[i] <<= by;
  return a;
}

static inline Int16 shiftRightInts(Int16 a, int by) {
  CT_EACH_QUARTER a.q[i] = (Unsigned4)((Int4)a.q[i] >> by);
  return a;
}

static inline Float16 floatsOfInts(Int16 a) {
  Float16 floats;
  CT_EACH_QUARTER floats.q[i] = __builtin_convertvector((Int4)a.q[i], Float4);
  return floats;
}

static inline Int16 intsOf16(Float16 a) {
  Int16 ints;
  CT_EACH_QUARTER ints.q[i] = (Unsigned4) __builtin_convertvector(a.q[i], Int4);
  return ints;
}

static inline Float16 gather16(const float* p, Int16 a) {
  float found[16];
  for (int k = 0; k < 16; k++) {
    found[k] = p[a.q[k / 4][k % 4]];
  }
  return load16(found);
}

static inline Float16 chooseBelow16(Float16 a, Float16 b, Float16 yes, Float16 no) {
  CT_EACH_QUARTER {
    const Int4 chosen = a.q[i] < b.q[i];
    a.q[i] = (Float4)(((Int4)yes.q[i] & chosen) | ((Int4)no.q[i] & ~chosen));
  }
  return a;
}

static inline Float16 chooseEqual16(Float16 a, Float16 b, Float16 yes, Float16 no) {
  CT_EACH_QUARTER {
    const Int4 chosen = a.q[i] == b.q[i];
    a.q[i] = (Float4)(((Int4)yes.q[i] & chosen) | ((Int4)no.q[i] & ~chosen));
  }
  return a;
}

static inline Int16 loadInts(const int* p) {
  Int16 ints;
  memcpy(&ints, p, sizeof ints);
  return ints;
}

static inline Float16 lookup16(const float* p, Int16 indices) {
  float found[16];
  for (int k = 0; k < 16; k++) {
    found[k] = p[indices.q[k / 4][k % 4] & 15];
  }
  return load16(found);
}

static inline int pack16(unsigned mask, Float16 a, int first, float* packed, int* places) {
  float all[16];
  int count = 0;
  store16(all, a);
  /* Without branches, which would be mispredicted. */
  for (int k = 0; k < 16; k++) {
    packed[count] = all[k];
    places[count] = first + k;
    count += (int)(mask >> k & 1);
  }
  return count;
}

#undef CT_EACH_QUARTER

#endif

#endif /* CT_INTS_H_ */
