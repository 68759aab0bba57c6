/* The stand-in's radii and pairs, compiled once for each instruction set by the file that includes this. */
#include "elementary.h"
#include "standinpair.h"

/* ---- Radii ---- */

/* tanh(t) */
CT_INLINE Float16 tanhOf(Float16 t) {
  const Float16 bounded = min16(max16(add16(t, t), all16(-40)), all16(40));
  return sub16(all16(1), div16(all16(2), add16(exp16(bounded), all16(1))));
}

/* A Born radius has to be positive, however large its sum. */
#define STANDIN_LEAST_INVERSE 0.01f /* 1/nm */

static void standInRadii(const StandInModel* model, const StandInConstants* constants, const double born[],
                         StandInRadii* radii) {
  float sums[CT_LEAF_WIDTH];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] = (float)(born[k] + constants->far[k]);
  }
  const Float16 sum = load16(sums);
  Float16 inverse = sub16(load16(constants->perOffsetRadius), sum);
  if (model->isRescaled) {
    const Float16 psi = mul16(sum, load16(constants->offsetRadius));
    const Float16 inner = sub16(mul16(psi, load16(constants->gamma)), load16(constants->beta));
    const Float16 t = mul16(psi, add16(load16(constants->alpha), mul16(psi, inner)));
    inverse = sub16(load16(constants->perOffsetRadius), mul16(tanhOf(t), load16(constants->perRadius)));
  }
  inverse = max16(inverse, all16(STANDIN_LEAST_INVERSE));
  const Float16 log = sub16(all16(0), log16(inverse));
  const Float16 magic = all16(CT_WHOLE_MAGIC);
  const Float16 number = sub16(add16(mul16(log, all16(model->perGridWidth)), magic), magic);
  const Float16 ofGrid = mul16(number, all16(model->gridWidth));
  const Float16 inverseOfGrid = exp16(sub16(all16(0), ofGrid));
  Float16 perDielectric = sub16(all16(model->perDielectrics[0]), all16(model->perDielectrics[1]));
  if (model->hasKappa) {
    const Float16 screening = exp16(div16(all16(-model->kappa), inverse));
    perDielectric = sub16(all16(model->perDielectrics[0]), mul16(screening, all16(model->perDielectrics[1])));
  }
  const Float16 inverse3 = mul16(mul16(inverse, inverse), inverse);
  const Float16 ofCharge = mul16(mul16(load16(constants->squaredCharge), perDielectric), inverse);
  const Float16 ofSurface = mul16(mul16(load16(constants->surface), inverse3), inverse3);
  store16(radii->radius, div16(all16(1), inverseOfGrid));
  store16(radii->halfInverse, mul16(all16(0.5f), inverseOfGrid));
  store16(radii->number, number);
  store16(radii->beyond, sub16(log, ofGrid));
  store16(radii->self, sub16(ofSurface, ofCharge));
}

/* What depends on radii of the grid alone. */
static void standInShift(const StandInModel* model, const StandInRadii* radii, StandInShift* shift) {
  const Float16 log = mul16(load16(radii->number), all16(model->gridWidth));
  const Float16 t = mul16(sub16(log, all16(model->middleLog)), all16(model->perHalfWidth));
  const Float16 bounded = max16(min16(t, all16(1)), all16(-1));
  for (int which = 0; which < 2; which++) {
    for (int i = 0; i < SHIFT_RANK; i++) {
      store16(shift->value[which][i], polynomial16(bounded, SHIFT_TERMS - 1, model->shift[which][i]));
    }
  }
}

/* Exchanges parts of sums; false, and nothing changed, if they are the same. */
static bool exchangeParts(double sums[], const float before[], const float after[]) {
  const Float16 from = load16(before);
  const Float16 to = load16(after);
  if ((greater16(from, to) | greater16(to, from)) == 0) {
    return false;
  }
  storeSum16(sums, addToSum16(addToSum16(loadSum16(sums), to), sub16(all16(0), from)));
  return true;
}

