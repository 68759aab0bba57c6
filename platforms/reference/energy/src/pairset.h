/* Any expression of pairs of particles, of two leaves at a time; see ctPairSet. */
#ifndef CT_PAIRSET_H_
#define CT_PAIRSET_H_

#include "pairgroups.h"
#include "pairmask.h"
#include "wide.h"

typedef struct PairSet {
  const Wide* wide;
  Tape tape;
  TapeRange range;
  double cutoff;
  double switchingDistance;
  double* parameters; /* of each slot */
  unsigned* occupied; /* per leaf, bits: slots that hold a particle */
  PairMask mask;
  bool hasGroups;
  PairGroups groups;
} PairSet;

/* slotOf[particle] is its slot, or CT_NULL; `number` is that of the set, for errorText (which may not be NULL). On
 * failure there is nothing to free. */
ctStatus ctPairSetCreate(PairSet* set, const ctChainTree* tree, int particleCount, const ctPairSet* description,
                         int number, const int* slotOf, char* errorText, size_t errorSize);
void ctPairSetFree(PairSet* set);

/* A LeafPairFunction of a PairSet, of which only scratch changes. */
void ctPairSetEnergies(const void* model, int count, const FramedPair* pairs, double* energies);

#endif /* CT_PAIRSET_H_ */
