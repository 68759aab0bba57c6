/* Where the particles of a leaf are on a grid over the world: from these numbers the distance of two particles follows
 * with the same bits whatever else is in their leaves. */
#ifndef CT_LEAFGRID_H_
#define CT_LEAFGRID_H_

#include "ctenergy.h"

/* Steps of the grid in a nanometre. Numbers of steps are kept without what is beyond 32 bits, that is 32 nm. */
#define GRID_STEPS 0x1p27
#define SQUARED_GRID_STEP 0x1p-54f

/* nm. Particles within the greatest cutoff of such sums are told from those that are 32 nm farther away if no particle
 * of either leaf is beyond a reach from the first one of its leaf; else one by one. */
#define MOST_GRID_CUTOFF 8.0
#define MOST_GRID_REACH 3.0

typedef struct LeafGrid {
  int x[CT_LEAF_WIDTH]; /* of a slot without a particle: as the first that has one */
  int y[CT_LEAF_WIDTH];
  int z[CT_LEAF_WIDTH];
  int low[3]; /* a box around all particles, unless it is wide */
  int high[3];
  bool isWide;                      /* some particle is beyond the reach */
  const ctLeafPositions* positions; /* in double */
} LeafGrid;

/* The difference of two numbers of steps, which may be 32 nm off. */
static inline int gridDifference(int a, int b) {
  return (int)((unsigned)a - (unsigned)b);
}

#endif /* CT_LEAFGRID_H_ */
