/* Choices by the bits of doubles, since compilers make no vectors of branches. */
#ifndef CT_DOUBLE_BITS_H_
#define CT_DOUBLE_BITS_H_

#include <stdint.h>

#include "inline.h"

/* Added to a number below 2^51, it leaves the nearest whole one in the low bits. */
#define CT_WHOLE_DOUBLE 0x1.8p52

CT_INLINE uint64_t bitsOfDouble(double x) {
  uint64_t bits;
  __builtin_memcpy(&bits, &x, sizeof bits);
  return bits;
}

CT_INLINE double doubleOfBits(uint64_t bits) {
  double x;
  __builtin_memcpy(&x, &bits, sizeof x);
  return x;
}

CT_INLINE double withSignOf(double magnitude, double sign) {
  const uint64_t bit = (uint64_t)1 << 63;
  return doubleOfBits((bitsOfDouble(magnitude) & ~bit) | (bitsOfDouble(sign) & bit));
}

CT_INLINE double chosen(uint64_t condition, double yes, double no) {
  const uint64_t mask = (uint64_t)0 - (uint64_t)(condition != 0);
  return doubleOfBits((bitsOfDouble(yes) & mask) | (bitsOfDouble(no) & ~mask));
}

CT_INLINE double sizeOf(double x) {
  return doubleOfBits(bitsOfDouble(x) & ~((uint64_t)1 << 63));
}

#endif /* CT_DOUBLE_BITS_H_ */
