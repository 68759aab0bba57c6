#include "valueenergy.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "blockgap.h"
#include "blockimages.h"
#include "checks.h"

/* ---- Life ---- */

/* False if there is no memory. `start` are numbers of particles that parameters begin, values being 0. */
static bool createTape(ValueTape* made, const ValueEnergy* energy, const ctValueEnergy* d,
                       const ctValueExpression* expression, const double* start) {
  const ctPairSet set = {.operationCount = expression->operationCount,
                         .operations = expression->operations,
                         .tableCount = expression->tableCount,
                         .tables = expression->tables,
                         .parametersPerParticle = countReadable(d, expression->extent),
                         .parameters = start};
  made->extent = expression->extent;
  return expression->extent == ctOfParticles ? ctPairExpressionCreate(&made->expression, &set)
                                             : ctTapeCreate(&made->tape, &set, d->parametersPerParticle,
                                                            energy->particleCount, energy->blockCount, energy->places);
}

static void freeTapes(ValueTape* tapes, int count) {
  for (int i = 0; tapes != NULL && i < count; i++) {
    ctPairExpressionFree(&tapes[i].expression);
    ctTapeFree(&tapes[i].tape);
  }
  free(tapes);
}

static bool createTapes(ValueEnergy* energy, const ctValueEnergy* d) {
  const size_t each = (size_t)d->parametersPerParticle;
  const size_t stride = each + (size_t)d->valueCount;
  double* start = calloc((size_t)energy->particleCount * stride + 1, sizeof *start);
  for (size_t i = 0; start != NULL && each > 0 && i < (size_t)energy->particleCount; i++) {
    memcpy(start + i * stride, d->parameters + i * each, each * sizeof *start);
  }
  bool isMade = start != NULL;
  for (int i = 0; i < d->valueCount && isMade; i++) {
    isMade = createTape(&energy->values[i], energy, d, &d->values[i], start);
  }
  for (int i = 0; i < d->termCount && isMade; i++) {
    isMade = createTape(&energy->terms[i], energy, d, &d->terms[i], start);
  }
  free(start);
  return isMade;
}

static bool build(ValueEnergy* energy, const ctValueEnergy* d) {
  const size_t count = (size_t)energy->particleCount;
  const size_t each = (size_t)d->parametersPerParticle;
  energy->places = malloc((count + 1) * sizeof *energy->places);
  energy->numbers = calloc(count * (size_t)energy->numbersPerParticle + 1, sizeof *energy->numbers);
  energy->values = calloc((size_t)d->valueCount + 1, sizeof *energy->values);
  energy->terms = calloc((size_t)d->termCount + 1, sizeof *energy->terms);
  energy->frames = allocateLines((size_t)energy->blockCount + 1, sizeof *energy->frames);
  energy->sums = malloc(((size_t)energy->blockCount + 1) * CT_LEAF_WIDTH * sizeof *energy->sums);
  energy->positions = malloc((count + 1) * sizeof *energy->positions);
  if (energy->places == NULL || energy->numbers == NULL || energy->values == NULL || energy->terms == NULL ||
      energy->frames == NULL || energy->sums == NULL || energy->positions == NULL) {
    return false;
  }
  for (size_t i = 0; i < count; i++) {
    energy->places[i] = (int)i;
    if (each > 0) {
      double* numbers = energy->numbers + i * (size_t)energy->numbersPerParticle;
      memcpy(numbers, d->parameters + i * each, each * sizeof *numbers);
    }
  }
  return createTapes(energy, d) &&
         ctPairMaskCreate(&energy->masks[0], energy->blockCount, d->exclusionCount, d->exclusions, energy->places) &&
         ctPairMaskCreate(&energy->masks[1], energy->blockCount, 0, NULL, energy->places);
}

