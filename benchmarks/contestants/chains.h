/* Chains whose spheres are all of one kind, one a link. */
#ifndef CHAINS_H_
#define CHAINS_H_

#include "random.h"
#include "scene.h"

/* Walks on a cubic lattice of spacing 4 with spheres of radius 1: the paper's first benchmark (section 5). Torsion i
 * is about the bond from sphere i to the next, also where the walk is straight: all that follows turns anyway. */

/* Row by row and layer by layer through a cube, as small as holds `count` sites. */
Scene* chainSerpentine(int count);

/* The first `count` sites of a Hilbert curve. */
Scene* chainHilbert(int count);

/* The serpentine after 12 * count moves by which an end of the walk goes to a random neighbouring site: the walk is
 * threaded again from there, or, if the site was free, leaves its other end. O(count^2). */
Scene* chainRandom(int count, Random* random);

/* All need a count of at least 4. */

#endif /* CHAINS_H_ */
