/* Born sums of two leaves, compiled once for each instruction set as a part of kernels_body.h.
 *
 * Where spheres do not overlap, r - s >= o, v(r; o, s) of ctBorn is 1/2 (x / (1 - x^2) - atanh x) / r with x = s / r,
 * that is s^3 / r^4 times a series P in x^2, which needs no root. It is odd in s, as v is. */

/* Farther apart (nm), particles count as if they were here: that is less than a step. Nearer, as if they were there. */
#define FARTHEST 1e3f
#define NEAREST 1e-6f

/* P(t) up to t = BORN_FAR_RATIO^2, with a relative error below 1.1e-7. */
CT_INLINE Float16 shortSeries(Float16 t) {
  Float16 p = add16(mul16(t, all16(0.6296422579f)), all16(0.4244512686f));
  p = add16(mul16(t, p), all16(0.4294699158f));
  p = add16(mul16(t, p), all16(0.3999861014f));
  return add16(mul16(t, p), all16(0.3333333673f));
}

/* P(t) up to t = BORN_NEAR_RATIO^2, with a relative error below 0.5e-7. */
CT_INLINE Float16 longSeries(Float16 t) {
  Float16 p = add16(mul16(t, all16(10.43894036f)), all16(-15.09229003f));
  p = add16(mul16(t, p), all16(11.41293558f));
  p = add16(mul16(t, p), all16(-3.821611337f));
  p = add16(mul16(t, p), all16(1.458518087f));
  p = add16(mul16(t, p), all16(0.3171037598f));
  p = add16(mul16(t, p), all16(0.4551282738f));
  p = add16(mul16(t, p), all16(0.4281556975f));
  p = add16(mul16(t, p), all16(0.4000061979f));
  return add16(mul16(t, p), all16(0.3333333183f));
}

/* v(r; o, s) for any spheres, from |s|: where r + s >= o, v is odd in s. With U - L without cancellation. */
static Float16 overlapOf(Float16 r, Float16 o, Float16 s) {
  const Float16 zero = all16(0);
  const Float16 one = all16(1);
  const Float16 size = absolute16(s);
  const Float16 between = sub16(r, size);
  const Float16 upper = add16(r, size);
  const Float16 lower = max16(o, absolute16(between));
  const Float16 least = min16(r, size);
  const Float16 apart = min16(sub16(upper, o), add16(least, least));
  /* log(U / L) is that of U / M with M = 2^n L, and n log 2. */
  Float16 below = lower;
  Float16 rest = apart;
  Float16 logarithm = zero;
  for (;;) {
    const Float16 twice = add16(below, below);
    const unsigned isAbove = greater16(upper, twice);
    if (isAbove == 0) {
      break;
    }
    below = blend16(isAbove, below, twice);
    rest = blend16(isAbove, rest, sub16(upper, twice));
    logarithm = blend16(isAbove, logarithm, add16(logarithm, all16(0.69314718056f)));
  }
  const Float16 z = div16(rest, add16(upper, below));
  const Float16 t = mul16(z, z);
  Float16 p = add16(mul16(t, all16(2.0f / 13)), all16(2.0f / 11));
  p = add16(mul16(t, p), all16(2.0f / 9));
  p = add16(mul16(t, p), all16(2.0f / 7));
  p = add16(mul16(t, p), all16(2.0f / 5));
  p = add16(mul16(t, p), all16(2.0f / 3));
  p = add16(mul16(t, p), all16(2));
  logarithm = add16(logarithm, mul16(z, p));
  const Float16 inverse = div16(one, r);
  const Float16 product = div16(one, mul16(lower, upper));
  const Float16 ratio = mul16(mul16(upper, upper), product);
  const Float16 quarter = mul16(mul16(all16(0.25f), mul16(between, inverse)), add16(one, ratio));
  const Float16 shells = mul16(mul16(apart, product), sub16(one, quarter));
  Float16 value = mul16(all16(0.5f), sub16(shells, mul16(mul16(all16(0.5f), inverse), logarithm)));
  value = blend16(greater16(zero, s), value, sub16(zero, value));
  return blend16(greater16(o, add16(r, s)), value, zero);
}

