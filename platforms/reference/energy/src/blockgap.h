/* How far apart two blocks of particles are. */
#ifndef CT_BLOCKGAP_H_
#define CT_BLOCKGAP_H_

#include "leafpair.h"

/* The squared distance of the boxes of two blocks, rounded down a little. */
static inline double squaredGap(const LeafFrame* a, const LeafFrame* b) {
  double squared = 0;
  for (int d = 0; d < 3; d++) {
    const double shift = b->centre[d] - a->centre[d];
    const double below = shift + (double)b->low[d] - (double)a->high[d];
    const double above = (double)a->low[d] - (double)b->high[d] - shift;
    const double apart = below > above ? below : above;
    squared += apart > 0 ? apart * apart : 0;
  }
  return squared * (1 - 1e-5);
}

#endif /* CT_BLOCKGAP_H_ */
