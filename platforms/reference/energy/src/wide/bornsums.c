/* Born sums of pairs of leaves.
 *
 * Where spheres do not overlap, r - s >= o, v(r; o, s) of ctBorn is 1/2 (x / (1 - x^2) - atanh x) / r with x = s / r,
 * that is s^3 / r^4 times a series P in x^2, which needs no root. It is odd in s, as v is. */
#include "../blockgap.h"
#include "bornpair.h"
#include "set.h"
#include "sums.h"

/* Where rows are, and so which series holds. */
typedef enum BornRange {
  bornRemote, /* s / r is at most BORN_REMOTE_RATIO */
  bornFar,    /* at most BORN_FAR_RATIO */
  bornNear    /* any: spheres may overlap */
} BornRange;

/* P(t) where rows are near. The relative errors of series are below 0.8e-6 for remote rows, which contribute little,
 * and 1.3e-7 for others. */
CT_INLINE Float16 nearestSeries(Float16 t) {
  const float c[] = {0.3333332922f, 0.4000137732f, 0.4278248782f, 0.4596163302f,
                     0.306237974f,  1.224110084f,  -1.580146636f, 2.932006772f};
  return polynomial16(t, 7, c);
}

/* Sums for the lanes of side b, added to `lanes`, and for each row of side a, added to `forRows`, not yet added up. Of
 * one leaf with itself, that for the lanes is all. Constants for the last three arguments make a function for each
 * case. */
CT_INLINE Float16 bornRows(const BornModel* model, float squaredCutoff, const BornSides* sides, unsigned rows,
                           Float16 lanes, float (*forRows)[CT_LEAF_WIDTH], BornRange range, bool hasNecks,
                           bool isSame) {
  const BornColumns* columnsA = sides->a->columns;
  const BornColumns* columnsB = sides->b->columns;
  const BornNecks* necksB = model->necks + (size_t)sides->b->leaf * (size_t)model->neckTypeCount;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const Float16 distance2 = squaredFrom(sides, k);
    Float16 squared = min16(distance2, all16(FARTHEST * FARTHEST));
    if (range == bornNear) {
      squared = max16(squared, all16(NEAREST * NEAREST));
    }
    const Float16 inverse2 = div16(all16(1), squared);
    const Float16 inverse4 = mul16(inverse2, inverse2);
    Float16 forLanes;
    Float16 forRow;
    Float16 ta = all16(0); /* of near rows only */
    Float16 tb = all16(0);
    if (range == bornNear) {
      tb = mul16(all16(columnsA->squaredScaled[k]), inverse2);
      ta = isSame ? tb : mul16(load16(columnsB->squaredScaled), inverse2);
      forLanes = mul16(all16(columnsA->cubedScaled[k]), mul16(inverse4, nearestSeries(tb)));
      forRow = isSame ? forLanes : mul16(load16(columnsB->cubedScaled), mul16(inverse4, nearestSeries(ta)));
    } else {
      const float(*ofA)[CT_LEAF_WIDTH] = range == bornRemote ? columnsA->remote : columnsA->far;
      const float(*ofB)[CT_LEAF_WIDTH] = range == bornRemote ? columnsB->remote : columnsB->far;
      const int last = range == bornRemote ? 2 : 4;
      forLanes = all16(ofA[last][k]);
      forRow = load16(ofB[last]);
      _Pragma("GCC unroll 4") for (int n = last - 1; n >= 0; n--) {
        forLanes = add16(mul16(forLanes, inverse2), all16(ofA[n][k]));
        forRow = add16(mul16(forRow, inverse2), load16(ofB[n]));
      }
      forLanes = mul16(forLanes, inverse4);
      forRow = mul16(forRow, inverse4);
    }
    if (range == bornNear) {
      /* Both ways at once: overlaps are mutual, mostly. */
      const Float16 offsetA = all16(columnsA->offsetRadius[k]);
      const Float16 offsetB = load16(columnsB->offsetRadius);
      const Float16 scaledA = all16(columnsA->scaledRadius[k]);
      const Float16 scaledB = load16(columnsB->scaledRadius);
      const Float16 touchingB = add16(offsetB, absolute16(scaledA));
      const Float16 touching = isSame ? touchingB : max16(touchingB, add16(offsetA, absolute16(scaledB)));
      const unsigned isWrong = greater16(mul16(touching, touching), squared) |
                               greater16(max16(ta, tb), all16((float)(BORN_NEAR_RATIO * BORN_NEAR_RATIO)));
      if (isWrong != 0) {
        const Float16 r = sqrt16(squared);
        const Float16 inverse = mul16(r, inverse2);
        forLanes = blend16(isWrong, forLanes, overlapOf(r, inverse, offsetB, scaledA));
        if (!isSame) {
          forRow = blend16(isWrong, forRow, overlapOf(r, inverse, offsetA, scaledB));
        }
        if (model->isFilled) {
          forLanes = add16(forLanes, fillingOf(r, offsetB, scaledA));
          forRow = isSame ? forRow : add16(forRow, fillingOf(r, offsetA, scaledB));
        }
      }
    }
    if (hasNecks) {
      const BornNecks* necks = &necksB[columnsA->neckType[k]];
      const Float16 r = sqrt16(squared);
      const Float16 reach = add16(load16(columnsB->radius), all16(columnsA->neckReach[k]));
      const Float16 widthB = neckWidth(r, load16(necks->distanceForLeaf));
      if (isSame) {
        forLanes = add16(forLanes, keepBelow16(r, reach, div16(load16(necks->heightForLeaf), widthB)));
      } else {
        const Float16 widthA = neckWidth(r, load16(necks->distanceForOne));
        const Float16 both = keepBelow16(r, reach, div16(all16(1), mul16(widthA, widthB)));
        forLanes = add16(forLanes, mul16(mul16(load16(necks->heightForLeaf), widthA), both));
        forRow = add16(forRow, mul16(mul16(load16(necks->heightForOne), widthB), both));
      }
    }
    forLanes = keepBelow16(distance2, all16(squaredCutoff), forLanes);
    if (isSame) {
      forLanes = keep16(~(1u << k), forLanes);
    } else {
      store16(forRows[k], add16(load16(forRows[k]), keepBelow16(distance2, all16(squaredCutoff), forRow)));
    }
    lanes = add16(lanes, forLanes);
  }
  return lanes;
}

