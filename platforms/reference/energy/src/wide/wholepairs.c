/* Whole energies: Born energies of pairs of leaves, with Lennard-Jones and Coulomb or without. */
#include "../wholepair.h"
#include "elementary.h"
#include "rows.h"
#include "set.h"
#include "sums.h"

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

/* Where the pairs of a row are, by x = r^2 / (4 R_i R_j). */
typedef enum WholeRange {
  wholeFar,   /* at WHOLE_FAR or farther: 1 / f is 1 / r within 5e-8 */
  wholeApart, /* at WHOLE_APART or farther: 1 / f is 1 / r less a little */
  wholeNear   /* anywhere */
} WholeRange;

#define WHOLE_FAR 12.0f
#define WHOLE_FAR_ROOT 3.4641016f
#define WHOLE_APART 2.0f

/* What sums have come to. */
typedef struct WholeSums {
  Sum16 nonbonded;
  Sum16 born;
  Float16 tails; /* of Lennard-Jones, still to be multiplied by b's epsilons */
} WholeSums;

/* Operations of one row wait for each other: rows side by side keep the processor busy. */
#define EACH_ROW _Pragma("GCC unroll 4") for (int i = 0; i < count; i++)

/* Up to ROWS_IN_FLOAT particles of side a, and their distances from all of side b. */
typedef struct WholeRows {
  const int* slots;
  WholeRange range;
  Float16 squared[ROWS_IN_FLOAT];
  Float16 inverse[ROWS_IN_FLOAT];
} WholeRows;

/* Inverts distances. Two by one division, as divisions take long. Where particles coincide, nothing is finite. */
CT_INLINE void invertRows(WholeRows* rows, int count) {
  if (count != ROWS_IN_FLOAT) {
    EACH_ROW {
      rows->inverse[i] = div16(all16(1), sqrt16(rows->squared[i]));
    }
    return;
  }
  for (int i = 0; i < ROWS_IN_FLOAT; i += 2) {
    const Float16 both = div16(all16(1), mul16(rows->squared[i], rows->squared[i + 1]));
    rows->inverse[i] = sqrt16(mul16(both, rows->squared[i + 1]));
    rows->inverse[i + 1] = sqrt16(mul16(both, rows->squared[i]));
  }
}

/* Sets all but slots and count. `from`: side b from the centre of side a. */
CT_INLINE void measureRows(const WholeSide* a, const WholeSide* b, const Float16 from[3], int count, bool hasNonbonded,
                           bool areToldApart, bool isMasked, WholeRows* rows) {
  EACH_ROW {
    const int k = rows->slots[i];
    const Float16 dx = sub16(from[0], all16(a->frame->x[k]));
    const Float16 dy = sub16(from[1], all16(a->frame->y[k]));
    const Float16 dz = sub16(from[2], all16(a->frame->z[k]));
    rows->squared[i] = squared16(dx, dy, dz);
    if (isMasked && a->frame == b->frame) {
      /* A particle does not coincide with itself: else all would be computed again. */
      rows->squared[i] = blend16(1u << k, rows->squared[i], all16(1));
    }
  }
  if (hasNonbonded) {
    invertRows(rows, count);
  }
  rows->range = wholeNear;
  if (areToldApart) {
    Float16 least = all16(INFINITY);
    EACH_ROW {
      least = min16(least, mul16(rows->squared[i], all16(a->radii->inverse[rows->slots[i]])));
    }
    least = mul16(least, load16(b->radii->inverse));
    if (greater16(least, all16(4 * WHOLE_APART)) == 0xffff) {
      rows->range = greater16(least, all16(4 * WHOLE_FAR)) == 0xffff ? wholeFar : wholeApart;
    }
  }
}

