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

/* What all leaves have, one entry a leaf. */
typedef struct WholeLeaves {
  const LeafFrame* frames;
  const LeafColumns* columns;
  const BornColumns* born;
  const BornRadii* radii;
} WholeLeaves;

static inline WholeSide wholeSide(const WholeLeaves* leaves, int leaf, const uint16_t* excluded) {
  return (WholeSide){&leaves->frames[leaf], &leaves->columns[leaf], &leaves->born[leaf], &leaves->radii[leaf],
                     excluded};
}

/* Energies of pairs of particles. */
typedef struct WholePair {
  double nonbonded; /* not finite where single precision does not suffice */
  double born;
} WholePair;

#endif /* CT_WHOLEPAIR_H_ */
