/* Pair energies of the stand-in. */
#include "elementary.h"
#include "rows.h"
#include "set.h"
#include "sums.h"

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

/* What is added up: energies of pairs, or of a new version less those of the former one. */
typedef enum StandInVersions {
  oneVersion,
  twoRadii, /* without what does not depend on radii */
  twoPlaces /* of particles that are displaced */
} StandInVersions;

typedef struct StandInCase {
  StandInVersions versions;
  bool isMasked; /* some pairs are excluded */
  bool hasKappa;
} StandInCase;

/* How far the particles of a row of pairs are apart: r, and f of generalized Born. */
typedef struct Separation {
  Float16 squared;  /* r^2 */
  Float16 exponent; /* r^2 / (4 B_i B_j), as one of 2 */
  Float16 widening; /* f^2 - r^2 = B_i B_j exp(-r^2 / (4 B_i B_j)) */
  Float16 inverse2; /* 1 / r^2 */
  Float16 inverseF2;
  Float16 inverse; /* 1 / r, of displaced particles alone, as the next */
  Float16 inverseF;
} Separation;

CT_INLINE Float16 squaredDistance(const Sixteen* one, const Sixteen* all) {
  const Float16 dx = sub16(all->x, one->x);
  const Float16 dy = sub16(all->y, one->y);
  const Float16 dz = sub16(all->z, one->z);
  return max16(squared16(dx, dy, dz), all16(STANDIN_LEAST_SQUARED));
}

CT_INLINE void widen(const Sixteen* one, const Sixteen* all, Separation* s) {
  s->exponent = mul16(s->squared, mul16(one->decay, all->decay));
  s->widening = mul16(mul16(one->radius, all->radius), powerOfMinus(s->exponent));
}

/* Both reciprocal squares by one division. Or by roots, which take less time than a division and two roots. */
CT_INLINE void invert(Separation* s, StandInCase its) {
  const Float16 squaredF = add16(s->squared, s->widening);
  if (its.versions == twoPlaces) {
    s->inverse = inverseRoot16(s->squared);
    s->inverseF = inverseRoot16(squaredF);
    s->inverse2 = mul16(s->inverse, s->inverse);
    s->inverseF2 = mul16(s->inverseF, s->inverseF);
    return;
  }
  const Float16 both = div16(all16(1), mul16(s->squared, squaredF));
  s->inverse2 = mul16(both, squaredF);
  s->inverseF2 = mul16(both, s->squared);
}

/* The energies of a row of pairs, and their derivatives by ln B of either in units of STANDIN_GRADIENT. `used`: lanes
 * that count; `direct`: lanes that are not excluded. */
