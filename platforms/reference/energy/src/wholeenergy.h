/* The energies that a stand-in stands for, recomputed. */
#ifndef CT_WHOLEENERGY_H_
#define CT_WHOLEENERGY_H_

#include "nonbonded.h"
#include "periodicbox.h"

/* Some slots of leaves hold no particle, so particles are put into blocks of sixteen without gaps, in the order
 * of their slots. Wide functions call a block a leaf. */
typedef struct WholeEnergy {
  ctChainTree* tree;
  const Wide* wide;
  int particleCount;
  int blockCount;
  int* slots;          /* the slot of each particle, as blocks have them */
  int* particles;      /* their numbers */
  Nonbonded nonbonded; /* of blocks */
  Born born;           /* of blocks */
  LeafFrame* frames;   /* per block */
  BornRadii* radii;    /* per block */
  double* sums;        /* Born sums, per place in a block */
  bool isPeriodic;     /* when frames were made */
  PeriodicBox box;
} WholeEnergy;

/* slotOf[particle] is its slot. On failure there is nothing to free and errorText (not NULL) says why. */
ctStatus ctWholeEnergyCreate(WholeEnergy* whole, ctChainTree* tree, int particleCount, const ctNonbonded* nonbonded,
                             const ctBorn* born, const int* slotOf, char* errorText, size_t errorSize);
void ctWholeEnergyFree(WholeEnergy* whole);

/* Both energies of the scene's state; that of Born is NaN if some Born radius is not a positive number. O(N^2) without
 * cutoffs. Errors: no memory. */
ctStatus ctWholeEnergyCompute(WholeEnergy* whole, double* nonbonded, double* born);

/* The Born sums of the scene's state, one a particle. Errors: no memory. */
ctStatus ctWholeEnergyBornSums(WholeEnergy* whole, double* sums);

#endif /* CT_WHOLEENERGY_H_ */
