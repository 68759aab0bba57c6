/* Pair expressions run on two leaves, compiled once for each instruction set. */
#ifndef CT_TAPEKERNELS_H_
#define CT_TAPEKERNELS_H_

#include "tape.h"

/* The energy of pairs of particles. It is not finite where single precision does not suffice. Writes into the tape's
 * scratch. */
typedef double TapeKernel(const Tape* tape, const TapePair* pair, const TapeRange* range);

/* That of the instruction set of this name, as ctGetInstructionSet has it. */
TapeKernel* ctFindTapeKernel(const char* name);

TapeKernel ctPortableTapeEnergy;
#ifdef __x86_64__
TapeKernel ctAvx2TapeEnergy;
TapeKernel ctAvx512TapeEnergy;
#endif

#endif /* CT_TAPEKERNELS_H_ */
