/* Pair expressions run on two leaves, compiled once for each instruction set. */
#ifndef CT_TAPEKERNELS_H_
#define CT_TAPEKERNELS_H_

#include "tape.h"

typedef struct TapeKernels {
  /* The energy of pairs of particles. It is not finite where single precision does not suffice. This and the next write
   * into the tape's scratch. */
  double (*energy)(const Tape* tape, const TapePair* pair, const TapeRange* range);
  /* Adds to the sum of each slot of the first leaf what it has with the second. Range has no switch, and pairs count
   * once. False, and no sum changed, where single precision does not suffice. */
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
