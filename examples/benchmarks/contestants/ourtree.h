/* Scenes as the engine of this project wants them. */
#ifndef OURTREE_H_
#define OURTREE_H_

#include "chaintree.h"
#include "scene.h"

/* With the first `exclusionCount` exclusions, and behind the scene's particles obstacles at rest, at these
 * 3 * obstacleCount coordinates. NULL if there is no memory. */
ctChainTree* ourTreeOf(const Scene* scene, int exclusionCount, int obstacleCount, const double* obstacles);

#endif /* OURTREE_H_ */