ctStatus ctValueEnergyCreate(ValueEnergy* energy, const ctChainTree* tree, int particleCount,
                             const ctValueEnergy* description, int number, char* errorText, size_t errorSize) {
  if (!ctValueEnergyIsValid(description, number, particleCount, errorText, errorSize)) {
    return ctInvalidArgument;
  }
  const bool hasCutoff = isfinite(description->cutoff);
  *energy = (ValueEnergy){
      .wide = ctFindWide(ctGetInstructionSet(tree)),
      .particleCount = particleCount,
      .blockCount = (particleCount + CT_LEAF_WIDTH - 1) / CT_LEAF_WIDTH,
      .parametersPerParticle = description->parametersPerParticle,
      .valueCount = description->valueCount,
      .numbersPerParticle = countReadable(description, ctOfParticles),
      .termCount = description->termCount,
      .cutoff = description->cutoff,
      .range = {.hasCutoff = hasCutoff, .squaredCutoff = squareOfCutoff(description->cutoff)},
  };
  if (!build(energy, description)) {
    ctValueEnergyFree(energy);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  return ctSuccess;
}

void ctValueEnergyFree(ValueEnergy* energy) {
  freeTapes(energy->values, energy->valueCount);
  freeTapes(energy->terms, energy->termCount);
  ctPairMaskFree(&energy->masks[0]);
  ctPairMaskFree(&energy->masks[1]);
  free(energy->places);
  free(energy->numbers);
  freeLines(energy->frames);
  free(energy->sums);
  free(energy->positions);
  *energy = (ValueEnergy){0};
}

/* ---- Particles ---- */

static double* numbersOf(const ValueEnergy* energy, int particle) {
  return energy->numbers + (size_t)particle * (size_t)energy->numbersPerParticle;
}

/* The slots of a block that hold a particle, as bits. */
static unsigned occupiedOf(const ValueEnergy* energy, int block) {
  const int left = energy->particleCount - CT_LEAF_WIDTH * block;
  return left < CT_LEAF_WIDTH ? (1u << left) - 1 : (1u << CT_LEAF_WIDTH) - 1;
}

static void place(ValueEnergy* energy, const double* positions) {
  for (int block = 0; block < energy->blockCount; block++) {
    ctLeafPositions placed = {.x = {0}};
    const int count = __builtin_popcount(occupiedOf(energy, block));
    for (int k = 0; k < count; k++) {
      const int particle = CT_LEAF_WIDTH * block + k;
      const double* position = positions + 3 * (size_t)particle;
      memcpy(numbersOf(energy, particle + 1) - 3, position, 3 * sizeof *position);
      placed.x[k] = position[0];
      placed.y[k] = position[1];
      placed.z[k] = position[2];
    }
    if (energy->isPeriodic) {
      ctWrapBlock(&energy->box, count, &placed);
    }
    for (int k = 0; k < count; k++) {
      double* wrapped = energy->positions[CT_LEAF_WIDTH * block + k];
      wrapped[0] = placed.x[k];
      wrapped[1] = placed.y[k];
      wrapped[2] = placed.z[k];
    }
    energy->wide->makeFrame(&placed, occupiedOf(energy, block), &energy->frames[block]);
  }
}

/* ---- Pairs of blocks ---- */

/* Two blocks as a tape needs them, the first perhaps an image, and which of their pairs count. */
typedef struct BlockPair {
  int a;
  int b;
  bool isImage;
  double shift[3];                 /* of the image */
  LeafFrame frame;                 /* of the image */
  uint16_t allowed[CT_LEAF_WIDTH]; /* per slot of a, bits: slots of b */
  TapePair pair;
} BlockPair;

/* False if no two particles of them are within the cutoff. Of a block with itself each pair counts once. */
static bool openPair(const ValueEnergy* energy, const ValueTape* tape, int a, int b, const int image[3],
                     BlockPair* opened) {
  const size_t width = (size_t)tape->tape.columnCount * CT_LEAF_WIDTH;
  const LeafFrame* frameA = &energy->frames[a];
  const LeafFrame* frameB = &energy->frames[b];
  opened->isImage = isShifted(image);
  opened->shift[0] = opened->shift[1] = opened->shift[2] = 0;
  if (opened->isImage) {
    shiftFrame(frameA, energy->box.vectors, image, &opened->frame);
    imageShift(energy->box.vectors, image, opened->shift);
    frameA = &opened->frame;
  }
  if (energy->range.hasCutoff && squaredGap(frameA, frameB) > energy->cutoff * energy->cutoff) {
    return false;
  }
  opened->a = a;
  opened->b = b;
  opened->pair = (TapePair){.frames = {frameA, frameB},
                            .columns = {tape->tape.columns + (size_t)a * width, tape->tape.columns + (size_t)b * width},
                            .occupied = {occupiedOf(energy, a), occupiedOf(energy, b)}};
  const PairMask* mask = &energy->masks[tape->extent == ctOfPairs ? 0 : 1];
  const uint16_t* excluded = opened->isImage ? pairMaskOfImage(mask, a, b) : pairMaskOf(mask, a, b);
  for (int k = 0; excluded != NULL && k < CT_LEAF_WIDTH; k++) {
    opened->allowed[k] = (uint16_t)~excluded[k];
    opened->pair.allowed = opened->allowed;
  }
  return true;
}

/* Lets pairs of a block with itself count in both orders. */
static void allowBothOrders(BlockPair* opened) {
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    for (int l = k + 1; l < CT_LEAF_WIDTH; l++) {
      if ((opened->allowed[k] >> l & 1) != 0) {
        opened->allowed[l] = (uint16_t)(opened->allowed[l] | 1u << k);
      }
    }
  }
}

/* Adds to sums[k] what particle k of the first block has with the second, in double. */
static void addExactRows(const ValueEnergy* energy, const ValueTape* tape, const BlockPair* opened, double* sums) {
  for (unsigned rows = opened->pair.occupied[0]; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    const int i = CT_LEAF_WIDTH * opened->a + k;
    unsigned others = opened->pair.occupied[1] & (opened->pair.allowed != NULL ? (unsigned)opened->allowed[k] : ~0u);
    for (; others != 0; others &= others - 1) {
      const int j = CT_LEAF_WIDTH * opened->b + __builtin_ctz(others);
      const double* from = energy->positions[i];
      const double* to = energy->positions[j];
      const double x = to[0] - from[0] - opened->shift[0];
      const double y = to[1] - from[1] - opened->shift[1];
      const double z = to[2] - from[2] - opened->shift[2];
      const double distance = sqrt(x * x + y * y + z * z);
      if (distance < energy->cutoff) {
        sums[k] +=
            ctPairExpressionEvaluate(&tape->tape.expression, distance, numbersOf(energy, i), numbersOf(energy, j));
      }
    }
  }
}

