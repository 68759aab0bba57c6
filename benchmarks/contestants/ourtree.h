/* Scenes as the engine of this project wants them. */
#ifndef OURTREE_H_
#define OURTREE_H_

#include "chaintree.h"
#include "energyfile.h"
#include "scene.h"

/* Ends the program unless a call of the engine was a success: nothing but memory can fail in a race. */
void ourCheck(ctStatus status);

/* The scene with its first `exclusionCount` exclusions. */
ctChainTree* ourTreeOf(const Scene* scene, int exclusionCount);

/* The scene, as if a variable of the environment (CHAINTREE_SIMD, CHAINTREE_TRIALS) had this value, unless NULL; and,
 * unless NULL, with an energy, which is made. NULL if an energy is refused; then `error`, of `size` bytes, says why. */
ctChainTree* ourTreeWith(const Scene* scene, const char* variable, const char* value, const Energy* energy,
                         ctEnergy** made, char* error, size_t size);

#endif /* OURTREE_H_ */
