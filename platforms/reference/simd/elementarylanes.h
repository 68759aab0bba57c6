/* Elementary functions of floats, lane by lane: in double, so that rounding to float is what errs, and in plain C that
 * compilers turn into vectors. No function of the C library: the same bits on each instruction set and machine. */
#ifndef CT_ELEMENTARYLANES_H_
#define CT_ELEMENTARYLANES_H_

#include <stdbool.h>

#include "angle.h"

#define CT_HALF_PI 0x1.921fb54442d18p+0
#define CT_PI 0x1.921fb54442d18p+1

/* c[0] + c[1] x + ... + c[degree] x^degree */
CT_INLINE double polynomialOf(double x, int degree, const double* c) {
  double sum = c[degree];
  for (int i = degree - 1; i >= 0; i--) {
    sum = sum * x + c[i];
  }
  return sum;
}

/* ---- Exponentials ---- */

/* e^x up to e^300 and down to e^-300, beyond the range of floats. */
CT_INLINE double expOf(double x) {
  const double c[] = {1,         1,          1.0 / 2,     1.0 / 6,      1.0 / 24,     1.0 / 120,
                      1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800};
  const double bounded = chosen(x > 300, 300, chosen(x < -300, -300, x));
  const double shifted = bounded * 0x1.71547652b82fep+0 + CT_WHOLE_DOUBLE;
  const double n = shifted - CT_WHOLE_DOUBLE;
  const double r = (bounded - n * 0x1.62e42feep-1) - n * 0x1.a39ef35793c76p-33;
  return polynomialOf(r, 10, c) * doubleOfBits((bitsOfDouble(shifted) + 1023) << 52);
}

/* The natural logarithm of a number > 0 that a float can be. */
CT_INLINE double logOf(double x) {
  const double c[] = {2, 2.0 / 3, 2.0 / 5, 2.0 / 7, 2.0 / 9, 2.0 / 11, 2.0 / 13, 2.0 / 15};
  const uint64_t root = 0x3fe6a09e667f3bcdu; /* the bits of the root of 1/2 */
  const uint64_t above = bitsOfDouble(x) - root;
  const double m = doubleOfBits((above & 0xfffffffffffffu) + root);
  /* The exponent as a double, from its bits; it is above -1024. */
  const double n = doubleOfBits(((above + ((uint64_t)1024 << 52)) >> 52) | 0x4330000000000000u) - (0x1p52 + 1024);
  const double s = (m - 1) / (m + 1);
  return n * 0x1.62e42fefa39efp-1 + s * polynomialOf(s * s, 7, c);
}

/* x^y as C's pow has it. */
CT_INLINE float powLane(float base, float exponent) {
  const double x = (double)base;
  const double y = (double)exponent;
  const double size = sizeOf(x);
  const double positive = chosen((size > 0) & (size < INFINITY), size, 1);
  const double logarithm = chosen(size == 0, -INFINITY, chosen(size == INFINITY, INFINITY, logOf(positive)));
  /* Whole numbers are even from 2^24 on. */
  const double bounded = chosen(y > 0x1p25, 0x1p25, chosen(y < -0x1p25, -0x1p25, y));
  const double half = 0.5 * bounded;
  const bool isWhole = (bounded + CT_WHOLE_DOUBLE) - CT_WHOLE_DOUBLE == bounded;
  const bool isOdd = isWhole & ((half + CT_WHOLE_DOUBLE) - CT_WHOLE_DOUBLE != half);
  const double power = chosen(size == 1, 1, expOf(y * logarithm));
  const double defined = chosen((x < 0) & (x > -INFINITY) & !isWhole, (double)NAN, power);
  const double known = chosen((x != x) | (y != y), (double)NAN, defined);
  const double withSign = chosen(isOdd, withSignOf(known, x), known);
  return (float)chosen((y == 0) | (x == 1), 1, withSign);
}

/* ---- Hyperbolic functions ---- */

/* sinh(x) = x (1 + x^2 / 6 + ...), of small x; exponentials beyond. */
CT_INLINE double sinhOf(double x) {
  const double c[] = {1, 1.0 / 6, 1.0 / 120, 1.0 / 5040, 1.0 / 362880, 1.0 / 39916800, 1.0 / 6227020800};
  const double e = expOf(sizeOf(x));
  const double far = withSignOf(0.5 * (e - 1 / e), x);
  const double near = x * polynomialOf(x * x, 6, c);
  return chosen(x * x < 1, near, far);
}

CT_INLINE double coshOf(double x) {
  const double e = expOf(sizeOf(x));
  return 0.5 * (e + 1 / e);
}

