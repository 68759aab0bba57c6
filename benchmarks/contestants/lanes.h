/* As many floats at a time as the instruction set has, and what a search for near particles does with them. */
#ifndef LANES_H_
#define LANES_H_

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#if defined(__AVX512F__)

enum { LANES = 16 };
#define LANES_ISA "avx512"
typedef __m512 Lanes;
typedef __m512i IntLanes;

static inline Lanes lanesLoad(const float* x) {
  return _mm512_loadu_ps(x);
}

static inline Lanes lanesOf(float x) {
  return _mm512_set1_ps(x);
}

static inline IntLanes intLanesLoad(const int* x) {
  return _mm512_loadu_si512(x);
}

static inline void intLanesStore(int* x, IntLanes lanes) {
  _mm512_storeu_si512(x, lanes);
}

static inline IntLanes intLanesOf(int x) {
  return _mm512_set1_epi32(x);
}

static inline Lanes squaredDistances(Lanes ax, Lanes ay, Lanes az, Lanes bx, Lanes by, Lanes bz) {
  const Lanes x = _mm512_sub_ps(ax, bx);
  const Lanes y = _mm512_sub_ps(ay, by);
  const Lanes z = _mm512_sub_ps(az, bz);
  return _mm512_fmadd_ps(x, x, _mm512_fmadd_ps(y, y, _mm512_mul_ps(z, z)));
}

static inline Lanes lanesSum(Lanes a, Lanes b) {
  return _mm512_add_ps(a, b);
}

static inline Lanes lanesSquare(Lanes a) {
  return _mm512_mul_ps(a, a);
}

static inline unsigned lanesAtMost(Lanes a, Lanes b) {
  return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}

static inline unsigned intLanesBelow(IntLanes a, IntLanes b) {
  return _mm512_cmplt_epi32_mask(a, b);
}

/* Stores the lanes of a mask one behind the other; compressed in a register, which is many times faster than to memory
 * on some machines. */
static inline void intLanesStoreSome(int* x, unsigned mask, IntLanes lanes) {
  _mm512_storeu_si512(x, _mm512_maskz_compress_epi32((__mmask16)mask, lanes));
}

#elif defined(__AVX2__)

enum { LANES = 8 };
#define LANES_ISA "avx2"
typedef __m256 Lanes;
typedef __m256i IntLanes;

static inline Lanes lanesLoad(const float* x) {
  return _mm256_loadu_ps(x);
}

static inline Lanes lanesOf(float x) {
  return _mm256_set1_ps(x);
}

static inline IntLanes intLanesLoad(const int* x) {
  return _mm256_loadu_si256((const __m256i*)x);
}

static inline void intLanesStore(int* x, IntLanes lanes) {
  _mm256_storeu_si256((__m256i*)x, lanes);
}

static inline IntLanes intLanesOf(int x) {
  return _mm256_set1_epi32(x);
}

static inline Lanes squaredDistances(Lanes ax, Lanes ay, Lanes az, Lanes bx, Lanes by, Lanes bz) {
  const Lanes x = _mm256_sub_ps(ax, bx);
  const Lanes y = _mm256_sub_ps(ay, by);
  const Lanes z = _mm256_sub_ps(az, bz);
  return _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
}

static inline Lanes lanesSum(Lanes a, Lanes b) {
  return _mm256_add_ps(a, b);
}

static inline Lanes lanesSquare(Lanes a) {
  return _mm256_mul_ps(a, a);
}

static inline unsigned lanesAtMost(Lanes a, Lanes b) {
  return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LE_OQ));
}

static inline unsigned intLanesBelow(IntLanes a, IntLanes b) {
  return (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a)));
}

/* The numbers of the lanes of a mask, one behind the other. */
static inline __m256i chosenLanes(unsigned mask) {
  const uint64_t bytes = _pdep_u64(mask, 0x0101010101010101u) * 0xff;
  return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)_pext_u64(0x0706050403020100u, bytes)));
}

static inline void intLanesStoreSome(int* x, unsigned mask, IntLanes lanes) {
  _mm256_storeu_si256((__m256i*)x, _mm256_permutevar8x32_epi32(lanes, chosenLanes(mask)));
}

#else

enum { LANES = 4 };
#define LANES_ISA "portable"

typedef struct Lanes {
  float x[LANES];
} Lanes;

typedef struct IntLanes {
  int x[LANES];
} IntLanes;

static inline Lanes lanesLoad(const float* x) {
  Lanes lanes;
  memcpy(lanes.x, x, sizeof lanes.x);
  return lanes;
}

static inline Lanes lanesOf(float x) {
  return (Lanes){{x, x, x, x}};
}

static inline IntLanes intLanesLoad(const int* x) {
  IntLanes lanes;
  memcpy(lanes.x, x, sizeof lanes.x);
  return lanes;
}

static inline void intLanesStore(int* x, IntLanes lanes) {
  memcpy(x, lanes.x, sizeof lanes.x);
}

static inline IntLanes intLanesOf(int x) {
  return (IntLanes){{x, x, x, x}};
}

static inline Lanes squaredDistances(Lanes ax, Lanes ay, Lanes az, Lanes bx, Lanes by, Lanes bz) {
  Lanes squared;
  for (int k = 0; k < LANES; k++) {
    const float x = ax.x[k] - bx.x[k];
    const float y = ay.x[k] - by.x[k];
    const float z = az.x[k] - bz.x[k];
    squared.x[k] = x * x + y * y + z * z;
  }
  return squared;
}

static inline Lanes lanesSum(Lanes a, Lanes b) {
  for (int k = 0; k < LANES; k++) {
    a.x[k] += b.x[k];
  }
  return a;
}

static inline Lanes lanesSquare(Lanes a) {
  for (int k = 0; k < LANES; k++) {
    a.x[k] *= a.x[k];
  }
  return a;
}

static inline unsigned lanesAtMost(Lanes a, Lanes b) {
  unsigned mask = 0;
  for (int k = 0; k < LANES; k++) {
    mask |= (unsigned)(a.x[k] <= b.x[k]) << k;
  }
  return mask;
}

static inline unsigned intLanesBelow(IntLanes a, IntLanes b) {
  unsigned mask = 0;
  for (int k = 0; k < LANES; k++) {
    mask |= (unsigned)(a.x[k] < b.x[k]) << k;
  }
  return mask;
}

static inline void intLanesStoreSome(int* x, unsigned mask, IntLanes lanes) {
  int count = 0;
  for (int k = 0; k < LANES; k++) {
    x[count] = lanes.x[k];
    count += (int)(mask >> k & 1);
  }
}

#endif

static inline int bitCount(unsigned mask) {
  return __builtin_popcount(mask);
}

/* Of a number that is not 0. */
static inline int lowestBit(unsigned bits) {
  return __builtin_ctz(bits);
}

#endif /* LANES_H_ */