/* 1 / f of rows that are apart. */
CT_INLINE void approach(const WholeSide* a, const WholeSide* b, const int slots[], int count, const Float16 squared[],
                        const Float16 inverse[], Float16 inverseF[]) {
  /* The fourth root of 1 - r / f = 1 - (1 + exp(-x) / (4 x))^(-1/2): in all within 6e-8. */
  const float c[] = {1.03539319f, -0.752652272f, 0.188662942f, -0.0162621104f};
  Float16 root[ROWS_IN_FLOAT];
  Float16 power[ROWS_IN_FLOAT];
  EACH_ROW {
    root[i] = mul16(load16(b->radii->root), all16(a->radii->root[slots[i]]));
  }
  EACH_ROW {
    root[i] = mul16(mul16(squared[i], inverse[i]), root[i]);
  }
  EACH_ROW {
    root[i] = min16(root[i], all16(WHOLE_FAR_ROOT));
    power[i] = all16(c[3]);
  }
  for (int n = 2; n >= 0; n--) {
    EACH_ROW {
      power[i] = add16(mul16(power[i], root[i]), all16(c[n]));
    }
  }
  for (int n = 0; n < 2; n++) {
    EACH_ROW {
      power[i] = mul16(power[i], power[i]);
    }
  }
  EACH_ROW {
    inverseF[i] = sub16(inverse[i], mul16(inverse[i], power[i]));
  }
}

/* Adds `count` <= ROWS_IN_FLOAT rows. The charges of side b are multiplied when these are summed: see
 * the same of Coulomb in sumRows. The other arguments are those of sumWholeRows. */
CT_INLINE void addWholeRows(const BornModel* model, const WholeSide* a, const WholeSide* b, const WholeRows* rows,
                            int count, WholeSums* sums, WholeRange range, bool hasNonbonded, bool hasCutoff,
                            bool hasKappa, bool isMasked) {
  const int* slots = rows->slots;
  const Float16* squared = rows->squared;
  const Float16* inverse = rows->inverse;
  Float16 inverseF[ROWS_IN_FLOAT];
  if (range == wholeApart) {
    approach(a, b, slots, count, squared, inverse, inverseF);
  } else if (range == wholeNear) {
    EACH_ROW {
      const int k = slots[i];
      const Float16 product = mul16(load16(b->radii->radius), all16(a->radii->radius[k]));
      const Float16 rate = mul16(load16(b->radii->inverse), all16(a->radii->rate[k]));
      const Float16 decay = powerOfTwo(mul16(squared[i], rate));
      inverseF[i] = add16(squared[i], mul16(product, decay));
    }
    EACH_ROW {
      inverseF[i] = div16(all16(1), sqrt16(inverseF[i]));
    }
  }
  Float16 part = all16(0);
  EACH_ROW {
    const int k = slots[i];
    Float16 energy = range == wholeFar ? inverse[i] : inverseF[i];
    if (hasCutoff) {
      energy = sub16(energy, all16(model->shift));
    }
    energy = mul16(all16(a->born->charge[k]), energy);
    if (hasKappa) {
      const Float16 f = div16(all16(1), inverseF[i]);
      const Float16 screening = powerOfTwo(mul16(f, all16(model->kappa * -1.442695041f))); /* -log2(e) */
      energy = mul16(energy, sub16(all16(model->perDielectrics[0]), mul16(screening, all16(model->perDielectrics[1]))));
    }
    if (isMasked) {
      energy = keep16(a->frame == b->frame ? 0xfffeu << k : 0xffff, energy);
    }
    if (hasCutoff) {
      energy = keepBelow16(squared[i], all16(model->squaredCutoff), energy);
    }
    part = i == 0 ? energy : add16(part, energy);
  }
  sums->born = addToSum16(sums->born, mul16(load16(b->born->charge), part));
  if (hasNonbonded) {
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
      part = i == 0 ? coulomb : add16(part, coulomb);
    }
    sums->nonbonded = addToSum16(sums->nonbonded, mul16(load16(b->columns->charge), part));
  }
}

/* Adds the rows of side a in `slots`. Constants for the last four arguments make a function for each case. With
 * Lennard-Jones and Coulomb there is no cutoff. `isMasked`: some pairs do not count in these; of one leaf with itself,
 * only pairs of a slot with a higher one count in anything. */
