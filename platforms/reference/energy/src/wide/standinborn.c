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

/* Rows of Born sums: particles of side a near some of side b, with their contributions to these, and the reverse. Of
 * displaced particles each row is followed by that before the trial. */
typedef struct BornRows {
  int count;
  int slots[2 * CT_LEAF_WIDTH];
  Float16 squared[2 * CT_LEAF_WIDTH];
  Float16 inverse[2 * CT_LEAF_WIDTH]; /* 1 / r, of displaced particles alone */
  Float16 forLanes[2 * CT_LEAF_WIDTH];
  Float16 forRow[2 * CT_LEAF_WIDTH];
} BornRows;

/* Adds the row of slot k, if it is within the cutoff in one of its versions. */
CT_INLINE void addBornRow(const BornSides* sides, int versions, int k, Float16 cutoff, bool isSame, BornRows* rows) {
  unsigned near = 0;
  for (int version = 0; version < versions; version++) {
    const int i = rows->count + version;
    Float16 squared = squaredFrom(&sides[version], k);
    if (isSame) {
      squared = blend16(1u << k, squared, all16(FARTHEST * FARTHEST));
    }
    /* Slots without a particle are beyond any cutoff. */
    rows->squared[i] = max16(min16(squared, all16(FARTHEST * FARTHEST)), all16(NEAREST * NEAREST));
    rows->slots[i] = k;
    if (versions == 2) {
      rows->inverse[i] = inverseRoot16(rows->squared[i]); /* in less time than roots and divisions */
    }
    near |= greater16(cutoff, squared);
  }
  /* One near the box of a leaf may be near none in it. Without a branch, which could not be foreseen. */
  rows->count += near != 0 ? versions : 0;
}

/* Finds the rows within the cutoff. */
CT_INLINE void findBornRows(const BornSides* sides, int versions, unsigned slots, float squaredCutoff, bool isSame,
                            BornRows* rows) {
  rows->count = 0;
  for (; slots != 0; slots &= slots - 1) {
    addBornRow(sides, versions, __builtin_ctz(slots), all16(squaredCutoff), isSame, rows);
  }
}

/* What is taken from each pair, per cube. */
CT_INLINE Float16 bornTaken(const StandInModel* standIn, Float16 squared) {
  return add16(all16(standIn->bornFade[0]), mul16(all16(standIn->bornFade[1]), squared));
}

/* The distances of a row. */
CT_INLINE Float16 distancesOf(const BornRows* rows, int versions, int i) {
  return versions == 2 ? mul16(rows->squared[i], rows->inverse[i]) : sqrt16(rows->squared[i]);
}

