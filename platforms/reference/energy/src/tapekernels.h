/* Pair expressions run on two leaves, compiled once for each instruction set. */
#ifndef CT_TAPEKERNELS_H_
#define CT_TAPEKERNELS_H_

#include "tape.h"

typedef struct TapeKernels {
  /* Adds the pairs of particles of two leaves to the tape's batch, which is finished before if it has no room for them;
   * `number` is the caller's. False if none of them count: then energies[number] is left as it is. */
  bool (*add)(const Tape* tape, const TapePair* pair, const TapeRange* range, int number, double* energies);
  /* Computes the energies of all that was added, energies[number], and empties the batch. An energy is not finite where
   * single precision does not suffice. */
  void (*finish)(const Tape* tape, const TapeRange* range, double* energies);
  /* The energy of pairs of particles, as above. The batch has to be empty. */
  double (*energy)(const Tape* tape, const TapePair* pair, const TapeRange* range);
  /* Adds to the sum of each slot of the first leaf what it has with the second. Range has no switch, and pairs count
   * once. False, and no sum changed, where single precision does not suffice. The batch has to be empty. */
  bool (*addRows)(const Tape* tape, const TapePair* pair, const TapeRange* range, double sums[CT_LEAF_WIDTH]);
} TapeKernels;

/* Those of the instruction set of this name, as ctGetInstructionSet has it. */
const TapeKernels* ctFindTapeKernels(const char* name);

extern const TapeKernels ctPortableTapeKernels;
#ifdef __x86_64__
extern const TapeKernels ctAvx2TapeKernels;
extern const TapeKernels ctAvx512TapeKernels;
#endif

#endif /* CT_TAPEKERNELS_H_ */
