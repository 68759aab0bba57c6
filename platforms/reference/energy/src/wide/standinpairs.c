/* Pair energies of the stand-in. */
#include "set.h"
#include "standinrows.h"
#include "sums.h"

/* How far the particles of a row of pairs are apart: r, and f of generalized Born. */
typedef struct Separation {
  Float16 squared;  /* r^2 */
  Float16 exponent; /* r^2 / (4 B_i B_j), as one of 2 */
  Float16 widening; /* f^2 - r^2 = B_i B_j exp(-r^2 / (4 B_i B_j)) */
  Float16 inverse2; /* 1 / r^2 */
  Float16 inverseF2;
} Separation;

CT_INLINE void widen(const Sixteen* one, const Sixteen* all, Separation* s) {
  s->exponent = mul16(s->squared, mul16(one->decay, all->decay));
  s->widening = mul16(mul16(one->radius, all->radius), powerOfMinus(s->exponent));
}

/* Both reciprocal squares by one division. */
CT_INLINE void invert(Separation* s) {
  const Float16 squaredF = add16(s->squared, s->widening);
  const Float16 both = div16(all16(1), mul16(s->squared, squaredF));
  s->inverse2 = mul16(both, squaredF);
  s->inverseF2 = mul16(both, s->squared);
}

/* What is added up: energies of pairs, or energies with new radii less those with the former radii. */
typedef struct StandInCase {
  bool isExchange; /* without what does not depend on radii */
  bool isMasked;   /* some pairs are excluded */
  bool hasKappa;
} StandInCase;

/* The energies of a row of pairs, and their derivatives by ln B of either in units of STANDIN_GRADIENT. `used`: lanes
 * that count; `direct`: lanes that are not excluded. */
CT_INLINE void pairEnergies(const StandInModel* model, const Sixteen* one, const Sixteen* all, const Separation* s,
                            unsigned used, unsigned direct, StandInCase its, Float16* energy, Float16* gradient) {
  const Float16 inverseF = sqrt16(s->inverseF2);
  const Float16 fade = fadeAt(model, s->squared);
  const Float16 charges = mul16(one->bornCharge, all->bornCharge);
  Float16 born = mul16(charges, inverseF);
  Float16 steepness = born;
  if (its.hasKappa) {
    const Float16 f = mul16(add16(s->squared, s->widening), inverseF);
    const Float16 screening = mul16(powerOfMinus(mul16(all16(model->kappaOfTwo), f)), all16(model->perDielectrics[1]));
    const Float16 perDielectric = sub16(all16(model->perDielectrics[0]), screening);
    steepness = mul16(charges, sub16(mul16(perDielectric, inverseF), mul16(all16(model->kappa), screening)));
    born = mul16(born, perDielectric);
  }
  born = add16(born, mul16(fade, atCutoff(one, all, 0, VALUE_RANK)));
  Float16 sum = sub16(all16(0), born);
  if (!its.isExchange) {
    const Float16 sigma = add16(one->sigma, all->sigma);
    const Float16 ratio2 = mul16(mul16(sigma, sigma), s->inverse2);
    const Float16 ratio6 = mul16(mul16(ratio2, ratio2), ratio2);
    const Float16 epsilon = mul16(one->epsilon, all->epsilon);
    const Float16 lennardJones = mul16(epsilon, mul16(ratio6, sub16(ratio6, all16(1))));
    const Float16 coulomb = mul16(mul16(one->charge, all->charge), sqrt16(s->inverse2));
    Float16 unbound = min16(add16(lennardJones, coulomb), all16(STANDIN_MOST_ENERGY));
    if (its.isMasked) {
      unbound = keep16(direct, unbound);
    }
    sum = sub16(unbound, born);
  }
  const Float16 slope = mul16(fade, atCutoff(one, all, VALUE_RANK, SLOPE_RANK));
  /* d(f^2) / d ln B = widening (1 + r^2 / (4 B_i B_j)). */
  const Float16 ofF = mul16(mul16(s->widening, add16(s->exponent, all16(1.44269504f))), s->inverseF2);
  const Float16 cutoff = all16(model->squaredCutoff);
  *energy = keepBelowAmong16(used, s->squared, cutoff, sum);
  *gradient = keepBelowAmong16(used, s->squared, cutoff, sub16(mul16(ofF, steepness), slope));
}

/* Rows of pairs: some particles of one side, with some of the other. */
typedef struct StandInRows {
  const StandInSide* ones; /* with the new radii, then with the former ones */
  const StandInSide* all;
  float shift[3]; /* from the centre of the former to that of the latter */
  unsigned slots; /* of the ones, as bits */
  unsigned lanes; /* of the others */
  float* ofOnes;  /* gradients */
  float* ofAll;
} StandInRows;

/* The lanes that count in the row of slot k. */
CT_INLINE unsigned lanesOf(const StandInRows* rows, bool isSelf, int k) {
  return isSelf ? 0xfffeu << k : rows->lanes;
}

/* Adds rows, of a leaf with itself with those behind each. Operations of one row wait for each other, so each step is
 * that of all rows. */