CT_INLINE void pairEnergies(const StandInModel* model, const Sixteen* one, const Sixteen* all, const Separation* s,
                            unsigned used, unsigned direct, StandInCase its, Float16* energy, Float16* gradient) {
  const Float16 inverseF = its.versions == twoPlaces ? s->inverseF : sqrt16(s->inverseF2);
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
  if (its.versions != twoRadii) {
    const Float16 sigma = add16(one->sigma, all->sigma);
    const Float16 ratio2 = mul16(mul16(sigma, sigma), s->inverse2);
    const Float16 ratio6 = mul16(mul16(ratio2, ratio2), ratio2);
    const Float16 epsilon = mul16(one->epsilon, all->epsilon);
    const Float16 lennardJones = mul16(epsilon, mul16(ratio6, sub16(ratio6, all16(1))));
    const Float16 inverse = its.versions == twoPlaces ? s->inverse : sqrt16(s->inverse2);
    const Float16 coulomb = mul16(mul16(one->charge, all->charge), inverse);
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
  const StandInSide* ones; /* the new version, then the former one */
  const StandInSide* all;
  unsigned slots; /* of the ones, as bits */
  unsigned lanes; /* of the others */
  float* ofOnes;  /* gradients */
  float* ofAll;
} StandInRows;

/* The lanes that count in the row of slot k. Of a leaf with itself those behind it, or those that are not displaced or
 * behind it. */
CT_INLINE unsigned lanesOf(const StandInRows* rows, StandInCase its, bool isSelf, int k) {
  const unsigned behind = 0xfffeu << k;
  if (its.versions == twoPlaces) {
    return isSelf ? behind | ~rows->slots : rows->lanes;
  }
  return isSelf ? behind : rows->lanes;
}

/* Adds rows, of a leaf with itself with those behind each. Operations of one row wait for each other, so each step is
 * that of all rows. */
CT_INLINE Sum16 addStandInRows(const StandInModel* model, const StandInRows* rows, StandInCase its, Sum16 sum) {
  const int versions = its.versions == oneVersion ? 1 : 2;
  const bool isSelf = rows->ones->frame == rows->all->frame;
  const Float16 cutoff = all16(model->squaredCutoff);
  Sixteen all[2];
  Separation separations[2 * CT_LEAF_WIDTH];
  int slots[2 * CT_LEAF_WIDTH];
  int count = 0;
  for (int version = 0; version < versions; version++) {
    float shift[3];
    shiftBetween(rows->ones[version].frame, rows->all[version].frame, shift);
    all[version] = takeAll(model, &rows->all[version], shift);
  }
  for (unsigned ones = rows->slots; ones != 0; ones &= ones - 1) {
    const int k = __builtin_ctz(ones);
    const Sixteen one = takeOne(rows->ones, k);
    Float16 squared = squaredDistance(&one, &all[0]);
    Float16 nearest = squared;
    separations[count].squared = squared;
    slots[count] = k;
    if (versions == 2) {
      if (its.versions == twoPlaces) {
        const Sixteen former = takeOne(&rows->ones[1], k);
        squared = squaredDistance(&former, &all[1]);
        nearest = min16(nearest, squared);
      }
      separations[count + 1].squared = squared;
      slots[count + 1] = k;
    }
    /* A particle near the box of a leaf may be near none in it. Without a branch, which could not be foreseen. */
    count += (greater16(cutoff, nearest) & lanesOf(rows, its, isSelf, k)) != 0 ? versions : 0;
  }
  for (int i = 0; i < count; i++) {
    const Sixteen one = takeOne(&rows->ones[i % versions], slots[i]);
    widen(&one, &all[i % versions], &separations[i]);
  }
  for (int i = 0; i < count; i++) {
    invert(&separations[i], its);
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
      pairEnergies(model, &one, &all[version], &separations[i], lanesOf(rows, its, isSelf, k), direct, its, &energy,
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
CT_INLINE Sum16 addStandInCase(const StandInModel* model, const StandInRows* rows, StandInVersions versions,
                               Sum16 sum) {
  if (rows->slots == 0) {
    return sum;
  }
  if (rows->ones->excluded != NULL) {
    return model->hasKappa ? addStandInRows(model, rows, (StandInCase){versions, true, true}, sum)
                           : addStandInRows(model, rows, (StandInCase){versions, true, false}, sum);
  }
  return model->hasKappa ? addStandInRows(model, rows, (StandInCase){versions, false, true}, sum)
                         : addStandInRows(model, rows, (StandInCase){versions, false, false}, sum);
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

void CT_WIDE(nearMovers)(const StandInModel* model, const LeafFrame* const a[2], const LeafFrame* const b[2],
                         unsigned moversOfA, unsigned moversOfB, NearRows* rows) {
  const unsigned movers[2] = {moversOfA, moversOfB};
  for (int side = 0; side < 2; side++) {
    const LeafFrame* const* own = side == 0 ? a : b;
    const LeafFrame* const* other = side == 0 ? b : a;
    rows->pairs[side] = rows->born[side] = rows->overlaps[side] = 0;
    if (movers[side] == 0) {
      continue;
    }
    Float16 nearest = all16(NO_CUTOFF);
    for (int version = 0; version < 2; version++) {
      float shift[3];
      shiftBetween(own[version], other[version], shift);
      nearest = min16(nearest, squaredFromBox(own[version], other[version], shift));
    }
    rows->pairs[side] = (uint16_t)(movers[side] & ~greater16(nearest, all16(model->squaredCutoff * ROUNDING_OF_BOXES)));
    rows->born[side] =
        (uint16_t)(movers[side] & ~greater16(nearest, all16(model->squaredBornCutoff * ROUNDING_OF_BOXES)));
    rows->overlaps[side] =
        (uint16_t)(movers[side] & ~greater16(nearest, all16(model->squaredOverlap * ROUNDING_OF_BOXES)));
  }
}

double CT_WIDE(standInPairs)(const StandInModel* model, const StandInSide* a, const StandInSide* b,
                             const NearRows* near, float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  /* By the side with fewer particles near the other. */
  const bool isOfA = __builtin_popcount(near->pairs[0]) <= __builtin_popcount(near->pairs[1]);
  const StandInRows rows = isOfA ? (StandInRows){a, b, near->pairs[0], 0xffff, gradientA, gradientB}
                                 : (StandInRows){b, a, near->pairs[1], 0xffff, gradientB, gradientA};
  return total16(addStandInCase(model, &rows, oneVersion, zeroSum16()));
}

/* Rows of some slots of either side, of which pairs of two count once. */
CT_INLINE double exchange(const StandInModel* model, const StandInSide a[2], const StandInSide b[2], unsigned slotsOfA,
                          unsigned slotsOfB, unsigned lanesOfA, StandInVersions versions,
                          float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  const StandInRows rows[2] = {{a, b, slotsOfA, 0xffff, gradientA, gradientB},
                               {b, a, slotsOfB, lanesOfA, gradientB, gradientA}};
  Sum16 sum = zeroSum16();
  for (int i = 0; i < 2; i++) {
    sum = addStandInCase(model, &rows[i], versions, sum);
  }
  return total16(sum);
}

double CT_WIDE(standInExchange)(const StandInModel* model, const StandInSide a[2], const StandInSide b[2],
                                const NearRows* near, unsigned slotsOfA, unsigned slotsOfB,
                                float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  return exchange(model, a, b, slotsOfA & near->pairs[0], slotsOfB & near->pairs[1], ~slotsOfA, twoRadii, gradientA,
                  gradientB);
}

double CT_WIDE(standInMove)(const StandInModel* model, const StandInSide a[2], const StandInSide b[2],
                            const NearRows* movers, float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]) {
  const unsigned ofB = a->frame == b->frame ? 0 : movers->pairs[1]; /* those of a leaf with itself count once */
  return exchange(model, a, b, movers->pairs[0], ofB, ~(unsigned)movers->pairs[0], twoPlaces, gradientA, gradientB);
}
