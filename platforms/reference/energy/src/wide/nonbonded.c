/* Lennard-Jones and Coulomb energies of pairs of leaves. */
#include "rows.h"
#include "set.h"
#include "sums.h"
#include "switching16.h"

/* erf(alpha r) / r: even and odd powers apart, which depend on each other less. */
CT_INLINE Float16 smoothCoulomb(const EwaldPolynomial* polynomial, Float16 squared) {
  const float* c = polynomial->coefficients;
  const Float16 t = sub16(mul16(squared, all16(polynomial->scale)), all16(1));
  const Float16 t2 = mul16(t, t);
  Float16 even = all16(c[polynomial->count - 2]);
  Float16 odd = all16(c[polynomial->count - 1]);
  for (int k = polynomial->count - 4; k >= 0; k -= 2) {
    even = add16(mul16(even, t2), all16(c[k]));
    odd = add16(mul16(odd, t2), all16(c[k + 1]));
  }
  return add16(even, mul16(odd, t));
}

/* The energy of the particles of side a in `rows`, against all of side b, whose centre is at `shift` from a's.
 * Constants for `hasCutoff`, `hasSwitch`, `isEwald` and `isMasked` make a function for each case. */
CT_INLINE double sumRows(const Potential* potential, const LeafSide* a, const LeafSide* b, const float shift[3],
                         unsigned rows, bool hasCutoff, bool hasSwitch, bool isEwald, bool isMasked) {
  const Float16 xb = add16(load16(b->frame->x), all16(shift[0]));
  const Float16 yb = add16(load16(b->frame->y), all16(shift[1]));
  const Float16 zb = add16(load16(b->frame->z), all16(shift[2]));
  const Float16 chargeB = load16(b->columns->charge);
  const Float16 sigmaB = load16(b->columns->sigma);
  const Float16 epsilonB = load16(b->columns->epsilon);
  const Float16 squaredCutoff = all16(potential->squaredCutoff);
  const Float16 one = all16(1);
  Sum16 sum = zeroSum16();
  Float16 tails = all16(0);
  while (rows != 0) {
    Float16 part = all16(0);
    for (int n = 0; n < ROWS_IN_FLOAT && rows != 0; n++, rows &= rows - 1) {
      const int k = __builtin_ctz(rows);
      const Float16 dx = sub16(xb, all16(a->frame->x[k]));
      const Float16 dy = sub16(yb, all16(a->frame->y[k]));
      const Float16 dz = sub16(zb, all16(a->frame->z[k]));
      const Float16 squared = add16(add16(mul16(dx, dx), mul16(dy, dy)), mul16(dz, dz));
      const Float16 distance = sqrt16(squared);
      const Float16 inverse = div16(one, distance);
      const Float16 ratio = mul16(add16(sigmaB, all16(a->columns->sigma[k])), inverse);
      const Float16 ratio2 = mul16(ratio, ratio);
      const Float16 ratio6 = mul16(mul16(ratio2, ratio2), ratio2);
      Float16 lennardJones = mul16(mul16(epsilonB, mul16(ratio6, sub16(ratio6, one))), all16(a->columns->epsilon[k]));
      if (hasSwitch) {
        lennardJones =
            mul16(lennardJones, switchFactor16(distance, potential->switchingDistance, potential->inverseSwitchWidth));
      }
      Float16 coulomb = inverse;
      if (isEwald) {
        coulomb = sub16(inverse, smoothCoulomb(&potential->ewald, squared));
      } else if (hasCutoff) {
        coulomb = sub16(add16(inverse, mul16(all16(potential->k), squared)), all16(potential->c));
      }
      /* Not by the product of the charges: pairs of two types would share its rounding, which adds up. */
      coulomb = mul16(chargeB, mul16(all16(a->columns->charge[k]), coulomb));
      if (hasCutoff) {
        Float16 energy = keepBelow16(squared, squaredCutoff, add16(lennardJones, coulomb));
        if (isMasked) {
          energy = keep16(~(unsigned)a->excluded[k], energy);
        }
        part = add16(part, energy);
      } else {
        /* Apart: far away, Lennard-Jones is less than half of what the last bit of Coulomb is worth, but has one sign.
         * In a slot without a particle both are 0. */
        if (isMasked) {
          lennardJones = keep16(~(unsigned)a->excluded[k], lennardJones);
          coulomb = keep16(~(unsigned)a->excluded[k], coulomb);
        }
        part = add16(part, coulomb);
        tails = add16(tails, lennardJones);
      }
    }
    sum = addToSum16(sum, part);
  }
  if (!hasCutoff) {
    sum = addToSum16(sum, tails);
  }
  return total16(sum);
}

/* Sums the rows of side a by the function for this case. */
CT_INLINE double sumCase(const Potential* potential, const LeafSide* a, const LeafSide* b, const float shift[3],
                         unsigned rows, bool isMasked) {
  if (potential->isEwald) {
    return potential->hasSwitch ? sumRows(potential, a, b, shift, rows, true, true, true, isMasked)
                                : sumRows(potential, a, b, shift, rows, true, false, true, isMasked);
  }
  return potential->hasSwitch   ? sumRows(potential, a, b, shift, rows, true, true, false, isMasked)
         : potential->hasCutoff ? sumRows(potential, a, b, shift, rows, true, false, false, isMasked)
                                : sumRows(potential, a, b, shift, rows, false, false, false, isMasked);
}

double CT_WIDE(leafPairEnergy)(const Potential* potential, const LeafSide* a, const LeafSide* b) {
  float shift[3];
  float back[3];
  shiftBetween(a->frame, b->frame, shift);
  unsigned rows = a->columns->occupied;
  const float* from = shift;
  if (potential->hasCutoff) {
    /* Each row of one side costs the same, so those of the side with fewer are summed. */
    shiftBetween(b->frame, a->frame, back);
    rows &= rowsNear(a->frame, b->frame, shift, potential->squaredCutoff);
    const unsigned rowsOfB = b->columns->occupied & rowsNear(b->frame, a->frame, back, potential->squaredCutoff);
    if (__builtin_popcount(rowsOfB) < __builtin_popcount(rows)) {
      const LeafSide* other = a;
      a = b;
      b = other;
      rows = rowsOfB;
      from = back;
    }
  }
  return a->excluded != NULL ? sumCase(potential, a, b, from, rows, true) : sumCase(potential, a, b, from, rows, false);
}