/* How near the rows of a leaf are to the other leaf, as bits. */
typedef struct BornBits {
  unsigned rows; /* within the cutoff */
  unsigned near;
  unsigned far;
  unsigned necks;
} BornBits;

CT_INLINE BornBits findBornBits(const BornModel* model, float squaredCutoff, const BornSide* a, const BornSide* b,
                                const float shift[3]) {
  const Float16 squared = squaredFromBox(a->frame, b->frame, shift);
  const unsigned rows = a->occupied & ~greater16(squared, all16(squaredCutoff * ROUNDING_OF_BOXES));
  return (BornBits){
      .rows = rows,
      .near = rows & ~greater16(squared, all16(model->squaredNear)),
      .far = rows & ~greater16(squared, all16(model->squaredFar)),
      .necks = model->neckTypeCount > 0 ? rows & ~greater16(squared, all16(model->squaredNeckReach)) : 0,
  };
}

/* Those of some rows with a particle of side b within this squared distance: one near its box may be near none in it.
 */
CT_INLINE unsigned rowsWithin(const BornSides* sides, unsigned rows, float squaredReach) {
  const Float16 reach = all16(squaredReach * ROUNDING_OF_BOXES);
  unsigned within = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    within |= (unsigned)(greater16(reach, squaredFrom(sides, k)) != 0) << k;
  }
  return within;
}

/* Of full leaves that are remote from each other, without a cutoff. The series is that of bornRemote, with its
 * coefficients in the columns. The others that return sums for lanes are bornRows and mixedRows. */
CT_INLINE Float16 remoteRows(const BornSides* sides, float (*forRows)[CT_LEAF_WIDTH]) {
  const BornColumns* columnsA = sides->a->columns;
  const BornColumns* columnsB = sides->b->columns;
  const Float16 first = load16(columnsB->remote[0]);
  const Float16 second = load16(columnsB->remote[1]);
  const Float16 third = load16(columnsB->remote[2]);
  Float16 forLanes = all16(0);
  /* Two reciprocals by one division. */
  _Pragma("GCC unroll 4") for (int k = 0; k < CT_LEAF_WIDTH; k += 2) {
    const Float16 squared[2] = {squaredFrom(sides, k), squaredFrom(sides, k + 1)};
    const Float16 both = div16(all16(1), mul16(squared[0], squared[1]));
    for (int i = 0; i < 2; i++) {
      const Float16 inverse2 = mul16(both, squared[1 - i]);
      const Float16 inverse4 = mul16(inverse2, inverse2);
      const Float16 highA =
          add16(all16(columnsA->remote[1][k + i]), mul16(all16(columnsA->remote[2][k + i]), inverse2));
      const Float16 highB = add16(second, mul16(third, inverse2));
      const Float16 forRow = mul16(inverse4, add16(first, mul16(highB, inverse2)));
      forLanes = add16(forLanes, mul16(inverse4, add16(all16(columnsA->remote[0][k + i]), mul16(highA, inverse2))));
      store16(forRows[k + i], add16(load16(forRows[k + i]), forRow));
    }
  }
  return forLanes;
}

