/* The wide functions: they work on sixteen particles at a time. The files in `wide` define them and are compiled once
 * for each instruction set. All sets give the same bits. */
#ifndef CT_WIDE_H_
#define CT_WIDE_H_

#include "born.h"
#include "standinpair.h"
#include "tape.h"
#include "wholepair.h"

/* F(result, name, parameters) for each wide function that the rest of the library calls. */
/* clang-format off */
#define CT_WIDE_FUNCTIONS(F) \
  /* wide/frames.c: puts the particles of a leaf, of which there is one at least, into a frame. */ \
  F(void, makeFrame, (const ctLeafPositions* positions, unsigned occupied, LeafFrame* frame)) \
  /* wide/nonbonded.c: the energy of all pairs of particles of two leaves. Not finite where single precision does not */ \
  /* suffice. */ \
  F(double, leafPairEnergy, (const Potential* potential, const LeafSide* a, const LeafSide* b)) \
  /* wide/bornsums.c: adds to the Born sums of a leaf's particles the contributions of the leaves from `first` to */ \
  /* `end` within a squared distance, and the reverse contributions to the sums of these. The leaf may be among them. */ \
  /* There are sixteen sums a leaf, and all stay finite. */ \
  F(void, bornSums, \
    (const BornModel* model, float squaredCutoff, const LeafFrame* frames, const BornColumns* columns, int leaf, \
     int first, int end, double* sums)) \
  /* The same of one other leaf and a periodic image of the leaf, which stands in this frame. */ \
  F(void, bornImageSums, \
    (const BornModel* model, float squaredCutoff, const LeafFrame* image, const LeafFrame* frames, \
     const BornColumns* columns, int leaf, int other, double* sums)) \
  /* wide/wholepairs.c, of whole energies: Lennard-Jones, Coulomb and Born without cutoffs of a leaf with those from */ \
  /* `first` to `end`, none of which comes before it; all have the same excluded pairs, NULL: none. And Born alone of */ \
  /* leaves a <= b, with the cutoff of the model, if there is one. */ \
  F(WholePair, wholePairs, \
    (const BornModel* model, const WholeLeaves* leaves, int leaf, int first, int end, const uint16_t* excluded)) \
  F(double, bornPair, (const BornModel* model, const WholeSide* a, const WholeSide* b)) \
  /* wide/standinborn.c: the Born sums that particles near the other leaf, within the stand-in's cutoff, get from it. */ \
  F(void, standInBorn, \
    (const BornModel* model, const StandInModel* standIn, const BornSide* a, const BornSide* b, const NearRows* rows, \
     float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH])) \
  /* Adds to Born sums of two leaves by how much displaced particles change them, given both in the trial and before it. */ \
  F(void, standInBornMove, \
    (const BornModel* model, const StandInModel* standIn, const BornSide a[2], const BornSide b[2], \
     const NearRows* movers, float ofA[CT_LEAF_WIDTH], float ofB[CT_LEAF_WIDTH])) \
  /* wide/standinradii.c: radii of a leaf by its Born sums over particles that are near. */ \
  F(void, standInRadii, \
    (const StandInModel* model, const StandInConstants* constants, const double born[CT_LEAF_WIDTH], \
     StandInRadii* radii)) \
  /* The functions of radii of the grid that give the value of pairs at the cutoff. */ \
  F(void, standInShift, \
    (const StandInModel* model, const float charge[CT_LEAF_WIDTH], const StandInRadii* radii, StandInShift* shift)) \
  /* Subtracts parts from sixteen sums and adds others; false, and nothing changed, if they are the same. */ \
  F(bool, exchangeParts, \
    (double sums[CT_LEAF_WIDTH], const float before[CT_LEAF_WIDTH], const float after[CT_LEAF_WIDTH])) \
  /* The energy of a leaf's single particles and the first order of what the grid of radii neglects, given the */ \
  /* derivatives of pairs by ln B. */ \
  F(double, standInLeafEnergy, (const StandInRadii* radii, const double gradient[CT_LEAF_WIDTH])) \
  /* wide/standinpairs.c: which particles of two leaves are near the other one. */ \
  F(void, nearRows, (const StandInModel* standIn, const LeafFrame* a, const LeafFrame* b, NearRows* rows)) \
  /* The energy of all pairs of two leaves, whose derivatives are added. A leaf with itself has one frame. */ \
  F(double, standInPairs, \
    (const StandInModel* model, const StandInSide* a, const StandInSide* b, const NearRows* rows, \
     float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH])) \
  /* Of pairs with a particle in slotsOfA or slotsOfB: their energy with the radii of the first version of each side */ \
  /* less that with those of the second. */ \
  F(double, standInExchange, \
    (const StandInModel* model, const StandInSide a[2], const StandInSide b[2], const NearRows* rows, \
     unsigned slotsOfA, unsigned slotsOfB, float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH])) \
  /* wide/standinmove.c: which of some particles of two leaves are within reach of the other one. */ \
  F(void, nearSome, \
    (const StandInReach* reach, const LeafFrame* a, const LeafFrame* b, unsigned slotsOfA, unsigned slotsOfB, \
     NearRows* rows)) \
  /* Of pairs with a displaced particle: their energy in the first version of each side less that in the second, which */ \
  /* stands elsewhere. Derivatives are added. */ \
  F(double, standInMove, \
    (const StandInModel* model, const StandInSide a[2], const StandInSide b[2], const NearRows* movers, \
     float gradientA[CT_LEAF_WIDTH], float gradientB[CT_LEAF_WIDTH])) \
  /* wide/tape.c: adds the pairs of particles of two leaves to the tape's batch, which is finished before if it has */ \
  /* no room for them; `number` is the caller's. False if none of them count: energies[number] stays then. */ \
  F(bool, addToBatch, \
    (const Tape* tape, const TapePair* pair, const TapeRange* range, int number, double* energies)) \
  /* Computes the energies of all pairs in the batch, energies[number], and empties it. An energy is not finite where */ \
  /* single precision does not suffice. */ \
  F(void, finishBatch, (const Tape* tape, const TapeRange* range, double* energies)) \
  /* The energy of pairs of particles, as above. The batch has to be empty. */ \
  F(double, tapeEnergy, (const Tape* tape, const TapePair* pair, const TapeRange* range)) \
  /* Adds to the sum of each slot of the first leaf what it has with the second. Range has no switch, and pairs count */ \
  /* once. False, and no sum changed, where single precision does not suffice. The batch has to be empty. */ \
  F(bool, addTapeRows, \
    (const Tape* tape, const TapePair* pair, const TapeRange* range, double sums[CT_LEAF_WIDTH]))
/* clang-format on */

/* The functions as one instruction set has them. */
#define CT_POINTER(result, name, parameters) result(*name) parameters;
typedef struct Wide {
  const char* name; /* of the instruction set */
  CT_WIDE_FUNCTIONS(CT_POINTER)
} Wide;
#undef CT_POINTER

/* Those of the instruction set of this name, as ctGetInstructionSet has it. */
const Wide* ctFindWide(const char* name);

#endif /* CT_WIDE_H_ */