/* ---- Circular functions ---- */

/* Beyond CT_EXACT_ANGLE, in radians, sines and their kind are NaN. */
CT_INLINE Angle angleOfLane(float x) {
  const double angle = (double)x;
  return angleOf(chosen(sizeOf(angle) <= CT_EXACT_ANGLE, angle, (double)NAN));
}

/* atan2(y, x) of C. */
CT_INLINE double angleOfPoint(double y, double x) {
  const double c[] = {0.9999999999887381,    -0.3333333295165722,  0.19999978336217084,  -0.1428522560816021,
                      0.11105306732424464,   -0.09049179093720577, 0.07495262378099696,  -0.06022196387937433,
                      0.04364658944281667,   -0.02600599597760862, 0.011427633277375594, -0.0031954252407363944,
                      0.00041922786011272897};
  const double across = sizeOf(x);
  const double up = sizeOf(y);
  const double most = chosen(up > across, up, across);
  const double least = chosen(up > across, across, up);
  const double ratio = chosen(least == most, chosen(most == 0, 0, 1), least / most);
  const double low = ratio * polynomialOf(ratio * ratio, 12, c);
  const double steep = chosen(up > across, CT_HALF_PI - low, low);
  const double turned = chosen(bitsOfDouble(x) >> 63 != 0, CT_PI - steep, steep);
  return chosen((x != x) | (y != y), (double)NAN, withSignOf(turned, y));
}

/* ---- The error function ---- */

/* erfc(x) of x >= 0. */
CT_INLINE double erfcOfPositive(double x) {
  const double c[] = {0.2820948765418145,   0.28209323077653164,  0.24682934325484396,  0.1766716915659924,
                      0.0789827459636621,   0.029655288981246735, -0.21406077924583536, 0.4435760014414319,
                      -1.0937049574048445,  1.6783581205169948,   -1.501153192639402,   0.7962599667105044,
                      -0.23603582632483058, 0.030433489875911695};
  /* At 11 it is no float any more. */
  const double bounded = chosen(x > 11, 11, x);
  const double t = 2 / (2 + bounded);
  return expOf(-bounded * bounded) * t * polynomialOf(t, 13, c);
}

/* erf(x) of |x| <= 0.75. */
CT_INLINE double erfOfSmall(double x) {
  const double c[] = {1.128379167095507,      -0.37612638903022166,    0.1128379166328238,
                      -0.026866169240359568,  0.0052239647170253785,   -0.0008547658830825731,
                      0.00012034918346604412, -1.4558754662882209e-05, 1.2824644750883275e-06};
  return x * polynomialOf(x * x, 8, c);
}

/* ---- Functions of one lane, and of sixteen ---- */

CT_INLINE float sinhLane(float x) {
  return (float)sinhOf((double)x);
}

CT_INLINE float coshLane(float x) {
  return (float)coshOf((double)x);
}

CT_INLINE float tanhLane(float x) {
  return (float)(sinhOf((double)x) / coshOf((double)x));
}

CT_INLINE float sinLane(float x) {
  return (float)angleOfLane(x).sine;
}

CT_INLINE float cosLane(float x) {
  return (float)angleOfLane(x).cosine;
}

CT_INLINE float tanLane(float x) {
  const Angle angle = angleOfLane(x);
  return (float)(angle.sine / angle.cosine);
}

CT_INLINE float asinLane(float x) {
  const double sine = (double)x;
  return (float)angleOfPoint(sine, sqrt((1 - sine) * (1 + sine)));
}

CT_INLINE float acosLane(float x) {
  const double cosine = (double)x;
  return (float)angleOfPoint(sqrt((1 - cosine) * (1 + cosine)), cosine);
}

CT_INLINE float atanLane(float x) {
  return (float)angleOfPoint((double)x, 1);
}

CT_INLINE float atan2Lane(float y, float x) {
  return (float)angleOfPoint((double)y, (double)x);
}

CT_INLINE float erfLane(float x) {
  const double size = sizeOf((double)x);
  const double far = withSignOf(1 - erfcOfPositive(size), (double)x);
  return (float)chosen(size < 0.75, erfOfSmall((double)x), far);
}

CT_INLINE float erfcLane(float x) {
  const double size = sizeOf((double)x);
  const double tail = erfcOfPositive(size);
  const double far = chosen((double)x < 0, 2 - tail, tail);
  return (float)chosen(size < 0.75, 1 - erfOfSmall((double)x), far);
}

#endif /* CT_ELEMENTARYLANES_H_ */
