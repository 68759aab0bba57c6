/* Elementary functions of sixteen floats, without the C library: the same bits on each instruction set of simd.h and on
 * each machine. What C's functions say about infinite numbers, NaN and numbers outside of a function's range holds for
 * these, too. Errors are in units in the last place of the float. */
#ifndef CT_ELEMENTARY_H_
#define CT_ELEMENTARY_H_

#include "elementarylanes.h"
#include "ints.h"

/* The nearest whole number where |a| < 2^22; its low bits hold the number, too. */
#define CT_WHOLE_MAGIC 12582912.0f

/* c[0] + c[1] x + ... + c[degree] x^degree */
CT_INLINE Float16 polynomial16(Float16 x, int degree, const float* c) {
  Float16 sum = all16(c[degree]);
  for (int i = degree - 1; i >= 0; i--) {
    sum = add16(mul16(sum, x), all16(c[i]));
  }
  return sum;
}

/* 2^n for ints -126 <= n <= 127. */
CT_INLINE Float16 twoToInts(Int16 n) {
  return floatsOfBits(shiftLeftInts(addInts(n, allInts(127)), 23));
}

/* log(2) in two parts: whole numbers below 2^15 times the first are exact. */
#define CT_LOG2_HIGH 0.693359375f
#define CT_LOG2_LOW (-2.12194440e-4f)

/* e^x, error below 1. */
CT_INLINE Float16 exp16(Float16 x) {
  const float c[] = {5.0000001201e-1f, 1.6666665459e-1f, 4.1665795894e-2f,
                     8.3334519073e-3f, 1.3981999507e-3f, 1.9875691500e-4f};
  /* Beyond these the result is 0 or infinite; subnormal numbers on the way to 0 would take long. NaN passes. */
  const Float16 least = all16(-104);
  const Float16 bounded = chooseBelow16(x, least, all16(0), min16(all16(89), x));
  const Float16 shifted = add16(mul16(bounded, all16(1.44269504f)), all16(CT_WHOLE_MAGIC));
  const Float16 n = sub16(shifted, all16(CT_WHOLE_MAGIC));
  const Float16 r = sub16(sub16(bounded, mul16(n, all16(CT_LOG2_HIGH))), mul16(n, all16(CT_LOG2_LOW)));
  const Float16 curve = mul16(mul16(r, r), polynomial16(r, 5, c));
  const Float16 power = add16(add16(curve, r), all16(1));
  /* In two steps, as 2^n may be no normal float. */
  const Int16 whole = subInts(bitsOf16(shifted), bitsOf16(all16(CT_WHOLE_MAGIC)));
  const Int16 half = shiftRightInts(whole, 1);
  const Float16 result = mul16(mul16(power, twoToInts(half)), twoToInts(subInts(whole, half)));
  return chooseBelow16(x, least, all16(0), result);
}

/* The natural logarithm, error below 1. */
CT_INLINE Float16 log16(Float16 x) {
  const float c[] = {3.3333331174e-1f,  -2.4999993993e-1f, 2.0000714765e-1f,  -1.6668057665e-1f, 1.4249322787e-1f,
                     -1.2420140846e-1f, 1.1676998740e-1f,  -1.1514610310e-1f, 7.0376836292e-2f};
  const Float16 least = all16(0x1p-126f);
  const Float16 normal = chooseBelow16(x, least, mul16(x, all16(0x1p23f)), x);
  /* x = 2^n (1 + f) with 1 + f from the root of 1/2 to that of 2. */
  const Int16 bits = subInts(bitsOf16(normal), bitsOf16(all16(0x1.6a09e6p-1f)));
  const Int16 fraction = andInts(bits, allInts(0x7fffff));
  const Float16 f = sub16(floatsOfBits(addInts(fraction, bitsOf16(all16(0x1.6a09e6p-1f)))), all16(1));
  const Float16 n = sub16(floatsOfInts(shiftRightInts(bits, 23)), chooseBelow16(x, least, all16(23), all16(0)));
  const Float16 square = mul16(f, f);
  Float16 low = mul16(mul16(f, square), polynomial16(f, 8, c));
  low = add16(low, mul16(n, all16(CT_LOG2_LOW)));
  low = sub16(low, mul16(square, all16(0.5f)));
  const Float16 result = add16(add16(f, low), mul16(n, all16(CT_LOG2_HIGH)));
  /* What is infinite or NaN stays so; 0 and below it have no logarithm. */
  const Float16 finite = chooseBelow16(x, all16(INFINITY), result, x);
  const Float16 positive = chooseBelow16(x, all16(0), all16(NAN), finite);
  return chooseEqual16(x, all16(0), all16(-INFINITY), positive);
}

