/* What whole energies of two leaves are computed from. */
#ifndef CT_WHOLEPAIR_H_
#define CT_WHOLEPAIR_H_

#include "born.h"

/* One of two leaves. */
typedef struct WholeSide {
  const LeafFrame* frame;
  const LeafColumns* columns;
  const BornColumns* born;
  const BornRadii* radii;
  const uint16_t* excluded; /* as in LeafSide */
} WholeSide;

/* Energies of all pairs of particles of two leaves. */
typedef struct WholePair {
  double nonbonded; /* not finite where single precision does not suffice */
  double born;
} WholePair;

#endif /* CT_WHOLEPAIR_H_ */
