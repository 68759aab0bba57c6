#include "valueenergies.h"

#include <stdio.h>
#include <stdlib.h>

ctStatus ctValueEnergiesCreate(ValueEnergies* energies, const ctChainTree* tree, int particleCount, int count,
                               const ctValueEnergy* descriptions, char* errorText, size_t errorSize) {
  *energies = (ValueEnergies){0};
  if (count < 0 || count > CT_MOST_COUNT || (count > 0 && descriptions == NULL)) {
    snprintf(errorText, errorSize, "there are %d value energies%s", count,
             descriptions == NULL ? ", which are NULL" : "");
    return ctInvalidArgument;
  }
  energies->energies = calloc((size_t)count + 1, sizeof *energies->energies);
  energies->positions = malloc((3 * (size_t)particleCount + 1) * sizeof *energies->positions);
  ctStatus status = ctSuccess;
  if (energies->energies == NULL || energies->positions == NULL) {
    snprintf(errorText, errorSize, "out of memory");
    status = ctOutOfMemory;
  }
  for (int i = 0; i < count && status == ctSuccess; i++) {
    status =
        ctValueEnergyCreate(&energies->energies[i], tree, particleCount, &descriptions[i], i, errorText, errorSize);
    energies->count += status == ctSuccess ? 1 : 0;
  }
  if (status != ctSuccess) {
    ctValueEnergiesFree(energies);
  }
  return status;
}

void ctValueEnergiesFree(ValueEnergies* energies) {
  for (int i = 0; i < energies->count; i++) {
    ctValueEnergyFree(&energies->energies[i]);
  }
  free(energies->energies);
  free(energies->positions);
  *energies = (ValueEnergies){0};
}

ctStatus ctValueEnergiesCompute(ValueEnergies* energies, ctChainTree* tree, bool inTrial, double* results) {
  /* Not from leaves: positions of turned leaves differ from those after acceptance by rounding. */
  if (!inTrial) {
    ctGetPositions(tree, energies->positions);
  } else if (ctGetTrialPositions(tree, energies->positions) != ctSuccess) {
    return ctNoTrial;
  }
  double box[3][3];
  const bool isPeriodic = ctGetBox(tree, box);
  for (int i = 0; i < energies->count; i++) {
    results[i] =
        ctValueEnergyCompute(&energies->energies[i], energies->positions, isPeriodic ? (const double(*)[3])box : NULL);
  }
  return ctSuccess;
}
