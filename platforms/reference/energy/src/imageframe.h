/* Periodic images of leaves: the same frame, shifted by box vectors. */
#ifndef CT_IMAGEFRAME_H_
#define CT_IMAGEFRAME_H_

#include <math.h>

#include "leafpair.h"

/* True if these numbers of box vectors are an image, not the scene itself. */
static inline bool isShifted(const int image[3]) {
  return image[0] != 0 || image[1] != 0 || image[2] != 0;
}

/* The sum of these numbers of box vectors. */
static inline void imageShift(const double box[3][3], const int image[3], double shift[3]) {
  for (int d = 0; d < 3; d++) {
    shift[d] = image[2] * box[2][d] + image[1] * box[1][d] + image[0] * box[0][d];
  }
}

/* Shifts a frame by these numbers of box vectors. The part of the shift that is on the grid moves the centre; the rest,
 * which is no larger than half of the grid, moves particles within the leaf. */
static inline void shiftFrame(const LeafFrame* frame, const double box[3][3], const int image[3], LeafFrame* shifted) {
  const float* axes[3] = {frame->x, frame->y, frame->z};
  float* to[3] = {shifted->x, shifted->y, shifted->z};
  double shift[3];
  imageShift(box, image, shift);
  shifted->width = frame->width;
  for (int d = 0; d < 3; d++) {
    const double onGrid = rint(shift[d] * (1 / FRAME_GRID)) * FRAME_GRID;
    const float rest = (float)(shift[d] - onGrid);
    shifted->centre[d] = frame->centre[d] + onGrid;
    shifted->low[d] = frame->low[d] + rest;
    shifted->high[d] = frame->high[d] + rest;
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      to[d][k] = axes[d][k] + rest;
    }
  }
}

#endif /* CT_IMAGEFRAME_H_ */