/* The energies of the particles of a leaf by themselves, and the first order of what the grid neglects of pairs. */
static double standInLeafEnergy(const StandInRadii* radii, const double gradient[]) {
  double sums[CT_LEAF_WIDTH];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] = (double)radii->self[k] + gradient[k] * (double)radii->beyond[k];
  }
  for (int width = CT_LEAF_WIDTH / 2; width > 0; width /= 2) {
    for (int k = 0; k < width; k++) {
      sums[k] += sums[k + width];
    }
  }
  return sums[0];
}

/* ---- Pairs ---- */

/* Particles that coincide have a distance, too. */
#define STANDIN_LEAST_SQUARED 1e-6f /* nm^2 */

/* What is known of sixteen particles of a side, or sixteen times of one of them. */
typedef struct Sixteen {
  Float16 x, y, z;
  Float16 charge, sigma, epsilon;
  Float16 bornCharge, radius, halfInverse;
  Float16 shift[2][SHIFT_RANK];
} Sixteen;

/* `sign` is that of the products of functions, for one of the two sides, or 1. */
CT_INLINE Sixteen takeAll(const StandInSide* side, const float sign[2][SHIFT_RANK]) {
  Sixteen all = {load16(side->frame->x),
                 load16(side->frame->y),
                 load16(side->frame->z),
                 load16(side->columns->charge),
                 load16(side->columns->sigma),
                 load16(side->columns->epsilon),
                 load16(side->charge),
                 load16(side->radii->radius),
                 load16(side->radii->halfInverse),
                 {{all16(0), all16(0), all16(0)}}};
  for (int which = 0; which < 2; which++) {
    for (int i = 0; i < SHIFT_RANK; i++) {
      all.shift[which][i] = mul16(all16(sign[which][i]), load16(side->shift->value[which][i]));
    }
  }
  return all;
}

CT_INLINE Sixteen takeOne(const StandInSide* side, int k) {
  Sixteen one = {all16(side->frame->x[k]),        all16(side->frame->y[k]),       all16(side->frame->z[k]),
                 all16(side->columns->charge[k]), all16(side->columns->sigma[k]), all16(side->columns->epsilon[k]),
                 all16(side->charge[k]),          all16(side->radii->radius[k]),  all16(side->radii->halfInverse[k]),
                 {{all16(0), all16(0), all16(0)}}};
  for (int which = 0; which < 2; which++) {
    for (int i = 0; i < SHIFT_RANK; i++) {
      one.shift[which][i] = all16(side->shift->value[which][i][k]);
    }
  }
  return one;
}

CT_INLINE void moveBy(Sixteen* particles, const float shift[3]) {
  particles->x = add16(particles->x, all16(shift[0]));
  particles->y = add16(particles->y, all16(shift[1]));
  particles->z = add16(particles->z, all16(shift[2]));
}

/* The value at the cutoff per product of charges, or its derivative. The sign of each product is in the sixteen
 * particles, whichever side they are of: it changes no bit of a product but its sign. */
CT_INLINE Float16 atCutoff(const Sixteen* a, const Sixteen* b, int which) {
  const Float16 two =
      add16(mul16(a->shift[which][0], b->shift[which][0]), mul16(a->shift[which][1], b->shift[which][1]));
  return add16(two, mul16(a->shift[which][2], b->shift[which][2]));
}

/* e^-x for x >= 0, by STANDIN_EXP. */
CT_INLINE Float16 expOfMinus(Float16 x) {
  const float c[] = STANDIN_EXP;
  const Float16 bounded = min16(x, all16(70));
  const Float16 shifted = add16(mul16(bounded, all16(-1.44269504f)), all16(CT_WHOLE_MAGIC));
  const Float16 r = add16(bounded, mul16(sub16(shifted, all16(CT_WHOLE_MAGIC)), all16(0.69314718f)));
  const Int16 exponent = shiftLeftInts(bitsOf16(shifted), 23); /* the magic's bits are shifted out */
  return floatsOfBits(addInts(bitsOf16(polynomial16(r, 3, c)), exponent));
}

/* The energies of pairs of a particle of side a with one of side b, and their derivatives by ln B of either. The order
 * of operations is that of the sides, whichever of them is sixteen particles. `counts`: not excluded. */
