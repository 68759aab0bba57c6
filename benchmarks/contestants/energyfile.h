/* Energies from files: what a force field says of the particles of a scene.
 *
 * Text, as a scene's; indices are those of the scene's source, units those of ctenergy.h.
 *
 *   chaintree-energy 1
 *   particles N exclusions E sets S
 *   cutoff switching dielectric     cutoff 0: none; switching 0: no switching function
 *   charge sigma epsilon            N times
 *   i j                             E times: pairs without Lennard-Jones and Coulomb
 *   kind terms particles parameters S times, kind as in ctTermKind (neither maps nor expressions), followed by
 *   i ... value ...                 `terms` times: the particles and the parameters of a term
 */
#ifndef ENERGYFILE_H_
#define ENERGYFILE_H_

#include "ctenergy.h"
#include "scene.h"

/* In the numbers that the scene gives its particles. */
typedef struct Energy {
  double* charges;
  double* sigmas;
  double* epsilons;
  int (*exclusions)[2];
  ctNonbonded nonbonded; /* of these arrays */
  int setCount;
  ctTermSet* sets; /* own their arrays */
} Energy;

/* NULL if that fails; then `error`, of `size` bytes, says why. */
Energy* energyRead(const char* path, const Scene* scene, char* error, size_t size);
void energyFree(Energy* energy);

#endif /* ENERGYFILE_H_ */
