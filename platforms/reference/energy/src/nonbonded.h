/* Lennard-Jones and Coulomb of all pairs of particles of two leaves. */
#ifndef CT_NONBONDED_H_
#define CT_NONBONDED_H_

#include "pairmask.h"
#include "wide.h"

typedef struct Nonbonded {
  const Wide* wide;
  Potential potential;
  LeafColumns* columns; /* one a leaf */
  PairMask mask;
} Nonbonded;

/* slotOf[particle] is its slot, or CT_NULL. On failure there is nothing to free, and errorText (which may not be NULL)
 * says why. */
ctStatus ctNonbondedCreate(Nonbonded* nonbonded, const ctChainTree* tree, int particleCount,
                           const ctNonbonded* description, const int* slotOf, char* errorText, size_t errorSize);
void ctNonbondedFree(Nonbonded* nonbonded);

/* The energy of leaves a <= b with these frames. */
double ctNonbondedEnergy(const Nonbonded* nonbonded, int a, const LeafFrame* frameA, int b, const LeafFrame* frameB);

/* A LeafPairFunction of a Nonbonded. */
void ctNonbondedEnergies(const void* model, int count, const FramedPair* pairs, double* energies);

#endif /* CT_NONBONDED_H_ */
