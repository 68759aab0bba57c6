/* Scenes from files.
 *
 * Text: words and numbers with white space between them, indices from 0.
 *
 *   chaintree-scene 1
 *   particles N links L exclusions E
 *   x y z radius link              N times, link of the particle
 *   parent near far side           L times: of each link its parent, the particle of the parent and its own particle on
 *                                  the axis that turns it, and 1 if it belongs to a side chain, else 0; -1 -1 -1 0 for
 *                                  a link at rest
 *   i j                            E times: pairs that never clash
 */
#ifndef SCENEFILE_H_
#define SCENEFILE_H_

#include "scene.h"

/* "-" is the standard input. NULL if that fails; then `error`, of `size` bytes, says why. */
Scene* sceneRead(const char* path, char* error, size_t size);

#endif /* SCENEFILE_H_ */
