/* Radii of the stand-in, and energies of single particles. */
#include "elementary.h"
#include "set.h"
#include "sums.h"

/* tanh(t) */
CT_INLINE Float16 tanhOf(Float16 t) {
  const Float16 bounded = min16(max16(add16(t, t), all16(-40)), all16(40));
  return sub16(all16(1), div16(all16(2), add16(exp16(bounded), all16(1))));
}

/* A Born radius has to be positive, however large its sum. */
#define STANDIN_LEAST_INVERSE 0.01f /* 1/nm */

void CT_WIDE(standInRadii)(const StandInModel* model, const StandInConstants* constants,
                           const double born[CT_LEAF_WIDTH], StandInRadii* radii) {
  float sums[CT_LEAF_WIDTH];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] = (float)(born[k] + constants->far[k]);
  }
  const Float16 sum = load16(sums);
  Float16 inverse = sub16(load16(constants->perOffsetRadius), sum);
  if (model->isRescaled) {
    const Float16 psi = mul16(sum, load16(constants->offsetRadius));
    const Float16 inner = sub16(mul16(psi, load16(constants->gamma)), load16(constants->beta));
    const Float16 t = mul16(psi, add16(load16(constants->alpha), mul16(psi, inner)));
    inverse = sub16(load16(constants->perOffsetRadius), mul16(tanhOf(t), load16(constants->perRadius)));
  }
  inverse = max16(inverse, all16(STANDIN_LEAST_INVERSE));
  const Float16 log = sub16(all16(0), log16(inverse));
  const Float16 magic = all16(CT_WHOLE_MAGIC);
  const Float16 number = sub16(add16(mul16(log, load16(constants->perGridWidth)), magic), magic);
  const Float16 ofGrid = mul16(number, load16(constants->gridWidth));
  const Float16 inverseOfGrid = exp16(sub16(all16(0), ofGrid));
  Float16 perDielectric = sub16(all16(model->perDielectrics[0]), all16(model->perDielectrics[1]));
  if (model->hasKappa) {
    const Float16 screening = exp16(div16(all16(-model->kappa), inverse));
    perDielectric = sub16(all16(model->perDielectrics[0]), mul16(screening, all16(model->perDielectrics[1])));
  }
  const Float16 inverse3 = mul16(mul16(inverse, inverse), inverse);
  const Float16 ofCharge = mul16(mul16(load16(constants->squaredCharge), perDielectric), inverse);
  const Float16 ofSurface = mul16(mul16(load16(constants->surface), inverse3), inverse3);
  store16(radii->radius, div16(all16(1), inverseOfGrid));
  store16(radii->decay, mul16(all16(0.60056120f), inverseOfGrid)); /* root of log2(e) / 4 */
  store16(radii->log, ofGrid);
  store16(radii->beyond, mul16(all16(STANDIN_GRADIENT), sub16(log, ofGrid)));
  store16(radii->self, sub16(ofSurface, ofCharge));
}

/* What depends on radii of the grid alone. */
void CT_WIDE(standInShift)(const StandInModel* model, const float charge[CT_LEAF_WIDTH], const StandInRadii* radii,
                           StandInShift* shift) {
  const Float16 t = mul16(sub16(load16(radii->log), all16(model->middleLog)), all16(model->perHalfWidth));
  const Float16 bounded = max16(min16(t, all16(1)), all16(-1));
  for (int i = 0; i < SHIFT_RANK; i++) {
    store16(shift->value[i], mul16(load16(charge), polynomial16(bounded, SHIFT_TERMS - 1, model->shift[i])));
  }
}

/* Exchanges parts of sums; false, and nothing changed, if they are the same. */
bool CT_WIDE(exchangeParts)(double sums[CT_LEAF_WIDTH], const float before[CT_LEAF_WIDTH],
                            const float after[CT_LEAF_WIDTH]) {
  const Float16 from = load16(before);
  const Float16 to = load16(after);
  if ((greater16(from, to) | greater16(to, from)) == 0) {
    return false;
  }
  storeSum16(sums, addToSum16(addToSum16(loadSum16(sums), to), sub16(all16(0), from)));
  return true;
}

/* The self energies of the particles of a leaf, and the first order of the neglect of pairs by the grid. */
double CT_WIDE(standInLeafEnergy)(const StandInRadii* radii, const double gradient[CT_LEAF_WIDTH]) {
  double sums[CT_LEAF_WIDTH];
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sums[k] = (double)radii->self[k] + gradient[k] * (double)radii->beyond[k];
  }
  for (int width = CT_LEAF_WIDTH / 2; width > 0; width /= 2) {
    for (int k = 0; k < width; k++) {
      sums[k] += sums[k + width];
    }
  }
  return sums[0];
}
