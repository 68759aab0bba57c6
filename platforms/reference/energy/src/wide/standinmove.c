/* What displaced particles change of the pair energies of the stand-in: their rows in the trial and before it, with the
 * radii of the state. */
#include "set.h"
#include "standinrows.h"
#include "sums.h"

/* Rows of displaced particles of one leaf, with another in the trial and before it. */
typedef struct MovedRows {
  const StandInSide* ones;
  const StandInSide* all;
  unsigned slots; /* of the ones, as bits */
  unsigned lanes; /* of the others */
  float* ofOnes;  /* gradients */
  float* ofAll;
} MovedRows;

/* A row: one particle with all of the other leaf, in the trial and before it. */
typedef struct MovedRow {
  int slot;
  Float16 squared[2];
} MovedRow;

/* What a pair of particles has at any distance. */
typedef struct PairConstants {
  Float16 charge, squaredSigma, epsilon;
  Float16 bornCharge, radii, decay;
  Float16 value, slope; /* at the cutoff */
} PairConstants;

CT_INLINE PairConstants constantsOf(const Sixteen* one, const Sixteen* all) {
  const Float16 sigma = add16(one->sigma, all->sigma);
  return (PairConstants){mul16(one->charge, all->charge),   mul16(sigma, sigma),
                         mul16(one->epsilon, all->epsilon), mul16(one->bornCharge, all->bornCharge),
                         mul16(one->radius, all->radius),   mul16(one->decay, all->decay),
                         atCutoff(one, all, 0, VALUE_RANK), atCutoff(one, all, VALUE_RANK, SLOPE_RANK)};
}

/* The energies of pairs at these distances, and their derivatives by ln B of either in units of STANDIN_GRADIENT; as in
 * standinpairs.c, but for inverse roots in place of a division and roots, which take longer. `direct`: lanes that are
 * not excluded. */
CT_INLINE void energiesAt(const StandInModel* model, const PairConstants* c, Float16 squared, unsigned direct,
                          bool hasKappa, Float16* energy, Float16* gradient) {
  const Float16 exponent = mul16(squared, c->decay);
  const Float16 widening = mul16(c->radii, powerOfMinus(exponent));
  const Float16 squaredF = add16(squared, widening);
  const Float16 inverse = inverseRoot16(squared);
  const Float16 inverseF = inverseRoot16(squaredF);
  const Float16 fade = fadeAt(model, squared);
  Float16 born = mul16(c->bornCharge, inverseF);
  Float16 steepness = born;
  if (hasKappa) {
    const Float16 f = mul16(squaredF, inverseF);
    const Float16 screening = mul16(powerOfMinus(mul16(all16(model->kappaOfTwo), f)), all16(model->perDielectrics[1]));
    const Float16 perDielectric = sub16(all16(model->perDielectrics[0]), screening);
    steepness = mul16(c->bornCharge, sub16(mul16(perDielectric, inverseF), mul16(all16(model->kappa), screening)));
    born = mul16(born, perDielectric);
  }
  born = add16(born, mul16(fade, c->value));
  const Float16 ratio2 = mul16(c->squaredSigma, mul16(inverse, inverse));
  const Float16 ratio6 = mul16(mul16(ratio2, ratio2), ratio2);
  const Float16 lennardJones = mul16(c->epsilon, mul16(ratio6, sub16(ratio6, all16(1))));
  const Float16 unbound = min16(add16(lennardJones, mul16(c->charge, inverse)), all16(STANDIN_MOST_ENERGY));
  *energy = sub16(keep16(direct, unbound), born);
  const Float16 ofF = mul16(mul16(widening, add16(exponent, all16(1.44269504f))), mul16(inverseF, inverseF));
  *gradient = sub16(mul16(ofF, steepness), mul16(fade, c->slope));
}

/* The lanes that count in the row of slot k. Of a leaf with itself: lanes that are not displaced, or behind k. */
CT_INLINE unsigned movedLanes(const MovedRows* rows, int k) {
  const bool isSelf = rows->ones->frame == rows->all->frame;
  return isSelf ? 0xfffeu << k | ~rows->slots : rows->lanes;
}

/* Finds the rows within the cutoff; returns how many there are. */
CT_INLINE int findMovedRows(const StandInModel* model, const MovedRows* rows, const Sixteen all[2],
                            MovedRow found[CT_LEAF_WIDTH]) {
  int count = 0;
  for (unsigned slots = rows->slots; slots != 0; slots &= slots - 1) {
    const int k = __builtin_ctz(slots);
    MovedRow* row = &found[count];
    row->slot = k;
    for (int version = 0; version < 2; version++) {
      const Sixteen one = takeOne(&rows->ones[version], k);
      row->squared[version] = squaredDistance(&one, &all[version]);
    }
    const Float16 nearest = min16(row->squared[0], row->squared[1]);
    /* A particle near the box of a leaf may be near none in it. Without a branch, which could not be foreseen. */
    count += (greater16(all16(model->squaredCutoff), nearest) & movedLanes(rows, k)) != 0 ? 1 : 0;
  }
  return count;
}

