#include "wholeenergy.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "blockgap.h"
#include "blockimages.h"

/* ---- Life ---- */

/* Lists the particles in the order of their slots, and finds the place of each. False if there is no memory. */
static bool orderParticles(WholeEnergy* whole, const int* slotOf, int* placeOf) {
  const size_t slotCount = (size_t)ctGetLeafCount(whole->tree) * CT_LEAF_WIDTH;
  int* particles = malloc((slotCount + 1) * sizeof *particles);
  if (particles == NULL) {
    return false;
  }
  for (size_t slot = 0; slot < slotCount; slot++) {
    particles[slot] = CT_NULL;
  }
  for (int i = 0; i < whole->particleCount; i++) {
    placeOf[i] = CT_NULL; /* of a particle without a slot, which is refused later */
    if (slotOf[i] != CT_NULL) {
      particles[slotOf[i]] = i;
    }
  }
  int place = 0;
  for (size_t slot = 0; slot < slotCount; slot++) {
    if (particles[slot] != CT_NULL) {
      whole->slots[place] = (int)slot;
      whole->particles[place] = particles[slot];
      placeOf[particles[slot]] = place++;
    }
  }
  free(particles);
  return true;
}

ctStatus ctWholeEnergyCreate(WholeEnergy* whole, ctChainTree* tree, int particleCount, const ctNonbonded* nonbonded,
                             const ctBorn* born, const int* slotOf, char* errorText, size_t errorSize) {
  const int blockCount = (particleCount + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH;
  const size_t blocks = (size_t)blockCount + 1;
  int* placeOf = malloc(((size_t)particleCount + 1) * sizeof *placeOf);
  *whole = (WholeEnergy){
      .tree = tree,
      .wide = ctFindWide(ctGetInstructionSet(tree)),
      .particleCount = particleCount,
      .blockCount = blockCount,
      .slots = malloc(blocks * CT_LEAF_WIDTH * sizeof *whole->slots),
      .particles = malloc(blocks * CT_LEAF_WIDTH * sizeof *whole->particles),
      .frames = allocateLines(blocks, sizeof *whole->frames),
      .radii = calloc(blocks, sizeof *whole->radii),
      .sums = malloc(blocks * CT_LEAF_WIDTH * sizeof *whole->sums),
  };
  ctStatus status = ctOutOfMemory;
  if (placeOf == NULL || whole->slots == NULL || whole->particles == NULL || whole->frames == NULL ||
      whole->radii == NULL || whole->sums == NULL || !orderParticles(whole, slotOf, placeOf)) {
    snprintf(errorText, errorSize, "out of memory");
  } else {
    status = ctNonbondedCreate(&whole->nonbonded, tree, particleCount, nonbonded, placeOf, errorText, errorSize);
    if (status == ctSuccess) {
      status = ctBornCreate(&whole->born, blockCount, particleCount, born, placeOf, errorText, errorSize);
    }
  }
  free(placeOf);
  if (status != ctSuccess) {
    ctWholeEnergyFree(whole);
  }
  return status;
}

void ctWholeEnergyFree(WholeEnergy* whole) {
  free(whole->slots);
  free(whole->particles);
  freeLines(whole->frames);
  free(whole->radii);
  free(whole->sums);
  ctNonbondedFree(&whole->nonbonded);
  ctBornFree(&whole->born);
  *whole = (WholeEnergy){0};
}

/* ---- Frames ---- */

/* Where places without a particle are (nm, from the middle of their block): away from particles, but at no distance
 * whose powers are too small for a normal float, with which processors take long. */
#define ASIDE 1e3f

/* Places blocks, wrapped in a periodic box. False if there is no memory. */
static bool makeFrames(WholeEnergy* whole) {
  const ctLeafPositions* leaves = ctGetLeaves(whole->tree);
  double box[3][3];
  if (leaves == NULL) {
    return false;
  }
  whole->isPeriodic = ctGetBox(whole->tree, box);
  if (whole->isPeriodic) {
    whole->box = makePeriodicBox((const double(*)[3])box);
  }
  for (int block = 0; block < whole->blockCount; block++) {
    ctLeafPositions positions = {.x = {0}};
    LeafFrame* frame = &whole->frames[block];
    const int* slots = whole->slots + CT_LEAF_WIDTH * block;
    const int left = whole->particleCount - CT_LEAF_WIDTH * block;
    const int count = left < CT_LEAF_WIDTH ? left : CT_LEAF_WIDTH;
    for (int k = 0; k < count; k++) {
      const ctLeafPositions* leaf = &leaves[slots[k] / CT_LEAF_WIDTH];
      positions.x[k] = leaf->x[slots[k] % CT_LEAF_WIDTH];
      positions.y[k] = leaf->y[slots[k] % CT_LEAF_WIDTH];
      positions.z[k] = leaf->z[slots[k] % CT_LEAF_WIDTH];
    }
    if (whole->isPeriodic) {
      ctWrapBlock(&whole->box, count, &positions);
    }
    whole->wide->makeFrame(&positions, whole->nonbonded.columns[block].occupied, frame);
    for (int k = count; k < CT_LEAF_WIDTH; k++) {
      frame->x[k] = frame->y[k] = frame->z[k] = ASIDE;
    }
  }
  return true;
}

/* ---- Periodic images ---- */

typedef void ImageFunction(WholeEnergy* whole, int a, const LeafFrame* image, int b, WholePair* total);

/* Calls a function for each block with itself, with those after it, and with images within a cutoff. */
static void forEachImage(WholeEnergy* whole, double cutoff, ImageFunction* function, WholePair* total) {
  BlockImages near;
  LeafFrame shifted;
  for (int a = 0; a < whole->blockCount; a++) {
    for (int b = a; b < whole->blockCount; b++) {
      const LeafFrame* frame = &whole->frames[a];
      ctFindBlockImages(&whole->box, frame, &whole->frames[b], cutoff, &near);
      for (int i = 0; i < near.count; i++) {
        const int* image = near.images[i];
        if (a == b && !isFirstOfOpposite(image)) {
          continue;
        }
        if (isShifted(image)) {
          shiftFrame(frame, (const double(*)[3])whole->box.vectors, image, &shifted);
        }
        function(whole, a, isShifted(image) ? &shifted : frame, b, total);
      }
    }
  }
}

/* ---- Born radii ---- */

static void addImageSums(WholeEnergy* whole, int a, const LeafFrame* image, int b, WholePair* total) {
  const BornModel* model = &whole->born.model;
  (void)total;
  if (image == &whole->frames[a]) {
    whole->wide->bornSums(model, model->squaredCutoff, whole->frames, whole->born.columns, a, b, b + 1, whole->sums);
  } else {
    whole->wide->bornImageSums(model, model->squaredCutoff, image, whole->frames, whole->born.columns, a, b,
                               whole->sums);
  }
}

static void computeSums(WholeEnergy* whole) {
  const BornModel* model = &whole->born.model;
  for (int i = 0; i < whole->blockCount * CT_LEAF_WIDTH; i++) {
    whole->sums[i] = 0;
  }
  if (whole->isPeriodic) {
    forEachImage(whole, sqrt(model->exactCutoff), addImageSums, NULL);
    return;
  }
  for (int block = 0; block < whole->blockCount; block++) {
    whole->wide->bornSums(model, model->squaredCutoff, whole->frames, whole->born.columns, block, block,
                          whole->blockCount, whole->sums);
  }
}

/* Sets Born radii by the sums; returns the energy of particles by themselves, or NaN if some radius is none. */
static double computeRadii(WholeEnergy* whole) {
  const BornModel* model = &whole->born.model;
  double energy = 0;
  for (int place = 0; place < whole->blockCount * CT_LEAF_WIDTH; place++) {
    BornRadii* radii = &whole->radii[place / CT_LEAF_WIDTH];
    const int k = place % CT_LEAF_WIDTH;
    double radius = 1;
    if (place < whole->particleCount) {
      const BornParticle* particle = &whole->born.particles[place];
      radius = ctBornRadius(model, particle, whole->sums[place]);
      energy += radius > 0 && isfinite(radius) ? ctBornSelfEnergy(model, particle, radius) : NAN;
    }
    radii->radius[k] = (float)radius;
    radii->inverse[k] = (float)(1 / radius);
    radii->rate[k] = (float)(-0.36067376022224085 / radius);
    radii->root[k] = (float)sqrt(0.5 / radius);
  }
  return energy;
}

/* ---- Energies ---- */

static WholeLeaves leavesOf(const WholeEnergy* whole) {
  return (WholeLeaves){whole->frames, whole->nonbonded.columns, whole->born.columns, whole->radii};
}

/* Adds the pairs of block a with those from `first` to `end`, without cutoffs. */
static void addRun(const WholeEnergy* whole, int a, int first, int end, const uint16_t* excluded, WholePair* total) {
  const BornModel* model = &whole->born.model;
  const WholeLeaves leaves = leavesOf(whole);
  const WholePair run = whole->wide->wholePairs(model, &leaves, a, first, end, excluded);
  total->born += run.born;
  if (isfinite(run.nonbonded)) {
    total->nonbonded += run.nonbonded;
    return;
  }
  for (int b = first; b < end; b++) {
    const WholePair pair = whole->wide->wholePairs(model, &leaves, a, b, b + 1, excluded);
    total->nonbonded += isfinite(pair.nonbonded)
                            ? pair.nonbonded
                            : ctNonbondedEnergy(&whole->nonbonded, a, &whole->frames[a], b, &whole->frames[b]);
  }
}

/* Adds the pairs of block a with itself and those after it, without cutoffs. */
static void addBlock(const WholeEnergy* whole, int a, WholePair* total) {
  const PairMask* mask = &whole->nonbonded.mask;
  int first = a;
  for (int n = mask->begin[a]; n < mask->begin[a + 1]; n++) {
    const int partner = mask->partners[n];
    if (partner < a) {
      continue;
    }
    if (first < partner) {
      addRun(whole, a, first, partner, NULL, total);
    }
    addRun(whole, a, partner, partner + 1, mask->bits[n], total);
    first = partner + 1;
  }
  if (first < whole->blockCount) {
    addRun(whole, a, first, whole->blockCount, NULL, total);
  }
}

/* Adds the pairs of blocks a <= b, the first in this frame, with cutoffs or without. */
static void addBlocks(WholeEnergy* whole, int a, const LeafFrame* frameA, int b, WholePair* total) {
  const BornModel* model = &whole->born.model;
  const LeafFrame* frames = whole->frames;
  const WholeLeaves leaves = leavesOf(whole);
  const double gap = squaredGap(frameA, &frames[b]);
  if (gap < whole->nonbonded.potential.exact[0]) {
    const FramedPair pair = {a, b, frameA != &frames[a], {frameA, &frames[b]}};
    double energy;
    ctNonbondedEnergies(&whole->nonbonded, 1, &pair, &energy);
    total->nonbonded += energy;
  }
  if (gap < model->exactCutoff) {
    WholeSide sideA = wholeSide(&leaves, a, NULL);
    const WholeSide sideB = wholeSide(&leaves, b, NULL);
    sideA.frame = frameA;
    total->born += whole->wide->bornPair(model, &sideA, &sideB);
  }
}

ctStatus ctWholeEnergyCompute(WholeEnergy* whole, double* nonbonded, double* born) {
  if (!makeFrames(whole)) {
    return ctOutOfMemory;
  }
  computeSums(whole);
  WholePair total = {.born = computeRadii(whole)};
  const BornModel* model = &whole->born.model;
  const bool isPlain = !whole->nonbonded.potential.hasCutoff && !model->hasCutoff && model->shift == 0;
  if (whole->isPeriodic) {
    const double squaredCutoff = fmax(model->exactCutoff, whole->nonbonded.potential.exact[0]);
    forEachImage(whole, sqrt(squaredCutoff), addBlocks, &total);
  }
  for (int a = 0; a < whole->blockCount && !whole->isPeriodic; a++) {
    if (isPlain) {
      addBlock(whole, a, &total);
      continue;
    }
    for (int b = a; b < whole->blockCount; b++) {
      addBlocks(whole, a, &whole->frames[a], b, &total);
    }
  }
  *nonbonded = total.nonbonded;
  *born = isnan(total.born) ? NAN : total.born; /* one NaN, whatever the instruction set */
  return ctSuccess;
}

ctStatus ctWholeEnergyBornSums(WholeEnergy* whole, double* sums) {
  if (!makeFrames(whole)) {
    return ctOutOfMemory;
  }
  computeSums(whole);
  for (int place = 0; place < whole->particleCount; place++) {
    sums[whole->particles[place]] = whole->sums[place];
  }
  return ctSuccess;
}
