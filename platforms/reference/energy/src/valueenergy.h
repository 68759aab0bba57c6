/* An energy of values that particles have, computed as a whole; see ctValueEnergy. */
#ifndef CT_VALUEENERGY_H_
#define CT_VALUEENERGY_H_

#include "pairmask.h"
#include "periodicbox.h"
#include "wide.h"

/* A value or a term. */
typedef struct ValueTape {
  ctExtent extent;
  PairExpression expression; /* if it is of particles */
  Tape tape;                 /* if it is of pairs */
} ValueTape;

/* Sixteen particles in their order are a block, which is what tapes call a leaf. */
typedef struct ValueEnergy {
  const Wide* wide;
  int particleCount;
  int blockCount;
  int* places; /* of particles in blocks: their own numbers */
  int parametersPerParticle;
  int valueCount;
  int numbersPerParticle;
  double* numbers; /* of one particle after another */
  ValueTape* values;
  int termCount;
  ValueTape* terms;
  double cutoff;
  TapeRange range;
  PairMask masks[2]; /* of ctOfPairs, and of ctOfAllPairs */
  LeafFrame* frames; /* per block */
  double* sums;      /* per particle: those of a value */

  /* Where particles are, each in the image that is nearest to the first of its block. */
  double (*positions)[3];
  bool isPeriodic;
  PeriodicBox box;
} ValueEnergy;

enum { COORDINATES = 3 };

/* The numbers of a particle that an expression of this extent can read. */
static inline int countReadable(const ctValueEnergy* d, ctExtent extent) {
  return d->parametersPerParticle + d->valueCount + (extent == ctOfParticles ? COORDINATES : 0);
}

/* `number` is that of the energy, for errorText (which may not be NULL). On failure there is nothing to free. */
ctStatus ctValueEnergyCreate(ValueEnergy* energy, const ctChainTree* tree, int particleCount,
                             const ctValueEnergy* description, int number, char* errorText, size_t errorSize);
void ctValueEnergyFree(ValueEnergy* energy);

/* The energy of 3 * particleCount coordinates; `box`: the vectors of the periodic box, or NULL. */
double ctValueEnergyCompute(ValueEnergy* energy, const double* positions, const double (*box)[3]);

#endif /* CT_VALUEENERGY_H_ */
