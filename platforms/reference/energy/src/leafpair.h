/* The data from which the energy of a pair of leaves is computed. */
#ifndef CT_LEAFPAIR_H_
#define CT_LEAFPAIR_H_

#include "cachelines.h"
#include "ctenergy.h"
#include "ewald.h"

/* Where the particles of a leaf are, in single precision: from a centre among them, so that rounding does not grow with
 * the scene. Centres are multiples of FRAME_GRID, so that the float from one centre to another is exact. */
typedef struct LeafFrame {
  _Alignas(CACHE_LINE) float x[CT_LEAF_WIDTH]; /* of a slot without a particle: NOWHERE */
  float y[CT_LEAF_WIDTH];
  float z[CT_LEAF_WIDTH];
  float low[3]; /* a box around all particles */
  float high[3];
  float width;      /* the sum of the box's sides */
  double centre[3]; /* in the world, nm */
} LeafFrame;

/* Two leaves a <= b that are summed over. */
typedef struct FramedPair {
  int a;
  int b;
  bool isImage; /* the first frame is shifted by box vectors */
  const LeafFrame* frames[2];
} FramedPair;

#define FRAME_GRID (1.0 / 1024) /* nm */

/* No particle is so far (nm) from another, and the square of twice this is a float. */
#define NOWHERE 1e18f

/* A factor of squared cutoffs, with which rounding loses no particle near a box. */
#define ROUNDING_OF_BOXES 1.0001f

/* The squared cutoff where there is none: it tells particles from slots without any. */
#define NO_CUTOFF (NOWHERE * NOWHERE / 100)

/* The square of a cutoff, which may be INFINITY. */
static inline float squareOfCutoff(double cutoff) {
  const double square = cutoff * cutoff;
  return square < (double)NO_CUTOFF ? (float)square : NO_CUTOFF;
}

/* Constants of the particles of a leaf; 0 in empty slots. */
typedef struct LeafColumns {
  float charge[CT_LEAF_WIDTH];  /* times the root of CT_COULOMB */
  float sigma[CT_LEAF_WIDTH];   /* half of it, nm */
  float epsilon[CT_LEAF_WIDTH]; /* twice its root */
  unsigned occupied;            /* bits: slots that hold a particle */
} LeafColumns;

/* Lennard-Jones and Coulomb as functions of the distance; see ctNonbonded. */
typedef struct Potential {
  bool hasCutoff;
  bool hasSwitch;
  bool isEwald; /* there is no reaction field */
  float squaredCutoff;
  float k; /* of the reaction field; 0 without one */
  float c;
  float switchingDistance;
  float inverseSwitchWidth;
  double exact[5]; /* cutoff^2, k, c, switching distance, inverse width */
  EwaldPolynomial ewald;
} Potential;

/* One of the two leaves of a pair. */
typedef struct LeafSide {
  const LeafFrame* frame;
  const LeafColumns* columns;
  const uint16_t* excluded; /* per slot, bits: slots of the other leaf that do not count; NULL: all do */
} LeafSide;

#endif /* CT_LEAFPAIR_H_ */
