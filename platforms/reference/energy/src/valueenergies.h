/* All value energies of an energy. */
#ifndef CT_VALUEENERGIES_H_
#define CT_VALUEENERGIES_H_

#include "valueenergy.h"

typedef struct ValueEnergies {
  int count;
  ValueEnergy* energies;
  double* positions; /* of all particles */
} ValueEnergies;

/* On failure there is nothing to free, and errorText (which may not be NULL) says why. */
ctStatus ctValueEnergiesCreate(ValueEnergies* energies, const ctChainTree* tree, int particleCount, int count,
                               const ctValueEnergy* descriptions, char* errorText, size_t errorSize);
void ctValueEnergiesFree(ValueEnergies* energies);

/* That of each in the state, or in the open trial. Errors: there is no open trial. */
ctStatus ctValueEnergiesCompute(ValueEnergies* energies, ctChainTree* tree, bool inTrial, double* results);

#endif /* CT_VALUEENERGIES_H_ */
