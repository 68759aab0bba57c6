/* Generalized Born as wide functions see it: what particles of a leaf have, and sums over two leaves. See ctBorn. A
 * leaf is any sixteen slots here: those of the scene, or others. */
#ifndef CT_BORN_H_
#define CT_BORN_H_

#include "leafpair.h"

/* Constants of the particles of a leaf. In an empty slot, radii and offset radii are 1 and all else is 0. */
typedef struct BornColumns {
  float charge[CT_LEAF_WIDTH]; /* times the root of the Coulomb constant of ctBorn */
  float radius[CT_LEAF_WIDTH];
  float offsetRadius[CT_LEAF_WIDTH];
  float scaledRadius[CT_LEAF_WIDTH];
  float squaredScaled[CT_LEAF_WIDTH]; /* its square, and its cube with the sign */
  float cubedScaled[CT_LEAF_WIDTH];
  /* Factors of r^-4, r^-6 ... of their contributions up to BORN_REMOTE_RATIO and BORN_FAR_RATIO. */
  float remote[3][CT_LEAF_WIDTH];
  float far[5][CT_LEAF_WIDTH];
  float neckReach[CT_LEAF_WIDTH]; /* from the surface of another particle */
  int neckType[CT_LEAF_WIDTH];
  unsigned occupied; /* bits: slots that hold a particle */
} BornColumns;

/* Necks between a particle of some type and each particle of a leaf: their part of its Born sum, and of theirs. */
typedef struct BornNecks {
  float heightForOne[CT_LEAF_WIDTH]; /* times neckScale; 0 where a slot holds none */
  float distanceForOne[CT_LEAF_WIDTH];
  float heightForLeaf[CT_LEAF_WIDTH];
  float distanceForLeaf[CT_LEAF_WIDTH];
} BornNecks;

/* Born radii of the particles of a leaf, as pair energies read them. Where a slot holds none, they are 1. */
typedef struct BornRadii {
  float radius[CT_LEAF_WIDTH];
  float inverse[CT_LEAF_WIDTH];
  float rate[CT_LEAF_WIDTH]; /* -log2(e) / (4 R) */
  float root[CT_LEAF_WIDTH]; /* (2 R)^(-1/2) */
} BornRadii;

/* The constants from which the Born radius and the self energy of a particle are computed. */
typedef struct BornParticle {
  double charge;
  double radius;
  double offsetRadius;
  double alpha;
  double beta;
  double gamma;
} BornParticle;

/* Constants of all wide functions. */
typedef struct BornModel {
  int neckTypeCount; /* 0: no necks */
  bool hasCutoff;
  bool isRescaled;
  bool isFilled;
  const BornNecks* necks; /* of each leaf with a particle of each type: [leaf * neckTypeCount + type] */
  float neckCut;
  /* No particles farther apart than this can overlap, or have s / r above BORN_FAR_RATIO; have it above
   * BORN_REMOTE_RATIO; have a neck; any of these. */
  float squaredNear;
  float squaredFar;
  float squaredNeckReach;
  float squaredReach;
  float squaredLeastNeckReach; /* within this, all have necks */
  float perDielectrics[2];     /* 1 / soluteDielectric and 1 / solventDielectric */
  float kappa;
  float shift;         /* that of ctBorn */
  float squaredCutoff; /* of ctBorn; where there is none, that of slots without a particle */
  double coulomb;
  double dielectrics[2];
  double exactKappa;
  double exactShift;
  double exactCutoff; /* squared, nm^2 */
  double surfaceEnergy;
  double probeRadius;
} BornModel;

/* One of two leaves whose particles have Born sums. */
typedef struct BornSide {
  const LeafFrame* frame;
  const BornColumns* columns;
  unsigned occupied; /* bits: slots that count, each with a particle */
  int leaf;
} BornSide;

/* The step of the Born sums that wide functions return, nm^-1: their sums in double precision are exact then, so that
 * taking out what was put in leaves the bits that were there. */
#define BORN_SUM_STEP (1.0 / (1 << 29))

/* s / r up to which shorter and longer series hold, where spheres do not overlap. */
#define BORN_REMOTE_RATIO 0.16
#define BORN_REMOTE_SERIES \
  { 0.3333335752f, 0.3998299556f, 0.4461475734f }
#define BORN_FAR_RATIO 0.35
#define BORN_FAR_SERIES \
  { 0.3333333673f, 0.3999861014f, 0.4294699158f, 0.4244512686f, 0.6296422579f }
#define BORN_NEAR_RATIO 0.62

typedef struct Born {
  BornModel model;
  int leafCount;
  BornColumns* columns;    /* per leaf */
  BornParticle* particles; /* per slot */
  BornNecks* necks;        /* that of the model */
} Born;

/* Makes what wide functions need of a description, for particles in leafCount leaves; slotOf[particle] is its slot. On
 * failure nothing has to be freed and errorText (which may not be NULL) says why. */
ctStatus ctBornCreate(Born* born, int leafCount, int particleCount, const ctBorn* d, const int* slotOf, char* errorText,
                      size_t errorSize);
void ctBornFree(Born* born);

/* The Born radius of a particle with this Born sum, nm. */
double ctBornRadius(const BornModel* model, const BornParticle* particle, double sum);

/* The self energy of a particle: of its charge, and of its surface. */
double ctBornSelfEnergy(const BornModel* model, const BornParticle* particle, double bornRadius);

#endif /* CT_BORN_H_ */
