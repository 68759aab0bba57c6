/* Leaves in single precision. */
#include <math.h>

#include "set.h"
#include "simd.h"

/* One coordinate from a centre, rounded to float. */
CT_INLINE Float16 fromCentre(const double* positions, double centre) {
  float from[CT_LEAF_WIDTH];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    from[k] = (float)(positions[k] - centre);
  }
  return load16(from);
}

static double onGrid(double x) {
  return rint(x * (1 / FRAME_GRID)) * FRAME_GRID;
}

void CT_WIDE(makeFrame)(const ctLeafPositions* positions, unsigned occupied, LeafFrame* frame) {
  const double* axes[3] = {positions->x, positions->y, positions->z};
  float* placed[3] = {frame->x, frame->y, frame->z};
  const int first = __builtin_ctz(occupied);
  for (int d = 0; d < 3; d++) {
    /* The middle of the box, from any particle. */
    const double about = onGrid(axes[d][first]);
    const Float16 rough = fromCentre(axes[d], about);
    const double low = (double)least16(blend16(occupied, all16(INFINITY), rough));
    const double high = (double)most16(blend16(occupied, all16(-INFINITY), rough));
    const double centre = about + onGrid((low + high) / 2);
    const Float16 x = fromCentre(axes[d], centre);
    frame->centre[d] = centre;
    frame->low[d] = least16(blend16(occupied, all16(INFINITY), x));
    frame->high[d] = most16(blend16(occupied, all16(-INFINITY), x));
    store16(placed[d], blend16(occupied, all16(NOWHERE), x));
  }
}