CT_INLINE void pairEnergies(const StandInModel* model, const Sixteen* a, const Sixteen* b, bool isMasked,
                            unsigned counts, bool hasKappa, Float16* energy, Float16* gradient) {
  const Float16 dx = sub16(b->x, a->x);
  const Float16 dy = sub16(b->y, a->y);
  const Float16 dz = sub16(b->z, a->z);
  const Float16 one = all16(1);
  const Float16 squared =
      max16(add16(add16(mul16(dx, dx), mul16(dy, dy)), mul16(dz, dz)), all16(STANDIN_LEAST_SQUARED));
  /* f^2 = r^2 + B_i B_j exp(-r^2 / (4 B_i B_j)), and both reciprocal squares by one division. */
  const Float16 exponent = mul16(squared, mul16(a->halfInverse, b->halfInverse));
  const Float16 widening = mul16(mul16(a->radius, b->radius), expOfMinus(exponent));
  const Float16 squaredF = add16(squared, widening);
  const Float16 both = div16(one, mul16(squared, squaredF));
  const Float16 inverse2 = mul16(both, squaredF);
  const Float16 inverseF2 = mul16(both, squared);
  const Float16 inverseF = sqrt16(inverseF2);
  /* Lennard-Jones and Coulomb. */
  const Float16 sigma = add16(b->sigma, a->sigma);
  const Float16 ratio2 = mul16(mul16(sigma, sigma), inverse2);
  const Float16 ratio6 = mul16(mul16(ratio2, ratio2), ratio2);
  const Float16 lennardJones = mul16(mul16(b->epsilon, mul16(ratio6, sub16(ratio6, one))), a->epsilon);
  const Float16 coulomb = mul16(mul16(b->charge, a->charge), sqrt16(inverse2));
  /* The value at the cutoff. */
  const Float16 charges = mul16(b->bornCharge, a->bornCharge);
  const Float16 shift = mul16(charges, atCutoff(a, b, 0));
  Float16 slope = mul16(charges, atCutoff(a, b, 1));
  Float16 direct = sub16(add16(lennardJones, coulomb), shift);
  if (isMasked) {
    direct = keep16(counts, direct);
    slope = keep16(counts, slope);
  }
  Float16 perDielectric = all16(model->perDielectrics[0] - model->perDielectrics[1]);
  Float16 steepness = mul16(perDielectric, inverseF);
  if (hasKappa) {
    const Float16 screening =
        mul16(expOfMinus(mul16(all16(model->kappa), mul16(squaredF, inverseF))), all16(model->perDielectrics[1]));
    perDielectric = sub16(all16(model->perDielectrics[0]), screening);
    steepness = sub16(mul16(perDielectric, inverseF), mul16(all16(model->kappa), screening));
  }
  const Float16 born = mul16(charges, mul16(perDielectric, inverseF));
  /* d(f^2) / d ln B = widening (1 + exponent). */
  const Float16 ofF = mul16(mul16(widening, add16(exponent, one)), mul16(all16(0.5f), inverseF2));
  const Float16 cutoff = all16(model->squaredCutoff);
  *energy = keepBelow16(squared, cutoff, min16(sub16(direct, born), all16(STANDIN_MOST_ENERGY)));
  *gradient = keepBelow16(squared, cutoff, sub16(mul16(mul16(charges, ofF), steepness), slope));
}

/* Adds the pairs of some particles of one side, one after another, with those of the other side in `lanes`; of a leaf
 * with itself, with those behind them. */
