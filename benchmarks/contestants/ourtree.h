/* Scenes as the engine of this project wants them. */
#ifndef OURTREE_H_
#define OURTREE_H_

#include "chaintree.h"
#include "energyfile.h"
#include "scene.h"

/* With the first `exclusionCount` exclusions, and behind the scene's particles obstacles at rest, at these
 * 3 * obstacleCount coordinates. NULL if there is no memory. */
ctChainTree* ourTreeOf(const Scene* scene, int exclusionCount, int obstacleCount, const double* obstacles);

/* The scene alone, as if a variable of the environment (CHAINTREE_SIMD, CHAINTREE_TRIALS) had this value. */
ctChainTree* ourTreeWith(const Scene* scene, const char* variable, const char* value);

/* The scene with an energy, by an instruction set, or by the best that there is if that is NULL. Both NULL if that
 * fails; then `error`, of `size` bytes, says why. */
ctChainTree* ourTreeWithEnergy(const Scene* scene, const Energy* energy, const char* instructionSet, ctEnergy** made,
                               char* error, size_t size);

#endif /* OURTREE_H_ */