/* Adds what rows have in the trial less what they had before it. */
CT_INLINE Sum16 addMovedRows(const StandInModel* model, const MovedRows* rows, bool hasKappa, Sum16 sum) {
  const Float16 cutoff = all16(model->squaredCutoff);
  Sixteen all[2];
  MovedRow found[CT_LEAF_WIDTH];
  for (int version = 0; version < 2; version++) {
    float shift[3];
    shiftBetween(rows->ones[version].frame, rows->all[version].frame, shift);
    all[version] = takeAll(model, &rows->all[version], shift);
  }
  const int count = findMovedRows(model, rows, all, found);
  Float16 gradients = load16(rows->ofAll);
  for (int begin = 0; begin < count; begin += ROWS_IN_FLOAT) {
    const int end = begin + ROWS_IN_FLOAT < count ? begin + ROWS_IN_FLOAT : count;
    Float16 part[ROWS_IN_FLOAT] = {all16(0), all16(0), all16(0), all16(0)};
    Float16 energies = all16(0);
    for (int i = begin; i < end; i++) {
      const int k = found[i].slot;
      const Sixteen one = takeOne(rows->ones, k);
      const PairConstants constants = constantsOf(&one, all);
      const unsigned direct = rows->ones->excluded != NULL ? ~(unsigned)rows->ones->excluded[k] : 0xffff;
      Float16 energy[2];
      Float16 gradient[2];
      for (int version = 0; version < 2; version++) {
        const Float16 squared = found[i].squared[version];
        energiesAt(model, &constants, squared, direct, hasKappa, &energy[version], &gradient[version]);
        energy[version] = keepBelowAmong16(movedLanes(rows, k), squared, cutoff, energy[version]);
        gradient[version] = keepBelowAmong16(movedLanes(rows, k), squared, cutoff, gradient[version]);
      }
      part[i - begin] = sub16(gradient[0], gradient[1]);
      energies = add16(energies, sub16(energy[0], energy[1]));
      gradients = add16(gradients, part[i - begin]);
    }
    sum = addToSum16(sum, energies);
    float totals[ROWS_IN_FLOAT];
    total4x16(part, totals);
    for (int i = begin; i < end; i++) {
      rows->ofOnes[found[i].slot] += totals[i - begin];
    }
  }
  store16(rows->ofAll, gradients);
  return sum;
}

void CT_WIDE(nearSome)(const StandInReach* reach, const LeafFrame* a, const LeafFrame* b, unsigned slotsOfA,
                       unsigned slotsOfB, NearRows* rows) {
  const LeafFrame* frames[2] = {a, b};
  const unsigned slots[2] = {slotsOfA, slotsOfB};
  for (int side = 0; side < 2; side++) {
    rows->pairs[side] = rows->born[side] = rows->overlaps[side] = 0;
    if (slots[side] != 0) {
      float shift[3];
      shiftBetween(frames[side], frames[1 - side], shift);
      const Float16 squared = squaredFromBox(frames[side], frames[1 - side], shift);
      rows->pairs[side] = (uint16_t)(slots[side] & ~greater16(squared, all16(reach->squaredPairs)));
      rows->born[side] = (uint16_t)(slots[side] & ~greater16(squared, all16(reach->squaredBorn)));
      rows->overlaps[side] = (uint16_t)(slots[side] & ~greater16(squared, all16(reach->squaredOverlap)));
    }
  }
}

double CT_WIDE(standInMove)(const StandInModel* model, const StandInSide a[2], const StandInSide b[2],
                            const NearRows* movers, float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  const bool isSelf = a->frame == b->frame; /* and not an image */
  /* Pairs of two displaced particles count once. */
  const MovedRows rows[2] = {{a, b, movers->pairs[0], 0xffff, gradientA, gradientB},
                             {b, a, isSelf ? 0 : movers->pairs[1], ~(unsigned)movers->pairs[0], gradientB, gradientA}};
  Sum16 sum = zeroSum16();
  for (int i = 0; i < 2; i++) {
    if (rows[i].slots != 0) {
      sum = model->hasKappa ? addMovedRows(model, &rows[i], true, sum) : addMovedRows(model, &rows[i], false, sum);
    }
  }
  return total16(sum);
}
