/* Born sums of the stand-in, of two leaves within its cutoff. Operations of one row wait for each other, so each step
 * is that of all rows. */
#include "bornpair.h"
#include "set.h"
#include "sums.h"

/* P(t) of bornsums.c up to BORN_NEAR_RATIO, with a relative error below 1.1e-6. */
CT_INLINE Float16 nearSeries(Float16 t) {
  const float c[] = {0.3333336719f, 0.3999130883f,  0.4321456996f, 0.3905117975f,
                     0.8301592643f, -0.8080398834f, 2.318234015f};
  return polynomial16(t, 6, c);
}

/* Rows of Born sums: particles of side a near some of side b, with their contributions to these, and the reverse. */
typedef struct BornRows {
  int count;
  int slots[CT_LEAF_WIDTH];
  Float16 squared[CT_LEAF_WIDTH];
  Float16 forLanes[CT_LEAF_WIDTH];
  Float16 forRow[CT_LEAF_WIDTH];
} BornRows;

/* Finds the rows within the cutoff. */
CT_INLINE void findBornRows(const BornSides* sides, unsigned slots, float squaredCutoff, bool isSame, BornRows* rows) {
  const Float16 cutoff = all16(squaredCutoff);
  rows->count = 0;
  for (; slots != 0; slots &= slots - 1) {
    const int k = __builtin_ctz(slots);
    Float16 squared = squaredFrom(sides, k);
    if (isSame) {
      squared = blend16(1u << k, squared, all16(FARTHEST * FARTHEST));
    }
    /* Slots without a particle are beyond any cutoff. */
    rows->squared[rows->count] = max16(min16(squared, all16(FARTHEST * FARTHEST)), all16(NEAREST * NEAREST));
    rows->slots[rows->count] = k;
    /* One near the box of a leaf may be near none in it. Without a branch, which could not be foreseen. */
    rows->count += greater16(cutoff, squared) != 0 ? 1 : 0;
  }
}

/* What is taken from each pair, per cube. */
CT_INLINE Float16 bornTaken(const StandInModel* standIn, Float16 squared) {
  return add16(all16(standIn->bornFade[0]), mul16(all16(standIn->bornFade[1]), squared));
}

/* What particles contribute that do not overlap, and the greater of the two squares of s / r. */
CT_INLINE void setSpheres(const StandInModel* standIn, const BornSides* sides, BornRows* rows, Float16 ratios[]) {
  const BornColumns* columnsA = sides->a->columns;
  const BornColumns* columnsB = sides->b->columns;
  for (int i = 0; i < rows->count; i++) {
    const int k = rows->slots[i];
    const Float16 inverse2 = div16(all16(1), rows->squared[i]);
    const Float16 inverse4 = mul16(inverse2, inverse2);
    const Float16 taken = bornTaken(standIn, rows->squared[i]);
    const Float16 tb = mul16(all16(columnsA->squaredScaled[k]), inverse2);
    const Float16 ta = mul16(load16(columnsB->squaredScaled), inverse2);
    const Float16 ofA = sub16(mul16(inverse4, nearSeries(tb)), taken);
    const Float16 ofB = sub16(mul16(inverse4, nearSeries(ta)), taken);
    rows->forLanes[i] = mul16(all16(columnsA->cubedScaled[k]), ofA);
    rows->forRow[i] = mul16(load16(columnsB->cubedScaled), ofB);
    ratios[i] = max16(ta, tb);
  }
}

/* Puts what particles contribute that overlap in the place of that; rows in `near` may do. */
CT_INLINE void setOverlaps(const BornModel* model, const StandInModel* standIn, const BornSides* sides, unsigned near,
                           const Float16 ratios[], BornRows* rows) {
  const BornColumns* columnsA = sides->a->columns;
  const BornColumns* columnsB = sides->b->columns;
  const Float16 offsetB = load16(columnsB->offsetRadius);
  const Float16 scaledB = load16(columnsB->scaledRadius);
  const Float16 sizeB = absolute16(scaledB);
  const Float16 mostRatio = all16((float)(BORN_NEAR_RATIO * BORN_NEAR_RATIO));
  int overlapping[CT_LEAF_WIDTH];
  unsigned lanes[CT_LEAF_WIDTH];
  int count = 0;
  for (int i = 0; i < rows->count; i++) {
    /* Both ways at once: overlaps are mutual, mostly. */
    const int k = rows->slots[i];
    const Float16 touching =
        max16(add16(offsetB, all16(fabsf(columnsA->scaledRadius[k]))), add16(all16(columnsA->offsetRadius[k]), sizeB));
    lanes[count] = greater16(mul16(touching, touching), rows->squared[i]) | greater16(ratios[i], mostRatio);
    overlapping[count] = i;
    count += (near >> k & 1) != 0 && lanes[count] != 0 ? 1 : 0;
  }
  for (int n = 0; n < count; n++) {
    const int i = overlapping[n];
    const int k = rows->slots[i];
    const Float16 offsetA = all16(columnsA->offsetRadius[k]);
    const Float16 scaledA = all16(columnsA->scaledRadius[k]);
    const Float16 r = sqrt16(rows->squared[i]);
    const Float16 inverse = div16(all16(1), r);
    const Float16 taken = bornTaken(standIn, rows->squared[i]);
    Float16 forLanes = overlapOf(r, inverse, offsetB, scaledA);
    Float16 forRow = overlapOf(r, inverse, offsetA, scaledB);
    if (model->isFilled) {
      forLanes = add16(forLanes, fillingOf(r, offsetB, scaledA));
      forRow = add16(forRow, fillingOf(r, offsetA, scaledB));
    }
    forLanes = sub16(forLanes, mul16(all16(columnsA->cubedScaled[k]), taken));
    forRow = sub16(forRow, mul16(load16(columnsB->cubedScaled), taken));
    rows->forLanes[i] = blend16(lanes[n], rows->forLanes[i], forLanes);
    rows->forRow[i] = blend16(lanes[n], rows->forRow[i], forRow);
  }
}

