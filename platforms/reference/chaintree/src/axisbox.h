/* Boxes along the world's axes. */
#ifndef CT_AXISBOX_H_
#define CT_AXISBOX_H_

#include <math.h>

#include "order.h"

/* Around the members of a node; low above high: the member has no particles. */
typedef struct AxisBoxes {
  float low[3][TREE_WIDTH];
  float high[3][TREE_WIDTH];
} AxisBoxes;

static inline void clearAxisBoxes(AxisBoxes* boxes) {
  for (int d = 0; d < 3; d++) {
    for (int k = 0; k < TREE_WIDTH; k++) {
      boxes->low[d][k] = INFINITY;
      boxes->high[d][k] = -INFINITY;
    }
  }
}

#endif /* CT_AXISBOX_H_ */