/* What particles contribute that do not overlap, and the greater of the two squares of s / r. */
CT_INLINE void setSpheres(const StandInModel* standIn, const BornSides* sides, int versions, BornRows* rows,
                          Float16 ratios[]) {
  const BornColumns* columnsA = sides->a->columns;
  const BornColumns* columnsB = sides->b->columns;
  for (int i = 0; i < rows->count; i++) {
    const int k = rows->slots[i];
    const Float16 inverse2 =
        versions == 2 ? mul16(rows->inverse[i], rows->inverse[i]) : div16(all16(1), rows->squared[i]);
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
CT_INLINE void setOverlaps(const BornModel* model, const StandInModel* standIn, const BornSides* sides, int versions,
                           unsigned near, const Float16 ratios[], BornRows* rows) {
  const BornColumns* columnsA = sides->a->columns;
  const BornColumns* columnsB = sides->b->columns;
  const Float16 offsetB = load16(columnsB->offsetRadius);
  const Float16 scaledB = load16(columnsB->scaledRadius);
  const Float16 sizeB = absolute16(scaledB);
  const Float16 mostRatio = all16((float)(BORN_NEAR_RATIO * BORN_NEAR_RATIO));
  int overlapping[2 * CT_LEAF_WIDTH];
  unsigned lanes[2 * CT_LEAF_WIDTH];
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
    const Float16 r = distancesOf(rows, versions, i);
    const Float16 inverse = versions == 2 ? rows->inverse[i] : div16(all16(1), r);
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
CT_INLINE void addNecks(const BornModel* model, const BornSides* sides, int versions, bool areCut, BornRows* rows) {
  const BornColumns* columnsA = sides->a->columns;
  const BornNecks* necksB = model->necks + (size_t)sides->b->leaf * (size_t)model->neckTypeCount;
  for (int i = 0; i < rows->count; i++) {
    const int k = rows->slots[i];
    const BornNecks* necks = &necksB[columnsA->neckType[k]];
    const Float16 r = distancesOf(rows, versions, i);
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

/* Finds the contributions of rows of side a, given as bits; those in `near` may overlap some of side b. Constants for
 * the last four arguments make a function for each case. */
CT_INLINE void setBornRows(const BornModel* model, const StandInModel* standIn, const BornSides* sides, int versions,
                           unsigned slots, unsigned near, bool isSame, bool hasNecks, bool areCut, BornRows* rows) {
  Float16 ratios[2 * CT_LEAF_WIDTH];
  findBornRows(sides, versions, slots, standIn->squaredBornCutoff, isSame, rows);
  setSpheres(standIn, sides, versions, rows, ratios);
  if (near != 0) {
    setOverlaps(model, standIn, sides, versions, near, ratios, rows);
  }
  if (hasNecks) {
    addNecks(model, sides, versions, areCut, rows);
  }
}

/* The same by the function for the case. */
CT_INLINE void setBornCase(const BornModel* model, const StandInModel* standIn, const BornSides* sides, int versions,
                           unsigned slots, unsigned near, bool isSame, BornRows* rows) {
  if (model->neckTypeCount == 0) {
    setBornRows(model, standIn, sides, versions, slots, near, isSame, false, false, rows);
  } else if (standIn->squaredBornCutoff > model->squaredLeastNeckReach) {
    setBornRows(model, standIn, sides, versions, slots, near, isSame, true, true, rows);
  } else {
    setBornRows(model, standIn, sides, versions, slots, near, isSame, true, false, rows);
  }
}

CT_INLINE BornSides sidesOf(const BornSide* a, const BornSide* b) {
  float shift[3];
  shiftBetween(a->frame, b->frame, shift);
  return (BornSides){a, b, add16(load16(b->frame->x), all16(shift[0])), add16(load16(b->frame->y), all16(shift[1])),
                     add16(load16(b->frame->z), all16(shift[2]))};
}

void CT_WIDE(standInBorn)(const BornModel* model, const StandInModel* standIn, const BornSide* a, const BornSide* b,
                          const NearRows* near, float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH]) {
  const Float16 cutoff = all16(standIn->squaredBornCutoff);
  float forRows[CT_LEAF_WIDTH][CT_LEAF_WIDTH];
  Float16 lanes = all16(0);
  BornRows rows;
  /* Each row of one side costs the same, so those of the side with fewer are summed. */
  const bool isOfA = __builtin_popcount(near->born[0]) <= __builtin_popcount(near->born[1]);
  const BornSides sides = isOfA ? sidesOf(a, b) : sidesOf(b, a);
  const unsigned slots = near->born[isOfA ? 0 : 1];
  const unsigned overlaps = near->overlaps[isOfA ? 0 : 1];
  if (a->frame == b->frame) { /* and not an image */
    setBornCase(model, standIn, &sides, 1, slots, overlaps, true, &rows);
    for (int i = 0; i < rows.count; i++) {
      lanes = add16(lanes, keepBelow16(rows.squared[i], cutoff, rows.forLanes[i]));
    }
    store16(ofA, toSteps(lanes));
    store16(ofB, all16(0));
    return;
  }
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    store16(forRows[k], all16(0));
  }
  setBornCase(model, standIn, &sides, 1, slots, overlaps, false, &rows);
  for (int i = 0; i < rows.count; i++) {
    lanes = add16(lanes, keepBelow16(rows.squared[i], cutoff, rows.forLanes[i]));
    store16(forRows[rows.slots[i]], keepBelow16(rows.squared[i], cutoff, rows.forRow[i]));
  }
  store16(isOfA ? ofB : ofA, toSteps(lanes));
  store16(isOfA ? ofA : ofB, toSteps(sums16x16((const float(*)[CT_LEAF_WIDTH])forRows)));
}

/* Adds to the sums of both sides by how much rows of displaced particles change them. `givers`: particles of side b
 * from which the rows get something; `takers`: particles that get something from them. */
CT_INLINE void moveBornRows(const BornModel* model, const StandInModel* standIn, const BornSide a[2],
                            const BornSide b[2], unsigned slots, unsigned near, unsigned givers, unsigned takers,
                            float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH]) {
  const Float16 cutoff = all16(standIn->squaredBornCutoff);
  const bool isSame = a->frame == b->frame; /* and not an image */
  const BornSides sides[2] = {sidesOf(&a[0], &b[0]), sidesOf(&a[1], &b[1])};
  BornRows rows;
  Float16 lanes = all16(0);
  setBornCase(model, standIn, sides, 2, slots, near, isSame, &rows);
  for (int begin = 0; begin < rows.count; begin += 2 * ROWS_IN_FLOAT) {
    const int end = begin + 2 * ROWS_IN_FLOAT < rows.count ? begin + 2 * ROWS_IN_FLOAT : rows.count;
    Float16 part[ROWS_IN_FLOAT] = {all16(0), all16(0), all16(0), all16(0)};
    float totals[ROWS_IN_FLOAT];
    for (int i = begin; i < end; i += 2) {
      const Float16* squared = &rows.squared[i];
      lanes = add16(lanes, sub16(keepBelow16(squared[0], cutoff, rows.forLanes[i]),
                                 keepBelow16(squared[1], cutoff, rows.forLanes[i + 1])));
      const Float16 change =
          sub16(keepBelow16(squared[0], cutoff, rows.forRow[i]), keepBelow16(squared[1], cutoff, rows.forRow[i + 1]));
      part[(i - begin) / 2] = keep16(givers, change);
    }
    total4x16(part, totals);
    for (int i = begin; i < end; i += 2) {
      ofA[rows.slots[i]] += totals[(i - begin) / 2];
    }
  }
  store16(ofB, add16(load16(ofB), keep16(takers, lanes)));
}

void CT_WIDE(standInBornMove)(const BornModel* model, const StandInModel* standIn, const BornSide a[2],
                              const BornSide b[2], const NearRows* movers, float ofA[CT_LEAF_WIDTH],
                              float ofB[CT_LEAF_WIDTH]) {
  const unsigned others = ~(unsigned)movers->born[0];
  if (a->frame == b->frame) {
    moveBornRows(model, standIn, a, b, movers->born[0], movers->overlaps[0], others, 0xffff, ofA, ofA);
  } else {
    if (movers->born[0] != 0) {
      moveBornRows(model, standIn, a, b, movers->born[0], movers->overlaps[0], 0xffff, 0xffff, ofA, ofB);
    }
    if (movers->born[1] != 0) {
      moveBornRows(model, standIn, b, a, movers->born[1], movers->overlaps[1], others, others, ofB, ofA);
    }
    store16(ofB, toSteps(load16(ofB)));
  }
  store16(ofA, toSteps(load16(ofA)));
}
