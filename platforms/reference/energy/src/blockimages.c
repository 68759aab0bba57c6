#include "blockimages.h"

#include <string.h>

void ctWrapBlock(const PeriodicBox* box, int count, ctLeafPositions* positions) {
  const double first[3] = {positions->x[0], positions->y[0], positions->z[0]};
  for (int k = 1; k < count; k++) {
    double image[3];
    nearestImage(box, first, (const double[3]){positions->x[k], positions->y[k], positions->z[k]}, image);
    positions->x[k] = image[0];
    positions->y[k] = image[1];
    positions->z[k] = image[2];
  }
}

/* How far block a can be shifted along each axis. */
typedef struct ShiftRange {
  double low[3];
  double high[3];
} ShiftRange;

/* Adds the images with the given numbers of vectors after vector k. */
static void addImages(const PeriodicBox* box, const ShiftRange* range, int k, int image[3], BlockImages* found) {
  if (k < 0) {
    if (found->count < MOST_BLOCK_IMAGES) {
      memcpy(found->images[found->count++], image, 3 * sizeof *image);
    }
    return;
  }
  double later = 0;
  for (int l = k + 1; l < 3; l++) {
    later += image[l] * box->vectors[l][k];
  }
  const int end = (int)floor((range->high[k] - later) / box->vectors[k][k]);
  for (image[k] = (int)ceil((range->low[k] - later) / box->vectors[k][k]); image[k] <= end; image[k]++) {
    addImages(box, range, k - 1, image, found);
  }
}

void ctFindBlockImages(const PeriodicBox* box, const LeafFrame* a, const LeafFrame* b, double reach,
                       BlockImages* found) {
  if (box == NULL) {
    found->count = 1;
    memset(found->images[0], 0, sizeof found->images[0]);
    return;
  }
  /* Rounding must lose no pair. */
  const double margin = reach * 1e-5 + FRAME_GRID;
  ShiftRange range;
  int image[3];
  for (int d = 0; d < 3; d++) {
    const double apart = b->centre[d] - a->centre[d];
    range.low[d] = apart + (double)b->low[d] - (double)a->high[d] - reach - margin;
    range.high[d] = apart + (double)b->high[d] - (double)a->low[d] + reach + margin;
  }
  found->count = 0;
  addImages(box, &range, 2, image, found);
}