/* 1 / sqrt(x) of normal numbers up to 2^125, error below 1.3; below them infinite. A root and a division take longer.
 */
CT_INLINE Float16 inverseRoot16(Float16 x) {
  const Float16 rough = floatsOfBits(subInts(allInts(0x5f1ffff9), shiftRightInts(bitsOf16(x), 1)));
  const Float16 rest = sub16(all16(2.38924456f), mul16(x, mul16(rough, rough)));
  const Float16 y = mul16(mul16(rough, all16(0.703952253f)), rest);
  /* y (1 - h)^(-1/2), as a series: h is below 0.0014. */
  const Float16 h = sub16(all16(1), mul16(x, mul16(y, y)));
  const Float16 curve = mul16(h, add16(all16(0.5f), mul16(all16(0.375f), h)));
  return chooseBelow16(x, all16(0x1p-126f), all16(INFINITY), add16(y, mul16(y, curve)));
}

/* ---- Rounding ---- */

#define CT_SIGNS16 allInts((int)0x80000000u)

/* The nearest whole number below 2^23, with the sign of x. */
CT_INLINE Float16 nearest16(Float16 x) {
  const Float16 size = absolute16(x);
  const Float16 whole = sub16(add16(size, all16(0x1p23f)), all16(0x1p23f));
  const Float16 nearest = chooseBelow16(size, all16(0x1p23f), whole, size);
  return floatsOfBits(orInts(bitsOf16(nearest), andInts(bitsOf16(x), CT_SIGNS16)));
}

CT_INLINE Float16 floor16(Float16 x) {
  const Float16 nearest = nearest16(x);
  const Float16 below = sub16(nearest, chooseBelow16(x, nearest, all16(1), all16(0)));
  return floatsOfBits(orInts(bitsOf16(below), andInts(bitsOf16(x), CT_SIGNS16)));
}

CT_INLINE Float16 ceil16(Float16 x) {
  const Float16 nearest = nearest16(x);
  const Float16 above = add16(nearest, chooseBelow16(nearest, x, all16(1), all16(0)));
  return floatsOfBits(orInts(bitsOf16(above), andInts(bitsOf16(x), CT_SIGNS16)));
}

/* ---- Lane by lane, error below 0.51 ---- */

#define CT_DEFINE_OF_ONE(name)            \
  CT_INLINE Float16 name##16(Float16 x) { \
    float lanes[16];                      \
    store16(lanes, x);                    \
    for (int k = 0; k < 16; k++) {        \
      lanes[k] = name##Lane(lanes[k]);    \
    }                                     \
    return load16(lanes);                 \
  }

#define CT_DEFINE_OF_TWO(name)                       \
  CT_INLINE Float16 name##16(Float16 x, Float16 y) { \
    float lanes[16];                                 \
    float others[16];                                \
    store16(lanes, x);                               \
    store16(others, y);                              \
    for (int k = 0; k < 16; k++) {                   \
      lanes[k] = name##Lane(lanes[k], others[k]);    \
    }                                                \
    return load16(lanes);                            \
  }

/* Of angles up to CT_EXACT_ANGLE; beyond, NaN. */
CT_DEFINE_OF_ONE(sin)
CT_DEFINE_OF_ONE(cos)
CT_DEFINE_OF_ONE(tan)

CT_DEFINE_OF_ONE(asin)
CT_DEFINE_OF_ONE(acos)
CT_DEFINE_OF_ONE(atan)
CT_DEFINE_OF_TWO(atan2)
CT_DEFINE_OF_ONE(sinh)
CT_DEFINE_OF_ONE(cosh)
CT_DEFINE_OF_ONE(tanh)
CT_DEFINE_OF_ONE(erf)
CT_DEFINE_OF_ONE(erfc)
CT_DEFINE_OF_TWO(pow)

#endif /* CT_ELEMENTARY_H_ */
