/* Sines and cosines of doubles, without the C library's: these differ in bits from one processor to another. */
#ifndef CT_ANGLE_H_
#define CT_ANGLE_H_

#include <math.h>

#include "doublebits.h"

/* Beyond this, in radians, quarter turns are not told apart exactly. */
#define CT_EXACT_ANGLE 0x1p20

typedef struct Angle {
  double sine;
  double cosine;
} Angle;

/* Of |r| up to an eighth of a turn. Coefficients and forms of Sun's fdlibm, but by halves, which takes less time than
 * one term after the other. */
CT_INLINE Angle smallAngle(double r) {
  const double z = r * r;
  const double z2 = z * z;
  const double s = (-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) +
                   z2 * ((-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06) +
                         z2 * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10));
  const double c = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
                   z2 * ((2.48015872894767294178e-05 + z * -2.75573143513906633035e-07) +
                         z2 * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
  const double near = 1 - 0.5 * z;
  return (Angle){withSignOf(r + (r * z) * s, r), near + (((1 - near) - 0.5 * z) + z2 * c)};
}

/* Of |x| <= CT_EXACT_ANGLE: from the nearest quarter turn. Errors are below 1.6 units in the last place, or 1e-20. NaN
 * passes. Plain C that compilers turn into vectors. */
CT_INLINE Angle angleOf(double x) {
  const double shifted = x * 0x1.45f306dc9c883p-1 + CT_WHOLE_DOUBLE;
  const double n = shifted - CT_WHOLE_DOUBLE;
  /* The first part of a quarter turn has 33 bits. */
  const Angle small = smallAngle((x - n * 0x1.921fb544p+0) - n * 0x1.0b4611a626331p-34);
  const uint64_t quarters = bitsOfDouble(shifted);
  const uint64_t sine = bitsOfDouble(small.sine);
  const uint64_t cosine = bitsOfDouble(small.cosine);
  const uint64_t swap = (sine ^ cosine) & (0 - (quarters & 1));
  return (Angle){doubleOfBits(sine ^ swap ^ (quarters & 2) << 62),
                 doubleOfBits(cosine ^ swap ^ ((quarters + 1) & 2) << 62)};
}

/* An angle that is no more than CT_EXACT_ANGLE, less whole turns: from -pi to pi, but for roundings. */
static inline double withoutTurns(double x) {
  const double n = (x * 0x1.45f306dc9c883p-3 + CT_WHOLE_DOUBLE) - CT_WHOLE_DOUBLE;
  return (x - n * 0x1.921fb544p+2) - n * 0x1.0b4611a626331p-32;
}

/* angleOf of any angle: where it is small, the same bits without a detour. Those of angles above CT_EXACT_ANGLE are
 * left to the C library. */
static inline Angle angleOfAny(double x) {
  const double size = fabs(x);
  return size <= 0.78 ? smallAngle(x) : size <= CT_EXACT_ANGLE ? angleOf(x) : (Angle){sin(x), cos(x)};
}

#endif /* CT_ANGLE_H_ */