CT_INLINE void sumWholeRows(const BornModel* model, const WholeSide* a, const WholeSide* b, const float shift[3],
                            const int slots[], int count, WholeSums* sums, bool hasNonbonded, bool hasCutoff,
                            bool hasKappa, bool isMasked) {
  const bool areToldApart = hasNonbonded && !hasKappa;
  const Float16 from[3] = {add16(load16(b->frame->x), all16(shift[0])), add16(load16(b->frame->y), all16(shift[1])),
                           add16(load16(b->frame->z), all16(shift[2]))};
  int i = 0;
  WholeRows next = {.slots = slots};
  sums->tails = all16(0);
  if (count >= ROWS_IN_FLOAT) {
    measureRows(a, b, from, ROWS_IN_FLOAT, hasNonbonded, areToldApart, isMasked, &next);
  }
  for (; i + ROWS_IN_FLOAT <= count; i += ROWS_IN_FLOAT) {
    /* The next distances are inverted while these are used, as that takes long. */
    const WholeRows rows = next;
    if (i + 2 * ROWS_IN_FLOAT <= count) {
      next.slots = rows.slots + ROWS_IN_FLOAT;
      measureRows(a, b, from, ROWS_IN_FLOAT, hasNonbonded, areToldApart, isMasked, &next);
    }
    if (areToldApart && rows.range == wholeFar) {
      addWholeRows(model, a, b, &rows, ROWS_IN_FLOAT, sums, wholeFar, true, false, false, isMasked);
    } else if (areToldApart && rows.range == wholeApart) {
      addWholeRows(model, a, b, &rows, ROWS_IN_FLOAT, sums, wholeApart, true, false, false, isMasked);
    } else {
      addWholeRows(model, a, b, &rows, ROWS_IN_FLOAT, sums, wholeNear, hasNonbonded, hasCutoff, hasKappa, isMasked);
    }
  }
  for (; i < count; i++) {
    next.slots = slots + i;
    measureRows(a, b, from, 1, hasNonbonded, false, isMasked, &next);
    addWholeRows(model, a, b, &next, 1, sums, wholeNear, hasNonbonded, hasCutoff, hasKappa, isMasked);
  }
  if (hasNonbonded) {
    sums->nonbonded = addToSum16(sums->nonbonded, mul16(load16(b->columns->epsilon), sums->tails));
  }
}

CT_INLINE double bornTotal(const BornModel* model, const WholeSums* sums) {
  const double contrast = model->kappa > 0 ? 1 : 1 / model->dielectrics[0] - 1 / model->dielectrics[1];
  return -contrast * total16(sums->born);
}

/* wholePairs for constants of the last two arguments. */
CT_INLINE WholePair sumWholePairs(const BornModel* model, const WholeLeaves* leaves, int leaf, int first, int end,
                                  const uint16_t* excluded, bool hasKappa, bool isMasked) {
  WholeSums sums = {.nonbonded = zeroSum16(), .born = zeroSum16()};
  const WholeSide a = wholeSide(leaves, leaf, excluded);
  int slots[CT_LEAF_WIDTH];
  const int count = indices16(a.columns->occupied, 0, slots);
  for (int other = first; other < end; other++) {
    const WholeSide b = wholeSide(leaves, other, NULL);
    float shift[3];
    shiftBetween(a.frame, b.frame, shift);
    sumWholeRows(model, &a, &b, shift, slots, count, &sums, true, false, hasKappa, isMasked);
  }
  return (WholePair){total16(sums.nonbonded), bornTotal(model, &sums)};
}

WholePair CT_WIDE(wholePairs)(const BornModel* model, const WholeLeaves* leaves, int leaf, int first, int end,
                              const uint16_t* excluded) {
  const bool hasKappa = model->kappa > 0;
  if (excluded != NULL) {
    return hasKappa ? sumWholePairs(model, leaves, leaf, first, end, excluded, true, true)
                    : sumWholePairs(model, leaves, leaf, first, end, excluded, false, true);
  }
  return hasKappa ? sumWholePairs(model, leaves, leaf, first, end, NULL, true, false)
                  : sumWholePairs(model, leaves, leaf, first, end, NULL, false, false);
}

double CT_WIDE(bornPair)(const BornModel* model, const WholeSide* a, const WholeSide* b) {
  WholeSums sums = {.nonbonded = zeroSum16(), .born = zeroSum16()};
  float shift[3];
  int slots[CT_LEAF_WIDTH];
  shiftBetween(a->frame, b->frame, shift);
  const unsigned rows = a->columns->occupied & rowsNear(a->frame, b->frame, shift, model->squaredCutoff);
  const int count = indices16(rows, 0, slots);
  if (model->kappa > 0) {
    sumWholeRows(model, a, b, shift, slots, count, &sums, false, true, true, true);
  } else {
    sumWholeRows(model, a, b, shift, slots, count, &sums, false, true, false, true);
  }
  return bornTotal(model, &sums);
}
