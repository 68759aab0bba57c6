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

/* The scene with an energy, by an instruction set, or by the best that there is if that is NULL. NULL if the energy is
 * refused; then `error`, of `size` bytes, says why. */
ctChainTree* ourTreeWith(const Scene* scene, const Energy* energy, const char* instructionSet, ctEnergy** made,
                         char* error, size_t size);

#endif /* OURTREE_H_ */