/* Of two other leaves. `shift` leads from the centre of a to that of b. */
CT_INLINE Float16 mixedRows(const BornModel* model, float squaredCutoff, const BornSides* sides, const float shift[3],
                            float (*forRows)[CT_LEAF_WIDTH]) {
  BornBits bits = findBornBits(model, squaredCutoff, sides->a, sides->b, shift);
  bits.near = rowsWithin(sides, bits.near, model->squaredNear);
  if (squaredCutoff < NO_CUTOFF) {
    bits.rows = bits.near | rowsWithin(sides, bits.rows & ~bits.near, squaredCutoff);
    bits.far &= bits.rows;
    bits.necks &= bits.rows;
  }
  Float16 lanes = all16(0);
  unsigned rows = bits.rows & ~bits.far & ~bits.near & ~bits.necks;
  lanes = bornRows(model, squaredCutoff, sides, rows, lanes, forRows, bornRemote, false, false);
  rows = bits.far & ~bits.near & ~bits.necks;
  lanes = bornRows(model, squaredCutoff, sides, rows, lanes, forRows, bornFar, false, false);
  rows = bits.necks & ~bits.near;
  lanes = bornRows(model, squaredCutoff, sides, rows, lanes, forRows, bornFar, true, false);
  rows = bits.near & ~bits.necks;
  lanes = bornRows(model, squaredCutoff, sides, rows, lanes, forRows, bornNear, false, false);
  rows = bits.near & bits.necks;
  lanes = bornRows(model, squaredCutoff, sides, rows, lanes, forRows, bornNear, true, false);
  return keep16(sides->b->occupied, lanes);
}

/* Of a leaf with itself. */
CT_INLINE Float16 ownRows(const BornModel* model, float squaredCutoff, const BornSide* a) {
  const BornSides sides = {a, a, load16(a->frame->x), load16(a->frame->y), load16(a->frame->z)};
  const Float16 lanes =
      model->neckTypeCount > 0
          ? bornRows(model, squaredCutoff, &sides, a->occupied, all16(0), NULL, bornNear, true, true)
          : bornRows(model, squaredCutoff, &sides, a->occupied, all16(0), NULL, bornNear, false, true);
  return keep16(a->occupied, lanes);
}

CT_INLINE void addToSums(double sums[CT_LEAF_WIDTH], Float16 a) {
  storeSum16(sums, addToSum16(loadSum16(sums), a));
}

/* Adds leaves from `first` to `end`, over which rows are added up in single precision. */
CT_INLINE void sumLeaves(const BornModel* model, float squaredCutoff, const LeafFrame* frames,
                         const BornColumns* columns, int leaf, int first, int end, double* sums) {
  const BornSide a = {&frames[leaf], &columns[leaf], columns[leaf].occupied, leaf};
  const bool hasCutoff = squaredCutoff < NO_CUTOFF;
  float forRows[CT_LEAF_WIDTH][CT_LEAF_WIDTH] = {{0}};
  for (int other = first; other < end; other++) {
    const BornSide b = {&frames[other], &columns[other], columns[other].occupied, other};
    double* sumsOfB = sums + CT_LEAF_WIDTH * other;
    if (other == leaf) {
      addToSums(sumsOfB, ownRows(model, squaredCutoff, &a));
      continue;
    }
    const double gap = squaredGap(a.frame, b.frame);
    if (hasCutoff && gap > (double)(squaredCutoff * ROUNDING_OF_BOXES)) {
      continue;
    }
    float shift[3];
    shiftBetween(a.frame, b.frame, shift);
    const BornSides sides = {&a, &b, add16(load16(b.frame->x), all16(shift[0])),
                             add16(load16(b.frame->y), all16(shift[1])), add16(load16(b.frame->z), all16(shift[2]))};
    const bool areFull = (a.occupied & b.occupied) == 0xffff;
    const bool areRemote = areFull && !hasCutoff && gap > (double)model->squaredReach;
    addToSums(sumsOfB,
              areRemote ? remoteRows(&sides, forRows) : mixedRows(model, squaredCutoff, &sides, shift, forRows));
  }
  addToSums(sums + CT_LEAF_WIDTH * leaf, sums16x16((const float(*)[CT_LEAF_WIDTH])forRows));
}

void CT_WIDE(bornSums)(const BornModel* model, float squaredCutoff, const LeafFrame* frames, const BornColumns* columns,
                       int leaf, int first, int end, double* sums) {
  enum { LEAVES_IN_FLOAT = 64 };
  for (; first + LEAVES_IN_FLOAT < end; first += LEAVES_IN_FLOAT) {
    sumLeaves(model, squaredCutoff, frames, columns, leaf, first, first + LEAVES_IN_FLOAT, sums);
  }
  sumLeaves(model, squaredCutoff, frames, columns, leaf, first, end, sums);
}

void CT_WIDE(bornImageSums)(const BornModel* model, float squaredCutoff, const LeafFrame* image,
                            const LeafFrame* frames, const BornColumns* columns, int leaf, int other, double* sums) {
  const BornSide a = {image, &columns[leaf], columns[leaf].occupied, leaf};
  const BornSide b = {&frames[other], &columns[other], columns[other].occupied, other};
  float forRows[CT_LEAF_WIDTH][CT_LEAF_WIDTH] = {{0}};
  float shift[3];
  shiftBetween(a.frame, b.frame, shift);
  const BornSides sides = {&a, &b, add16(load16(b.frame->x), all16(shift[0])),
                           add16(load16(b.frame->y), all16(shift[1])), add16(load16(b.frame->z), all16(shift[2]))};
  addToSums(sums + CT_LEAF_WIDTH * other, mixedRows(model, squaredCutoff, &sides, shift, forRows));
  addToSums(sums + CT_LEAF_WIDTH * leaf, sums16x16((const float(*)[CT_LEAF_WIDTH])forRows));
}
