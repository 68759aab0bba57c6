/* Born energies of the pairs of two leaves, with Lennard-Jones and Coulomb or without, compiled once for each
 * instruction set as a part of kernels_body.h. */

/* 2^x for x <= 0, with a relative error below 1.5e-7, or of 2^-100. */
CT_INLINE Float16 powerOfTwo(Float16 x) {
  const Float16 bounded = max16(x, all16(-100));
  const Float16 shifted = add16(bounded, all16(CT_WHOLE_MAGIC));
  const Float16 rest = sub16(bounded, sub16(shifted, all16(CT_WHOLE_MAGIC)));
  /* Not one power after another: the processor would wait. */
  const Float16 square = mul16(rest, rest);
  const Float16 low = add16(all16(1.000000072f), mul16(rest, all16(0.6931469671f)));
  const Float16 middle = add16(all16(0.2402211972f), mul16(rest, all16(0.05550713259f)));
  const Float16 high = add16(all16(0.009675541363f), mul16(rest, all16(0.001327647781f)));
  const Float16 power = add16(low, mul16(square, add16(middle, mul16(square, high))));
  return floatsOfBits(addInts(bitsOf16(power), shiftLeftInts(bitsOf16(shifted), 23)));
}

/* Side b of two blocks, from the centre of side a, and what sums have come to. */
typedef struct WholeSums {
  Float16 x, y, z;
  Sum16 nonbonded;
  Sum16 born;
  Float16 tails; /* of Lennard-Jones, still to be multiplied by b's epsilons */
} WholeSums;

/* Operations of one row wait for each other: rows side by side keep the processor busy. */
#define EACH_ROW _Pragma("GCC unroll 4") for (int i = 0; i < count; i++)

/* Adds `count` <= ROWS_IN_FLOAT rows. The charges of side b are multiplied when these are summed: see the same of
 * Coulomb in sumRows. The other arguments are those of sumWholeRows. */
CT_INLINE void addWholeRows(const BornModel* model, const WholeSide* a, const WholeSide* b, const int slots[],
                            int count, WholeSums* sums, bool hasNonbonded, bool hasCutoff, bool hasKappa,
                            bool isMasked) {
  Float16 squared[ROWS_IN_FLOAT];
  Float16 squaredF[ROWS_IN_FLOAT];
  Float16 inverse[ROWS_IN_FLOAT];
  EACH_ROW {
    const int k = slots[i];
    const Float16 dx = sub16(sums->x, all16(a->frame->x[k]));
    const Float16 dy = sub16(sums->y, all16(a->frame->y[k]));
    const Float16 dz = sub16(sums->z, all16(a->frame->z[k]));
    squared[i] = squared16(dx, dy, dz);
  }
  if (hasNonbonded) {
    /* Early, as this takes long but leaves the processor free for Born. Two reciprocals by one division, unless a pair
     * may be of one particle with itself. Where particles coincide, the sum is not finite. */
    if (count == ROWS_IN_FLOAT && !isMasked) {
      for (int i = 0; i < ROWS_IN_FLOAT; i += 2) {
        const Float16 both = div16(all16(1), mul16(squared[i], squared[i + 1]));
        inverse[i] = sqrt16(mul16(both, squared[i + 1]));
        inverse[i + 1] = sqrt16(mul16(both, squared[i]));
      }
    } else {
      EACH_ROW {
        inverse[i] = div16(all16(1), sqrt16(squared[i]));
      }
    }
  }
  EACH_ROW {
    const int k = slots[i];
    const Float16 product = mul16(load16(b->radii->radius), all16(a->radii->radius[k]));
    const Float16 rate = all16(a->radii->inverse[k] * -0.3606737602f); /* -log2(e) / 4 */
    const Float16 decay = powerOfTwo(mul16(squared[i], mul16(load16(b->radii->inverse), rate)));
    squaredF[i] = add16(squared[i], mul16(product, decay));
  }
  Float16 part = all16(0);
  EACH_ROW {
    const int k = slots[i];
    const Float16 inverseF = div16(all16(1), sqrt16(squaredF[i]));
    Float16 energy = mul16(all16(a->born->charge[k]), sub16(inverseF, all16(model->shift)));
    if (hasKappa) {
      const Float16 f = mul16(squaredF[i], inverseF);
      const Float16 screening = powerOfTwo(mul16(f, all16(model->kappa * -1.442695041f))); /* -log2(e) */
      energy = mul16(energy, sub16(all16(model->perDielectrics[0]), mul16(screening, all16(model->perDielectrics[1]))));
    }
    if (isMasked) {
      energy = keep16(a->frame == b->frame ? 0xfffeu << k : 0xffff, energy);
    }
    if (hasCutoff) {
      energy = keepBelow16(squared[i], all16(model->squaredCutoff), energy);
    }
    part = add16(part, energy);
  }
  sums->born = addToSum16(sums->born, mul16(load16(b->born->charge), part));
  if (hasNonbonded) {
    Float16 coulombPart = all16(0);
    EACH_ROW {
      const int k = slots[i];
      const Float16 ratio = mul16(add16(load16(b->columns->sigma), all16(a->columns->sigma[k])), inverse[i]);
      const Float16 ratio2 = mul16(ratio, ratio);
      const Float16 ratio6 = mul16(mul16(ratio2, ratio2), ratio2);
      Float16 lennardJones = mul16(mul16(ratio6, sub16(ratio6, all16(1))), all16(a->columns->epsilon[k]));
      Float16 coulomb = mul16(all16(a->columns->charge[k]), inverse[i]);
      if (isMasked) {
        lennardJones = keep16(~(unsigned)a->excluded[k], lennardJones);
        coulomb = keep16(~(unsigned)a->excluded[k], coulomb);
      }
      sums->tails = add16(sums->tails, lennardJones);
      coulombPart = add16(coulombPart, coulomb);
    }
    sums->nonbonded = addToSum16(sums->nonbonded, mul16(load16(b->columns->charge), coulombPart));
  }
}