/* The images of block a that are near block b. */
static void findImages(const ValueEnergy* energy, int a, int b, BlockImages* near) {
  ctFindBlockImages(energy->isPeriodic ? &energy->box : NULL, &energy->frames[a], &energy->frames[b], energy->cutoff,
                    near);
}

/* ---- Values ---- */

/* The columns of a tape from the numbers that particles have now. */
static void setColumns(const ValueEnergy* energy, ValueTape* tape) {
  ctTapeSetParameters(&tape->tape, energy->particleCount, energy->places, energy->numbers, energy->numbersPerParticle);
}

/* Adds what particles of block a, or of an image of it, have with block b. */
static void addSums(ValueEnergy* energy, ValueTape* tape, int a, int b, const int image[3]) {
  double* sums = energy->sums + CT_LEAF_WIDTH * a;
  BlockPair opened;
  if (!openPair(energy, tape, a, b, image, &opened)) {
    return;
  }
  if (a == b && !opened.isImage) {
    allowBothOrders(&opened);
  }
  if (tape->tape.isExact || !energy->wide->addTapeRows(&tape->tape, &opened.pair, &energy->range, sums)) {
    addExactRows(energy, tape, &opened, sums);
  }
}

static void computeSums(ValueEnergy* energy, ValueTape* tape) {
  BlockImages near;
  memset(energy->sums, 0, (size_t)energy->blockCount * CT_LEAF_WIDTH * sizeof *energy->sums);
  setColumns(energy, tape);
  for (int a = 0; a < energy->blockCount; a++) {
    for (int b = 0; b < energy->blockCount; b++) {
      findImages(energy, a, b, &near);
      for (int i = 0; i < near.count; i++) {
        addSums(energy, tape, a, b, near.images[i]);
      }
    }
  }
}

static void computeValue(ValueEnergy* energy, int value) {
  ValueTape* tape = &energy->values[value];
  if (tape->extent != ctOfParticles) {
    computeSums(energy, tape);
  }
  for (int i = 0; i < energy->particleCount; i++) {
    double* numbers = numbersOf(energy, i);
    numbers[energy->parametersPerParticle + value] =
        tape->extent == ctOfParticles ? ctPairExpressionEvaluate(&tape->expression, 0, numbers, numbers)
                                      : energy->sums[i];
  }
}

/* ---- Energies ---- */

static double energyOfParticles(const ValueEnergy* energy, const ValueTape* tape) {
  double sum = 0;
  for (int i = 0; i < energy->particleCount; i++) {
    sum += ctPairExpressionEvaluate(&tape->expression, 0, numbersOf(energy, i), numbersOf(energy, i));
  }
  return sum;
}

static double exactEnergy(const ValueEnergy* energy, const ValueTape* tape, const BlockPair* opened) {
  double sums[CT_LEAF_WIDTH] = {0};
  double sum = 0;
  addExactRows(energy, tape, opened, sums);
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    sum += sums[k];
  }
  return sum;
}

/* The energy of block b with block a, or with an image of it. */
static double energyOfBlocks(const ValueEnergy* energy, ValueTape* tape, int a, int b, const int image[3]) {
  BlockPair opened;
  if (!openPair(energy, tape, a, b, image, &opened)) {
    return 0;
  }
  const double sum = tape->tape.isExact ? NAN : energy->wide->tapeEnergy(&tape->tape, &opened.pair, &energy->range);
  return isfinite(sum) ? sum : exactEnergy(energy, tape, &opened);
}

static double energyOfPairs(const ValueEnergy* energy, ValueTape* tape) {
  BlockImages near;
  double sum = 0;
  setColumns(energy, tape);
  for (int a = 0; a < energy->blockCount; a++) {
    for (int b = a; b < energy->blockCount; b++) {
      findImages(energy, a, b, &near);
      for (int i = 0; i < near.count; i++) {
        if (a != b || isFirstOfOpposite(near.images[i])) {
          sum += energyOfBlocks(energy, tape, a, b, near.images[i]);
        }
      }
    }
  }
  return sum;
}

double ctValueEnergyCompute(ValueEnergy* energy, const double* positions, const double (*box)[3]) {
  double sum = 0;
  energy->isPeriodic = box != NULL;
  if (box != NULL) {
    energy->box = makePeriodicBox(box);
  }
  place(energy, positions);
  for (int i = 0; i < energy->valueCount; i++) {
    computeValue(energy, i);
  }
  for (int i = 0; i < energy->termCount; i++) {
    ValueTape* tape = &energy->terms[i];
    sum += tape->extent == ctOfParticles ? energyOfParticles(energy, tape) : energyOfPairs(energy, tape);
  }
  return isnan(sum) ? NAN : sum; /* one NaN, whatever the instruction set */
}
