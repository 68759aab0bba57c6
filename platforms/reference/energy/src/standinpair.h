/* The data from which wide functions compute the stand-in of ctStandIn. */
#ifndef CT_STANDINPAIR_H_
#define CT_STANDINPAIR_H_

#include "leafpair.h"

/* The value of a pair at the cutoff, and its derivative by ln B of either, are sums of VALUE_RANK and SLOPE_RANK
 * products of a function of one radius and the same function of the other; the functions are polynomials with
 * SHIFT_TERMS coefficients. The derivative is multiplied by the rounding of ln B to the grid, which is small. */
enum { VALUE_RANK = 3, SLOPE_RANK = 2, SHIFT_RANK = VALUE_RANK + SLOPE_RANK, SHIFT_TERMS = 8, FADE_TERMS = 3 };

typedef struct StandInModel {
  bool hasKappa;
  bool isRescaled;
  float squaredCutoff;
  float squaredBornCutoff;
  float squaredOverlap;    /* no particles farther apart overlap */
  float perDielectrics[2]; /* 1 / soluteDielectric and 1 / solventDielectric */
  float kappa;
  float kappaOfTwo; /* times log2(e) */
  float middleLog;  /* of the radii in whose range the polynomials hold, and half of its width */
  float perHalfWidth;
  float shift[SHIFT_RANK][SHIFT_TERMS]; /* of the value per product of charges, then of its derivative */
  float shiftSign[SHIFT_RANK];          /* of each product */
  float bornFade[2];                    /* STANDIN_BORN_FADE as factors of s^3 and s^3 r^2 */
  float fade[FADE_TERMS];               /* STANDIN_FADE as factors of r^4, r^6 and r^8 */
} StandInModel;

/* What Born radii and energies of single particles of a leaf are computed from. Where a slot holds none, radii are 1
 * and all else is 0. */
typedef struct StandInConstants {
  double far[CT_LEAF_WIDTH]; /* the part of the Born sum that stands for particles far away */
  float offsetRadius[CT_LEAF_WIDTH];
  float perOffsetRadius[CT_LEAF_WIDTH];
  float perRadius[CT_LEAF_WIDTH];
  float alpha[CT_LEAF_WIDTH];
  float beta[CT_LEAF_WIDTH];
  float gamma[CT_LEAF_WIDTH];
  float squaredCharge[CT_LEAF_WIDTH]; /* times half of the Coulomb constant */
  float surface[CT_LEAF_WIDTH];       /* the surface energy, times B^6 */
  float gridWidth[CT_LEAF_WIDTH];     /* of ln B */
  float perGridWidth[CT_LEAF_WIDTH];
} StandInConstants;

/* Born radii of the particles of a leaf. Those of the grid are what pairs see. */
typedef struct StandInRadii {
  float radius[CT_LEAF_WIDTH]; /* of the grid */
  float decay[CT_LEAF_WIDTH];  /* the product of two is log2(e) / (4 B_i B_j) */
  float log[CT_LEAF_WIDTH];    /* its logarithm */
  float beyond[CT_LEAF_WIDTH]; /* ln B less that of the grid, times STANDIN_GRADIENT */
  float self[CT_LEAF_WIDTH];   /* the self energy of the particle, kJ/mol */
} StandInRadii;

/* The functions of the radii of the grid that make the value of a pair at the cutoff, and its derivative, times the
 * charges. */
typedef struct StandInShift {
  float value[SHIFT_RANK][CT_LEAF_WIDTH];
} StandInShift;

/* Which particles of two leaves may be near some of the other one, as bits of their slots, by its box. */
typedef struct NearRows {
  uint16_t pairs[2]; /* within the cutoff of pairs: of the first leaf, and of the second */
  uint16_t born[2];  /* within that of Born sums */
  uint16_t overlaps[2];
} NearRows;

/* How far a particle can be from the box of another leaf to be near it, see NearRows. */
typedef struct StandInReach {
  float squaredPairs;
  float squaredBorn;
  float squaredOverlap;
} StandInReach;

/* True if two leaves can have an energy, or contribute to each other's Born sums. */
static inline bool hasPairs(const NearRows* rows) {
  return rows->pairs[0] != 0 && rows->pairs[1] != 0;
}

static inline bool hasBorn(const NearRows* rows) {
  return rows->born[0] != 0 && rows->born[1] != 0;
}

/* The same of displaced particles alone: true if one of them is near the other leaf. */
static inline bool havePairs(const NearRows* movers) {
  return (movers->pairs[0] | movers->pairs[1]) != 0;
}

static inline bool haveBorn(const NearRows* movers) {
  return (movers->born[0] | movers->born[1]) != 0;
}

/* One of the two leaves of a pair. */
typedef struct StandInSide {
  const LeafFrame* frame;
  const LeafColumns* columns;
  const float* charge; /* that of ctBorn, times the root of its Coulomb constant */
  const StandInRadii* radii;
  const StandInShift* shift;
  const uint16_t* excluded; /* see LeafSide */
} StandInSide;

/* What stands for 2^-x, |x| <= 1/2, in pairs: a polynomial within 1e-4 of it, since the stand-in is no nearer to what
 * it stands for. */
#define STANDIN_POWER \
  { 0.9999280303f, -0.6932610502f, 0.2426118533f, -0.0551716100f }

/* What is taken from a pair, excluded or not, is its value at the cutoff times
 * c[0] x^2 + c[1] x^3 + c[2] x^4 with x = (r / cutoff)^2. What is taken from what a particle contributes to a Born sum
 * is s^3 / (3 cutoff^4), its value at that cutoff, about, times c[0] + c[1] x. So the part that is left out
 * beyond the cutoff continues smoothly within, and nearly cancels in a sum over all particles. By least squares, of
 * what 400 trials change U less the stand-in by: the former in villin, ubiquitin and DHFR, for a cutoff of 0.8 nm, the
 * latter in these and BPTI, for cutoffs of 0.55 and 0.6 nm. */
#define STANDIN_FADE \
  { 10.6f, -16.2f, 6.6f }
#define STANDIN_BORN_FADE \
  { -2.2f, 3.4f }

/* The grid of radii is as wide as it is said for particles with this charge, in units of the elementary one. Its errors
 * grow with the charge and with the square of the width. What fits best at a number of crossings has widths that go
 * with this power of the charge; but no grid is wider than STANDIN_WIDEST_GRID times the width. */
#define STANDIN_GRID_CHARGE 0.5
#define STANDIN_GRID_POWER (-0.4)
#define STANDIN_WIDEST_GRID 4

/* The unit of derivatives of pairs by ln B, log(2) / 2: that of f^2 has it with an exponent of 2. */
#define STANDIN_GRADIENT 0.34657359f

/* A pair has no more than this, kJ/mol. */
#define STANDIN_MOST_ENERGY 1e6f

#endif /* CT_STANDINPAIR_H_ */