/* Replaces v, as the series has it, where that does not hold. */
CT_INLINE Float16 correctedOverlap(Float16 squared, Float16 t, Float16 o, Float16 s, Float16 v) {
  const Float16 touching = add16(o, absolute16(s));
  const unsigned isWrong =
      greater16(mul16(touching, touching), squared) | greater16(t, all16((float)(BORN_NEAR_RATIO * BORN_NEAR_RATIO)));
  return isWrong != 0 ? blend16(isWrong, v, overlapOf(sqrt16(squared), o, s)) : v;
}

/* The denominator of a neck. */
CT_INLINE Float16 neckWidth(Float16 r, Float16 distance) {
  const Float16 from = sub16(r, distance);
  const Float16 q = mul16(from, from);
  return add16(all16(1), mul16(q, add16(all16(100), mul16(all16(0.3e6f), mul16(q, q)))));
}

/* Sums for the lanes of side b, added to `lanes`, and for each row of side a, not yet added up; b's centre is at
 * `shift` from a's. Of one leaf with itself, that for the lanes is all. Constants for the last three arguments make a
 * function for each case. */
CT_INLINE Float16 bornRows(const BornModel* model, float squaredCutoff, const BornSide* a, const BornSide* b,
                           const float shift[3], unsigned rows, Float16 lanes, float (*forRows)[CT_LEAF_WIDTH],
                           bool isNear, bool hasNecks, bool isSame) {
  const BornColumns* columnsA = a->columns;
  const BornColumns* columnsB = b->columns;
  const Float16 xb = add16(load16(b->frame->x), all16(shift[0]));
  const Float16 yb = add16(load16(b->frame->y), all16(shift[1]));
  const Float16 zb = add16(load16(b->frame->z), all16(shift[2]));
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const Float16 dx = sub16(xb, all16(a->frame->x[k]));
    const Float16 dy = sub16(yb, all16(a->frame->y[k]));
    const Float16 dz = sub16(zb, all16(a->frame->z[k]));
    const Float16 distance2 = squared16(dx, dy, dz);
    Float16 squared = min16(distance2, all16(FARTHEST * FARTHEST));
    if (isNear) {
      squared = max16(squared, all16(NEAREST * NEAREST));
    }
    const Float16 inverse2 = div16(all16(1), squared);
    const Float16 inverse4 = mul16(inverse2, inverse2);
    const Float16 t = mul16(all16(columnsA->squaredScaled[k]), inverse2);
    const Float16 series = isNear ? longSeries(t) : shortSeries(t);
    Float16 forLanes = mul16(all16(columnsA->cubedScaled[k]), mul16(inverse4, series));
    Float16 forRow = all16(0);
    if (isNear) {
      forLanes =
          correctedOverlap(squared, t, load16(columnsB->offsetRadius), all16(columnsA->scaledRadius[k]), forLanes);
    }
    if (!isSame) {
      const Float16 tb = mul16(load16(columnsB->squaredScaled), inverse2);
      const Float16 seriesB = isNear ? longSeries(tb) : shortSeries(tb);
      forRow = mul16(load16(columnsB->cubedScaled), mul16(inverse4, seriesB));
      if (isNear) {
        forRow =
            correctedOverlap(squared, tb, all16(columnsA->offsetRadius[k]), load16(columnsB->scaledRadius), forRow);
      }
    }
    if (hasNecks) {
      const BornNecks* necks = &model->necks[b->leaf * model->neckTypeCount + columnsA->neckType[k]];
      const Float16 r = sqrt16(squared);
      const Float16 reach = add16(load16(columnsB->radius), all16(columnsA->radius[k] + model->neckCut));
      const Float16 widthB = neckWidth(r, load16(necks->distanceForLeaf));
      if (isSame) {
        forLanes = add16(forLanes, keepBelow16(r, reach, div16(load16(necks->heightForLeaf), widthB)));
      } else {
        const Float16 widthA = neckWidth(r, load16(necks->distanceForOne));
        const Float16 both = div16(all16(1), mul16(widthA, widthB));
        const Float16 neckB = mul16(mul16(load16(necks->heightForLeaf), widthA), both);
        const Float16 neckA = mul16(mul16(load16(necks->heightForOne), widthB), both);
        forLanes = add16(forLanes, keepBelow16(r, reach, neckB));
        forRow = add16(forRow, keepBelow16(r, reach, neckA));
      }
    }
    forLanes = keepBelow16(distance2, all16(squaredCutoff), forLanes);
    if (isSame) {
      forLanes = keep16(~(1u << k), forLanes);
    } else {
      store16(forRows[k], keepBelow16(distance2, all16(squaredCutoff), forRow));
    }
    lanes = add16(lanes, forLanes);
  }
  return lanes;
}