/* `areCut`: some particles within the cutoff are too far apart for a neck. */
CT_INLINE void addNecks(const BornModel* model, const BornSides* sides, bool areCut, BornRows* rows) {
  const BornColumns* columnsA = sides->a->columns;
  const BornNecks* necksB = model->necks + (size_t)sides->b->leaf * (size_t)model->neckTypeCount;
  for (int i = 0; i < rows->count; i++) {
    const int k = rows->slots[i];
    const BornNecks* necks = &necksB[columnsA->neckType[k]];
    const Float16 r = sqrt16(rows->squared[i]);
    const Float16 widthB = neckWidth(r, load16(necks->distanceForLeaf));
    const Float16 widthA = neckWidth(r, load16(necks->distanceForOne));
    const Float16 both = div16(all16(1), mul16(widthA, widthB));
    Float16 neckB = mul16(mul16(load16(necks->heightForLeaf), widthA), both);
    Float16 neckA = mul16(mul16(load16(necks->heightForOne), widthB), both);
    if (areCut) {
      const Float16 reach = add16(load16(sides->b->columns->radius), all16(columnsA->radius[k] + model->neckCut));
      neckB = keepBelow16(r, reach, neckB);
      neckA = keepBelow16(r, reach, neckA);
    }
    rows->forLanes[i] = add16(rows->forLanes[i], neckB);
    rows->forRow[i] = add16(rows->forRow[i], neckA);
  }
}

/* Adds rows of side a, given as bits; those in `near` may overlap some of side b. The sums for the lanes of side b are
 * returned, and those of the rows put in their places. Constants for the last three arguments make a function for each
 * case. */
CT_INLINE Float16 standInBornRows(const BornModel* model, const StandInModel* standIn, const BornSides* sides,
                                  unsigned slots, unsigned near, float (*forRows)[CT_LEAF_WIDTH], bool isSame,
                                  bool hasNecks, bool areCut) {
  const Float16 cutoff = all16(standIn->squaredBornCutoff);
  BornRows rows;
  Float16 ratios[CT_LEAF_WIDTH];
  findBornRows(sides, slots, standIn->squaredBornCutoff, isSame, &rows);
  setSpheres(standIn, sides, &rows, ratios);
  if (near != 0) {
    setOverlaps(model, standIn, sides, near, ratios, &rows);
  }
  if (hasNecks) {
    addNecks(model, sides, areCut, &rows);
  }
  Float16 lanes = all16(0);
  for (int i = 0; i < rows.count; i++) {
    lanes = add16(lanes, keepBelow16(rows.squared[i], cutoff, rows.forLanes[i]));
    if (!isSame) {
      store16(forRows[rows.slots[i]], keepBelow16(rows.squared[i], cutoff, rows.forRow[i]));
    }
  }
  return lanes;
}

/* The same by the function for the case. */
CT_INLINE Float16 standInBornCase(const BornModel* model, const StandInModel* standIn, const BornSides* sides,
                                  unsigned slots, unsigned near, float (*forRows)[CT_LEAF_WIDTH], bool isSame) {
  if (model->neckTypeCount == 0) {
    return standInBornRows(model, standIn, sides, slots, near, forRows, isSame, false, false);
  }
  return standIn->squaredBornCutoff > model->squaredLeastNeckReach
             ? standInBornRows(model, standIn, sides, slots, near, forRows, isSame, true, true)
             : standInBornRows(model, standIn, sides, slots, near, forRows, isSame, true, false);
}

void CT_WIDE(standInBorn)(const BornModel* model, const StandInModel* standIn, const BornSide* a, const BornSide* b,
                          const NearRows* near, float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH]) {
  float shift[3];
  float forRows[CT_LEAF_WIDTH][CT_LEAF_WIDTH];
  /* Each row of one side costs the same, so those of the side with fewer are summed. */
  const bool isOfA = __builtin_popcount(near->born[0]) <= __builtin_popcount(near->born[1]);
  const BornSide* ones = isOfA ? a : b;
  const BornSide* all = isOfA ? b : a;
  const unsigned rows = near->born[isOfA ? 0 : 1];
  const unsigned overlaps = near->overlaps[isOfA ? 0 : 1];
  shiftBetween(ones->frame, all->frame, shift);
  const BornSides sides = {ones, all, add16(load16(all->frame->x), all16(shift[0])),
                           add16(load16(all->frame->y), all16(shift[1])),
                           add16(load16(all->frame->z), all16(shift[2]))};
  if (a->frame == b->frame) { /* and not an image */
    store16(ofA, toSteps(standInBornCase(model, standIn, &sides, rows, overlaps, forRows, true)));
    store16(ofB, all16(0));
    return;
  }
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    store16(forRows[k], all16(0));
  }
  const Float16 lanes = standInBornCase(model, standIn, &sides, rows, overlaps, forRows, false);
  store16(isOfA ? ofB : ofA, toSteps(lanes));
  store16(isOfA ? ofA : ofB, toSteps(sums16x16((const float(*)[CT_LEAF_WIDTH])forRows)));
}
