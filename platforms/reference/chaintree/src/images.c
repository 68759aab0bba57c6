#include "images.h"

#include <string.h>

#include "chaintree.h"
#include "transform.h"

void ctImageShift(const PeriodicBox* box, const int n[3], double shift[3]) {
  for (int d = 0; d < 3; d++) {
    shift[d] = n[2] * box->vectors[2][d] + n[1] * box->vectors[1][d] + n[0] * box->vectors[0][d];
  }
}

Image ctImageOf(const PeriodicBox* box, const int n[3]) {
  Image image = {{n[0], n[1], n[2]}, {0, 0, 0}};
  if (isImage(&image)) {
    ctImageShift(box, n, image.shift);
  }
  return image;
}

/* Starts the count of a vector, given those of later vectors: each reaches into the dimensions of earlier ones alone.
 */
static void beginVector(ImageRange* range, int k) {
  const double(*v)[3] = range->box->vectors;
  double later = 0;
  for (int l = k + 1; l < 3; l++) {
    later += range->image.n[l] * v[l][k];
  }
  range->image.n[k] = (int)larger(ceil((range->low[k] - later) / v[k][k]), -MOST_VECTORS);
  range->end[k] = (int)lesser(floor((range->high[k] - later) / v[k][k]), MOST_VECTORS) + 1;
}

static bool advance(ImageRange* range, int k) {
  int* n = range->image.n;
  if (k == 3) {
    return false;
  }
  n[k]++;
  while (n[k] >= range->end[k]) {
    if (!advance(range, k + 1)) {
      return false;
    }
    beginVector(range, k);
  }
  return true;
}

ImageRange ctImageRange(const PeriodicBox* box, const double lowA[3], const double highA[3], const double lowB[3],
                        const double highB[3], double reach) {
  ImageRange range = {.box = box};
  for (int d = 0; d < 3; d++) {
    if (!(lowA[d] <= highA[d] && lowB[d] <= highB[d])) {
      return range; /* one is empty */
    }
    range.low[d] = lowB[d] - highA[d] - reach;
    range.high[d] = highB[d] - lowA[d] + reach;
  }
  beginVector(&range, 2);
  range.image.n[2]--;
  return range;
}

bool ctNextImage(ImageRange* range) {
  do {
    if (!advance(range, 0)) {
      return false;
    }
  } while (!isImage(&range->image));
  ctImageShift(range->box, range->image.n, range->image.shift);
  return true;
}

Image ctNearestImage(const PeriodicBox* box, const double apart[3]) {
  Image image;
  double left[3] = {apart[0], apart[1], apart[2]};
  for (int k = 2; k >= 0; k--) {
    const double count = -floor(left[k] / box->vectors[k][k] + 0.5);
    image.n[k] = (int)larger(lesser(count, MOST_VECTORS), -MOST_VECTORS);
    for (int d = 0; d <= k; d++) {
      left[d] += image.n[k] * box->vectors[k][d];
    }
  }
  ctImageShift(box, image.n, image.shift);
  return image;
}

PeriodicBox ctPeriodicBox(const double (*v)[3]) {
  PeriodicBox box = {.isPeriodic = true};
  memcpy(box.vectors, v, sizeof box.vectors);
  const double shear = v[2][1] / v[1][1]; /* of the second vector, in one of the third */
  box.inverse[0][0] = 1 / v[0][0];
  box.inverse[0][1] = -v[1][0] / (v[0][0] * v[1][1]);
  box.inverse[0][2] = (shear * v[1][0] - v[2][0]) / (v[0][0] * v[2][2]);
  box.inverse[1][1] = 1 / v[1][1];
  box.inverse[1][2] = -shear / v[2][2];
  box.inverse[2][2] = 1 / v[2][2];
  for (int k = 0; k < 3; k++) {
    box.across[k] = sqrt(dot(box.inverse[k], box.inverse[k]));
  }
  return box;
}

double ctBoxWidth(const PeriodicBox* box) {
  return lesser(lesser(box->vectors[0][0], box->vectors[1][1]), box->vectors[2][2]);
}

const char* ctFindBoxFault(const double (*v)[3]) {
  for (int k = 0; k < 3; k++) {
    for (int d = 0; d < 3; d++) {
      if (!(fabs(v[k][d]) <= CT_MOST_LENGTH)) {
        return "must be finite and at most 1e15 nm long";
      }
    }
    if (!(v[k][k] > 0)) {
      return "must have a positive volume";
    }
  }
  if (v[0][1] != 0 || v[0][2] != 0 || v[1][2] != 0) {
    return "must be in reduced form: the first along x, the second in the xy plane";
  }
  /* OpenMM's reduced form, with its allowance for rounding. */
  if (fabs(v[1][0]) > 0.5000001 * v[0][0] || fabs(v[2][0]) > 0.5000001 * v[0][0] ||
      fabs(v[2][1]) > 0.5000001 * v[1][1]) {
    return "must be in reduced form: the components of later vectors along earlier ones at most half of these";
  }
  return NULL;
}