/* Multiples of BORN_SUM_STEP. */
CT_INLINE Float16 toSteps(Float16 a) {
  /* The last bit of a float that is not below this one is worth a step or more. */
  const Float16 large = all16((float)((1 << 23) * BORN_SUM_STEP));
  const Float16 size = sub16(add16(absolute16(a), large), large);
  return blend16(greater16(all16(0), a), size, sub16(all16(0), size));
}

/* Rows of side a, each by the function for its case. */
CT_INLINE Float16 bornCases(const BornModel* model, float squaredCutoff, const BornSide* a, const BornSide* b,
                            const float shift[3], unsigned rows, float (*forRows)[CT_LEAF_WIDTH], bool isSame) {
  const unsigned near = rows & rowsNear(a->frame, b->frame, shift, model->squaredNear);
  const unsigned withNecks =
      model->neckTypeCount > 0 ? rows & rowsNear(a->frame, b->frame, shift, model->squaredNeckReach) : 0;
  Float16 lanes = all16(0);
  if ((near & withNecks) != 0) {
    lanes = bornRows(model, squaredCutoff, a, b, shift, near & withNecks, lanes, forRows, true, true, isSame);
  }
  if ((near & ~withNecks) != 0) {
    lanes = bornRows(model, squaredCutoff, a, b, shift, near & ~withNecks, lanes, forRows, true, false, isSame);
  }
  if ((withNecks & ~near) != 0) {
    lanes = bornRows(model, squaredCutoff, a, b, shift, withNecks & ~near, lanes, forRows, false, true, isSame);
  }
  const unsigned far = rows & ~near & ~withNecks;
  if (far != 0) {
    lanes = bornRows(model, squaredCutoff, a, b, shift, far, lanes, forRows, false, false, isSame);
  }
  return lanes;
}

static void bornSums(const BornModel* model, float squaredCutoff, const BornSide* a, const BornSide* b,
                     float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH]) {
  float shift[3];
  float back[3];
  float forRows[CT_LEAF_WIDTH][CT_LEAF_WIDTH];
  shiftBetween(a->frame, b->frame, shift);
  if (a->leaf == b->leaf) {
    store16(ofA, toSteps(bornCases(model, squaredCutoff, a, b, shift, a->occupied, forRows, true)));
    return;
  }
  /* Each row of one side costs the same, so those of the side with fewer are summed. */
  shiftBetween(b->frame, a->frame, back);
  unsigned rows = a->occupied & rowsNear(a->frame, b->frame, shift, squaredCutoff);
  const unsigned rowsOfB = b->occupied & rowsNear(b->frame, a->frame, back, squaredCutoff);
  const float* from = shift;
  if (__builtin_popcount(rowsOfB) < __builtin_popcount(rows)) {
    const BornSide* side = a;
    float* of = ofA;
    a = b;
    b = side;
    ofA = ofB;
    ofB = of;
    rows = rowsOfB;
    from = back;
  }
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    if ((rows >> k & 1) == 0) {
      store16(forRows[k], all16(0));
    }
  }
  store16(ofB, toSteps(bornCases(model, squaredCutoff, a, b, from, rows, forRows, false)));
  store16(ofA, toSteps(sums16x16(forRows)));
}
