/* What two particles contribute to each other's Born sums. */
#ifndef CT_BORNPAIR_H_
#define CT_BORNPAIR_H_

#include "../born.h"
#include "elementary.h"
#include "rows.h"

/* Farther apart (nm), particles count as if they were here: that is less than a step. Nearer, as if they were there. */
#define FARTHEST 1e3f
#define NEAREST 1e-6f

/* log(U / L) where it is large: n log 2 is split off. */
static Float16 steepLogarithm(Float16 upper, Float16 lower, Float16 apart) {
  Float16 rest = apart;
  Float16 whole = all16(0);
  for (;;) {
    const Float16 twice = add16(lower, lower);
    const unsigned isAbove = greater16(upper, twice);
    if (isAbove == 0) {
      break;
    }
    lower = blend16(isAbove, lower, twice);
    rest = blend16(isAbove, rest, sub16(upper, twice));
    whole = blend16(isAbove, whole, add16(whole, all16(0.69314718056f)));
  }
  const float c[] = {2, 2.0f / 3, 2.0f / 5, 2.0f / 7, 2.0f / 9, 2.0f / 11, 2.0f / 13};
  const Float16 z = div16(rest, add16(upper, lower));
  return add16(whole, mul16(z, polynomial16(mul16(z, z), 6, c)));
}

/* v(r; o, s) for any spheres, from |s|: where r + s >= o, v is odd in s. With U - L without cancellation. */
CT_INLINE Float16 overlapOf(Float16 r, Float16 inverse, Float16 o, Float16 s) {
  const Float16 zero = all16(0);
  const Float16 one = all16(1);
  const Float16 size = absolute16(s);
  const Float16 between = sub16(r, size);
  const Float16 upper = add16(r, size);
  const Float16 lower = max16(o, absolute16(between));
  const Float16 least = min16(r, size);
  const Float16 apart = min16(sub16(upper, o), add16(least, least));
  const Float16 sum = add16(upper, lower);
  const Float16 product = mul16(upper, lower);
  const Float16 both = div16(one, mul16(product, sum));
  const Float16 inverseProduct = mul16(both, sum);
  const Float16 z = mul16(mul16(apart, product), both);
  const Float16 t = mul16(z, z);
  /* 2 atanh(z), with a relative error below 1.2e-7. */
  const float c[] = {2.00000022f,   0.6666177442f, 0.4017645139f, 0.2621872286f,
                     0.3678231658f, -0.257447722f, 0.7282185339f};
  Float16 logarithm = mul16(z, polynomial16(t, 6, c));
  const unsigned isSteep = greater16(t, all16(0.4225f));
  if (__builtin_expect(isSteep != 0, 0)) {
    logarithm = blend16(isSteep, logarithm, steepLogarithm(upper, lower, apart));
  }
  const Float16 ratio = mul16(mul16(upper, upper), inverseProduct);
  const Float16 quarter = mul16(mul16(all16(0.25f), mul16(between, inverse)), add16(one, ratio));
  const Float16 shells = mul16(mul16(apart, inverseProduct), sub16(one, quarter));
  const Float16 value = mul16(all16(0.5f), sub16(shells, mul16(mul16(all16(0.5f), inverse), logarithm)));
  const Float16 odd = blend16(greater16(zero, s), value, sub16(zero, value));
  return blend16(greater16(o, add16(r, s)), odd, zero);
}

/* What v has more where a sphere within another is filled. */
CT_INLINE Float16 fillingOf(Float16 r, Float16 o, Float16 s) {
  const Float16 lower = sub16(s, r);
  const Float16 filling = sub16(div16(all16(1), o), div16(all16(1), lower));
  return blend16(greater16(lower, o), all16(0), filling);
}

/* The denominator of a neck. */
CT_INLINE Float16 neckWidth(Float16 r, Float16 distance) {
  const Float16 from = sub16(r, distance);
  const Float16 q = mul16(from, from);
  return add16(all16(1), mul16(q, add16(all16(100), mul16(all16(0.3e6f), mul16(q, q)))));
}

/* The two leaves of a sum, and where the particles of b are from the centre of a. */
typedef struct BornSides {
  const BornSide* a;
  const BornSide* b;
  Float16 x;
  Float16 y;
  Float16 z;
} BornSides;

/* Squared distances of particle k of side a from the particles of side b. */
CT_INLINE Float16 squaredFrom(const BornSides* sides, int k) {
  const LeafFrame* frame = sides->a->frame;
  const Float16 dx = sub16(sides->x, all16(frame->x[k]));
  const Float16 dy = sub16(sides->y, all16(frame->y[k]));
  const Float16 dz = sub16(sides->z, all16(frame->z[k]));
  return squared16(dx, dy, dz);
}

/* Multiples of BORN_SUM_STEP. */
CT_INLINE Float16 toSteps(Float16 a) {
  /* The last bit of a float that is not below this one is worth a step or more. */
  const Float16 large = all16((float)((1 << 23) * BORN_SUM_STEP));
  const Float16 size = sub16(add16(absolute16(a), large), large);
  return blend16(greater16(all16(0), a), size, sub16(all16(0), size));
}

#endif /* CT_BORNPAIR_H_ */