/* Constants for the last four arguments make a function for each case. With Lennard-Jones and Coulomb there is no
 * cutoff. `isMasked`: some pairs do not count in these; of one leaf with itself, only pairs of a slot with a higher one
 * count in anything. */
CT_INLINE WholePair sumWholeRows(const BornModel* model, const WholeSide* a, const WholeSide* b, const float shift[3],
                                 unsigned rows, bool hasNonbonded, bool hasCutoff, bool hasKappa, bool isMasked) {
  WholeSums sums = {.x = add16(load16(b->frame->x), all16(shift[0])),
                    .y = add16(load16(b->frame->y), all16(shift[1])),
                    .z = add16(load16(b->frame->z), all16(shift[2])),
                    .nonbonded = zeroSum16(),
                    .born = zeroSum16(),
                    .tails = all16(0)};
  int slots[CT_LEAF_WIDTH];
  const int count = indices16(rows, 0, slots);
  int i = 0;
  for (; i + ROWS_IN_FLOAT <= count; i += ROWS_IN_FLOAT) {
    addWholeRows(model, a, b, slots + i, ROWS_IN_FLOAT, &sums, hasNonbonded, hasCutoff, hasKappa, isMasked);
  }
  for (; i < count; i++) {
    addWholeRows(model, a, b, slots + i, 1, &sums, hasNonbonded, hasCutoff, hasKappa, isMasked);
  }
  const double contrast = hasKappa ? 1 : 1 / model->dielectrics[0] - 1 / model->dielectrics[1];
  const Float16 tails = mul16(load16(b->columns->epsilon), sums.tails);
  return (WholePair){
      .nonbonded = hasNonbonded ? total16(addToSum16(sums.nonbonded, tails)) : 0,
      .born = -contrast * total16(sums.born),
  };
}

static WholePair wholePair(const BornModel* model, const WholeSide* a, const WholeSide* b) {
  float shift[3];
  shiftBetween(a->frame, b->frame, shift);
  const unsigned rows = a->columns->occupied;
  const bool hasKappa = model->kappa > 0;
  if (a->excluded != NULL) {
    return hasKappa ? sumWholeRows(model, a, b, shift, rows, true, false, true, true)
                    : sumWholeRows(model, a, b, shift, rows, true, false, false, true);
  }
  return hasKappa ? sumWholeRows(model, a, b, shift, rows, true, false, true, false)
                  : sumWholeRows(model, a, b, shift, rows, true, false, false, false);
}

static double bornPair(const BornModel* model, const WholeSide* a, const WholeSide* b) {
  float shift[3];
  shiftBetween(a->frame, b->frame, shift);
  const unsigned rows = a->columns->occupied & rowsNear(a->frame, b->frame, shift, model->squaredCutoff);
  return model->kappa > 0 ? sumWholeRows(model, a, b, shift, rows, false, true, true, true).born
                          : sumWholeRows(model, a, b, shift, rows, false, true, false, true).born;
}
