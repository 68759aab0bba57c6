/* Generalized Born as kernels see it: what particles of a leaf have, and sums over two leaves. See ctBorn. */
#ifndef CT_BORN_H_
#define CT_BORN_H_

#include "leafpair.h"

/* What the particles of a leaf have. Where a slot holds none, radii are 1 and all else is 0. */
typedef struct BornColumns {
  float charge[CT_LEAF_WIDTH]; /* times the root of the Coulomb constant of ctBorn */
  float radius[CT_LEAF_WIDTH];
  float offsetRadius[CT_LEAF_WIDTH];
  float scaledRadius[CT_LEAF_WIDTH];
  int neckType[CT_LEAF_WIDTH];
} BornColumns;

/* Born radii of the particles of a leaf, as pair energies read them. Where a slot holds none, both are 1. */
typedef struct BornRadii {
  float radius[CT_LEAF_WIDTH];
  float inverse[CT_LEAF_WIDTH];
} BornRadii;

/* Constants of all kernels. */
typedef struct BornModel {
  int neckTypeCount; /* 0: no necks */
  /* Of the particles of each leaf, for each type of a first particle: [leaf * neckTypeCount + type]. */
  struct BornNecks* necks;
  float neckScale;
  float neckCut;
  float perDielectrics[2]; /* 1 / soluteDielectric and 1 / solventDielectric */
  float kappa;
  float shift;         /* that of ctBorn */
  float squaredCutoff; /* of ctBorn; where there is none, that of slots without a particle */
  double coulomb;
  double dielectrics[2];
  double exactKappa;
  double surfaceEnergy;
  double probeRadius;
} BornModel;

/* One of two leaves whose particles have Born sums. */
typedef struct BornSide {
  const LeafFrame* frame;
  const BornColumns* columns;
  unsigned occupied; /* bits: slots that hold a particle */
  int leaf;
} BornSide;

/* The step of what kernels of Born sums return, nm^-1: their sums in double precision are exact then, so that taking
 * out what was put in leaves the bits that were there. */
#define BORN_SUM_STEP (1.0 / (1 << 29))

#endif /* CT_BORN_H_ */
