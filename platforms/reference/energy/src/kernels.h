/* The functions that are compiled once for each instruction set. */
#ifndef CT_KERNELS_H_
#define CT_KERNELS_H_

#include "born.h"
#include "standinpair.h"
#include "wholepair.h"

typedef struct Kernels {
  const char* name; /* as ctGetInstructionSet has it */

  /* Puts the particles of a leaf, of which there is one at least, into a frame. */
  void (*makeFrame)(const ctLeafPositions* positions, unsigned occupied, LeafFrame* frame);

  /* The energy of all pairs of particles of two leaves. It is not finite where single precision does not suffice. */
  double (*leafPairEnergy)(const Potential* potential, const LeafSide* a, const LeafSide* b);

  /* The same of some particles of side a, given as bits, with all of side b. */
  double (*rowsEnergy)(const Potential* potential, const LeafSide* a, const LeafSide* b, unsigned rows);

  /* Adds to the Born sums of a leaf's particles what those of the leaves from `first` to `end` within a squared
   * distance contribute, and to the sums of these the other way round; among the leaves may be the first one itself.
   * There are sixteen sums a leaf, and all stay finite. */
  void (*bornSums)(const BornModel* model, float squaredCutoff, const LeafFrame* frames, const BornColumns* columns,
                   int leaf, int first, int end, double* sums);

  /* Of whole energies: Lennard-Jones, Coulomb and Born without cutoffs of a leaf with those from `first` to `end`, none
   * of which comes before it; all have the same excluded pairs, NULL: none. And Born alone of leaves a <= b, with the
   * cutoff of the model, if there is one. */
  WholePair (*wholePairs)(const BornModel* model, const WholeLeaves* leaves, int leaf, int first, int end,
                          const uint16_t* excluded);
  double (*bornPair)(const BornModel* model, const WholeSide* a, const WholeSide* b);

  /* Of the stand-in: which particles of two leaves are near the other one; and the same sums of these, within its
   * cutoff. */
  void (*nearRows)(const StandInModel* standIn, const LeafFrame* a, const LeafFrame* b, NearRows* rows);
  void (*standInBorn)(const BornModel* model, const StandInModel* standIn, const BornSide* a, const BornSide* b,
                      const NearRows* rows, float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH]);

  /* Of the stand-in: radii of a leaf by its Born sums over particles that are near; what follows from those of the grid
   * alone; the energy of a leaf's particles by themselves with what the grid of radii neglects, given the derivatives
   * of pairs by ln B; the energy of all pairs of two leaves, whose derivatives are added (a leaf with itself has one
   * frame); and, of pairs of which one particle is in slotsOfA or slotsOfB, what they have with the radii of the first
   * version of each side less what they have with those of the second. */
  void (*standInRadii)(const StandInModel* model, const StandInConstants* constants, const double born[CT_LEAF_WIDTH],
                       StandInRadii* radii);
  void (*standInShift)(const StandInModel* model, const float charge[CT_LEAF_WIDTH], const StandInRadii* radii,
                       StandInShift* shift);

  /* Takes some parts out of sixteen sums and adds others; false, and nothing changed, if they are the same. */
  bool (*exchangeParts)(double sums[CT_LEAF_WIDTH], const float before[CT_LEAF_WIDTH],
                        const float after[CT_LEAF_WIDTH]);
  double (*standInLeafEnergy)(const StandInRadii* radii, const double gradient[CT_LEAF_WIDTH]);
  double (*standInPairs)(const StandInModel* model, const StandInSide* a, const StandInSide* b, const NearRows* rows,
                         float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH]);
  double (*standInExchange)(const StandInModel* model, const StandInSide a[2], const StandInSide b[2],
                            const NearRows* rows, unsigned slotsOfA, unsigned slotsOfB, float gradientA[CT_LEAF_WIDTH],
                            float gradientB[CT_LEAF_WIDTH]);
} Kernels;

/* Those of the instruction set of this name. */
const Kernels* ctFindKernels(const char* name);

extern const Kernels ctPortableKernels;
#ifdef __x86_64__
extern const Kernels ctAvx2Kernels;
extern const Kernels ctAvx512Kernels;
#endif

#endif /* CT_KERNELS_H_ */