CT_INLINE Sum16 addStandInRows(const StandInModel* model, const StandInRows* rows, StandInCase its, Sum16 sum) {
  const int versions = its.isExchange ? 2 : 1;
  const bool isSelf = rows->ones->frame == rows->all->frame;
  const Float16 cutoff = all16(model->squaredCutoff);
  Sixteen all[2];
  Separation separations[2 * CT_LEAF_WIDTH];
  int slots[2 * CT_LEAF_WIDTH];
  int count = 0;
  for (int version = 0; version < versions; version++) {
    all[version] = takeAll(model, &rows->all[version], rows->shift);
  }
  for (unsigned ones = rows->slots; ones != 0; ones &= ones - 1) {
    const int k = __builtin_ctz(ones);
    const Sixteen one = takeOne(rows->ones, k);
    const Float16 squared = squaredDistance(&one, &all[0]);
    for (int version = 0; version < versions; version++) {
      separations[count + version].squared = squared;
      slots[count + version] = k;
    }
    /* A particle near the box of a leaf may be near none in it. Without a branch, which could not be foreseen. */
    count += (greater16(cutoff, squared) & lanesOf(rows, isSelf, k)) != 0 ? versions : 0;
  }
  for (int i = 0; i < count; i++) {
    const Sixteen one = takeOne(&rows->ones[i % versions], slots[i]);
    widen(&one, &all[i % versions], &separations[i]);
  }
  for (int i = 0; i < count; i++) {
    invert(&separations[i]);
  }
  Float16 gradients = load16(rows->ofAll);
  for (int begin = 0; begin < count; begin += ROWS_IN_FLOAT) {
    const int end = begin + ROWS_IN_FLOAT < count ? begin + ROWS_IN_FLOAT : count;
    Float16 part[ROWS_IN_FLOAT] = {all16(0), all16(0), all16(0), all16(0)};
    Float16 energies = all16(0);
    for (int i = begin; i < end; i++) {
      const int k = slots[i];
      const int version = i % versions;
      const Sixteen one = takeOne(&rows->ones[version], k);
      const unsigned direct = its.isMasked ? ~(unsigned)rows->ones->excluded[k] : 0;
      Float16 energy;
      Float16 gradient;
      pairEnergies(model, &one, &all[version], &separations[i], lanesOf(rows, isSelf, k), direct, its, &energy,
                   &gradient);
      if (version == 1) {
        energy = sub16(all16(0), energy);
        gradient = sub16(all16(0), gradient);
      }
      energies = add16(energies, energy);
      gradients = add16(gradients, gradient);
      part[i - begin] = gradient;
    }
    sum = addToSum16(sum, energies);
    float totals[ROWS_IN_FLOAT];
    total4x16(part, totals);
    for (int i = begin; i < end; i++) {
      rows->ofOnes[slots[i]] += totals[i - begin];
    }
  }
  store16(rows->ofAll, gradients);
  return sum;
}

/* The same by the function for the case. */
CT_INLINE Sum16 addStandInCase(const StandInModel* model, const StandInRows* rows, bool isExchange, Sum16 sum) {
  if (rows->slots == 0) {
    return sum;
  }
  if (rows->ones->excluded != NULL) {
    return model->hasKappa ? addStandInRows(model, rows, (StandInCase){isExchange, true, true}, sum)
                           : addStandInRows(model, rows, (StandInCase){isExchange, true, false}, sum);
  }
  return model->hasKappa ? addStandInRows(model, rows, (StandInCase){isExchange, false, true}, sum)
                         : addStandInRows(model, rows, (StandInCase){isExchange, false, false}, sum);
}

void CT_WIDE(nearRows)(const StandInModel* model, const LeafFrame* a, const LeafFrame* b, NearRows* rows) {
  const Float16 pairs = all16(model->squaredCutoff * ROUNDING_OF_BOXES);
  const Float16 born = all16(model->squaredBornCutoff * ROUNDING_OF_BOXES);
  const Float16 overlap = all16(model->squaredOverlap * ROUNDING_OF_BOXES);
  const LeafFrame* frames[2] = {a, b};
  for (int side = 0; side < 2; side++) {
    float shift[3];
    shiftBetween(frames[side], frames[1 - side], shift);
    /* Slots without a particle are far from any box. */
    const Float16 squared = squaredFromBox(frames[side], frames[1 - side], shift);
    rows->pairs[side] = (uint16_t)~greater16(squared, pairs);
    rows->born[side] = (uint16_t)~greater16(squared, born);
    rows->overlaps[side] = (uint16_t)~greater16(squared, overlap);
  }
}

/* From some of the particles of one leaf to some of the other. Written in place: a copy would wait for the stores. */
CT_INLINE void setRows(const StandInSide ones[], const StandInSide all[], unsigned slots, unsigned lanes,
                       float ofOnes[], float ofAll[], StandInRows* rows) {
  rows->ones = ones;
  rows->all = all;
  rows->slots = slots;
  rows->lanes = lanes;
  rows->ofOnes = ofOnes;
  rows->ofAll = ofAll;
  shiftBetween(ones->frame, all->frame, rows->shift);
}

double CT_WIDE(standInPairs)(const StandInModel* model, const StandInSide* a, const StandInSide* b,
                             const NearRows* near, float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  /* By the side with fewer particles near the other. */
  const bool isOfA = __builtin_popcount(near->pairs[0]) <= __builtin_popcount(near->pairs[1]);
  StandInRows rows;
  if (isOfA) {
    setRows(a, b, near->pairs[0], 0xffff, gradientA, gradientB, &rows);
  } else {
    setRows(b, a, near->pairs[1], 0xffff, gradientB, gradientA, &rows);
  }
  return total16(addStandInCase(model, &rows, false, zeroSum16()));
}

double CT_WIDE(standInExchange)(const StandInModel* model, const StandInSide a[2], const StandInSide b[2],
                                const NearRows* near, unsigned slotsOfA, unsigned slotsOfB,
                                float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  StandInRows rows[2];
  setRows(a, b, slotsOfA & near->pairs[0], 0xffff, gradientA, gradientB, &rows[0]);
  setRows(b, a, slotsOfB & near->pairs[1], ~slotsOfA, gradientB, gradientA, &rows[1]);
  Sum16 sum = zeroSum16();
  for (int i = 0; i < 2; i++) {
    sum = addStandInCase(model, &rows[i], true, sum);
  }
  return total16(sum);
}
