/* What pairs of the stand-in are computed from: particles of a leaf, and functions of distances. */
#ifndef CT_STANDINROWS_H_
#define CT_STANDINROWS_H_

#include "../standinpair.h"
#include "elementary.h"
#include "rows.h"

/* Particles that coincide have a distance, too. */
#define STANDIN_LEAST_SQUARED 1e-6f /* nm^2 */

/* What is known of sixteen particles, or sixteen times of one of them. */
typedef struct Sixteen {
  Float16 x, y, z;
  Float16 charge, sigma, epsilon;
  Float16 bornCharge, radius, decay;
  Float16 shift[SHIFT_RANK];
} Sixteen;

/* All particles of a leaf, from the centre of another, with all factors of products that are the same for all pairs. */
CT_INLINE Sixteen takeAll(const StandInModel* model, const StandInSide* side, const float shift[3]) {
  Sixteen all = {add16(load16(side->frame->x), all16(shift[0])),
                 add16(load16(side->frame->y), all16(shift[1])),
                 add16(load16(side->frame->z), all16(shift[2])),
                 load16(side->columns->charge),
                 load16(side->columns->sigma),
                 load16(side->columns->epsilon),
                 load16(side->charge),
                 load16(side->radii->radius),
                 load16(side->radii->decay),
                 {all16(0)}};
  if (!model->hasKappa) {
    all.bornCharge = mul16(all.bornCharge, all16(model->perDielectrics[0] - model->perDielectrics[1]));
  }
  for (int i = 0; i < SHIFT_RANK; i++) {
    all.shift[i] = mul16(all16(model->shiftSign[i]), load16(side->shift->value[i]));
  }
  return all;
}

CT_INLINE Sixteen takeOne(const StandInSide* side, int k) {
  Sixteen one = {all16(side->frame->x[k]),       all16(side->frame->y[k]),
                 all16(side->frame->z[k]),       all16(side->columns->charge[k]),
                 all16(side->columns->sigma[k]), all16(side->columns->epsilon[k]),
                 all16(side->charge[k]),         all16(side->radii->radius[k]),
                 all16(side->radii->decay[k]),   {all16(0)}};
  for (int i = 0; i < SHIFT_RANK; i++) {
    one.shift[i] = all16(side->shift->value[i][k]);
  }
  return one;
}

/* The value at the cutoff (rank VALUE_RANK from the first on), or its derivative (SLOPE_RANK behind these). */
CT_INLINE Float16 atCutoff(const Sixteen* one, const Sixteen* all, int first, int rank) {
  Float16 sum = mul16(one->shift[first], all->shift[first]);
  for (int i = first + 1; i < first + rank; i++) {
    sum = add16(sum, mul16(one->shift[i], all->shift[i]));
  }
  return sum;
}

/* STANDIN_FADE at this squared distance. */
CT_INLINE Float16 fadeAt(const StandInModel* model, Float16 squared) {
  return mul16(mul16(squared, squared), polynomial16(squared, FADE_TERMS - 1, model->fade));
}

/* 2^-x for x >= 0, by STANDIN_POWER. */
CT_INLINE Float16 powerOfMinus(Float16 x) {
  const float c[] = STANDIN_POWER;
  const Float16 magic = all16(CT_WHOLE_MAGIC);
  const Float16 bounded = min16(x, all16(100));
  const Float16 shifted = sub16(magic, bounded);
  const Float16 rest = add16(bounded, sub16(shifted, magic));
  const Int16 exponent = shiftLeftInts(bitsOf16(shifted), 23); /* the magic's bits are shifted out */
  return floatsOfBits(addInts(bitsOf16(polynomial16(rest, 3, c)), exponent));
}

CT_INLINE Float16 squaredDistance(const Sixteen* one, const Sixteen* all) {
  const Float16 dx = sub16(all->x, one->x);
  const Float16 dy = sub16(all->y, one->y);
  const Float16 dz = sub16(all->z, one->z);
  return max16(squared16(dx, dy, dz), all16(STANDIN_LEAST_SQUARED));
}

#endif /* CT_STANDINROWS_H_ */