CT_INLINE Sum16 addPairs(const StandInModel* model, const StandInSide* a, const StandInSide* b, const float shift[3],
                         bool onesAreOfA, unsigned ones, unsigned lanes, bool isSelf, bool hasLanes, bool isMasked,
                         bool hasKappa, Sum16 sum, float ofOnes[], float ofLanes[]) {
  Sixteen sixteen = takeAll(onesAreOfA ? b : a, model->shiftSign);
  if (onesAreOfA) {
    moveBy(&sixteen, shift);
  }
  const uint16_t* excluded = onesAreOfA ? a->excluded : b->excluded;
  Float16 gradients = load16(ofLanes);
  while (ones != 0) {
    Float16 part[ROWS_IN_FLOAT] = {all16(0), all16(0), all16(0), all16(0)};
    Float16 energies = all16(0);
    int slots[ROWS_IN_FLOAT];
    int count = 0;
    for (; count < ROWS_IN_FLOAT && ones != 0; count++, ones &= ones - 1) {
      const int k = __builtin_ctz(ones);
      Sixteen single = takeOne(onesAreOfA ? a : b, k);
      if (!onesAreOfA) {
        moveBy(&single, shift);
      }
      Float16 energy;
      Float16 gradient;
      pairEnergies(model, onesAreOfA ? &single : &sixteen, onesAreOfA ? &sixteen : &single, isMasked,
                   isMasked ? ~(unsigned)excluded[k] : 0, hasKappa, &energy, &gradient);
      if (isSelf || hasLanes) {
        const unsigned used = isSelf ? 0xfffeu << k : lanes;
        energy = keep16(used, energy);
        gradient = keep16(used, gradient);
      }
      energies = add16(energies, energy);
      gradients = add16(gradients, gradient);
      part[count] = gradient;
      slots[count] = k;
    }
    sum = addToSum16(sum, energies);
    float totals[ROWS_IN_FLOAT];
    total4x16(part, totals);
    for (int i = 0; i < count; i++) {
      ofOnes[slots[i]] += totals[i];
    }
  }
  store16(ofLanes, gradients);
  return sum;
}

/* The same by the function for this case. */
CT_INLINE Sum16 addCase(const StandInModel* model, const StandInSide* a, const StandInSide* b, const float shift[3],
                        bool onesAreOfA, unsigned ones, unsigned lanes, bool isSelf, bool hasLanes, Sum16 sum,
                        float ofOnes[], float ofLanes[]) {
  if (model->hasKappa) {
    return a->excluded != NULL ? addPairs(model, a, b, shift, onesAreOfA, ones, lanes, isSelf, hasLanes, true, true,
                                          sum, ofOnes, ofLanes)
                               : addPairs(model, a, b, shift, onesAreOfA, ones, lanes, isSelf, hasLanes, false, true,
                                          sum, ofOnes, ofLanes);
  }
  return a->excluded != NULL ? addPairs(model, a, b, shift, onesAreOfA, ones, lanes, isSelf, hasLanes, true, false, sum,
                                        ofOnes, ofLanes)
                             : addPairs(model, a, b, shift, onesAreOfA, ones, lanes, isSelf, hasLanes, false, false,
                                        sum, ofOnes, ofLanes);
}

static double standInPairs(const StandInModel* model, const StandInSide* a, const StandInSide* b, unsigned slotsOfA,
                           unsigned slotsOfB, float gradientA[], float gradientB[]) {
  float shift[3];
  float back[3];
  const bool isSelf = a->frame == b->frame;
  shiftBetween(a->frame, b->frame, shift);
  shiftBetween(b->frame, a->frame, back);
  unsigned rows = slotsOfA & rowsNear(a->frame, b->frame, shift, model->squaredCutoff);
  unsigned columns = slotsOfB & rowsNear(b->frame, a->frame, back, model->squaredCutoff);
  Sum16 sum = zeroSum16();
  if (isSelf) {
    sum = addCase(model, a, b, shift, true, slotsOfA, 0xffff, true, false, sum, gradientA, gradientB);
  } else if (slotsOfA == a->columns->occupied && slotsOfB == b->columns->occupied) {
    /* All pairs: by the side with fewer particles near the other. */
    if (__builtin_popcount(rows) <= __builtin_popcount(columns)) {
      sum = addCase(model, a, b, shift, true, rows, 0xffff, false, false, sum, gradientA, gradientB);
    } else {
      sum = addCase(model, a, b, shift, false, columns, 0xffff, false, false, sum, gradientB, gradientA);
    }
  } else {
    sum = addCase(model, a, b, shift, true, rows, 0xffff, false, false, sum, gradientA, gradientB);
    sum = addCase(model, a, b, shift, false, columns, ~slotsOfA, false, true, sum, gradientB, gradientA);
  }
  return total16(sum);
}
