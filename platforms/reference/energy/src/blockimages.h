/* Periodic images of blocks of particles, for energies that are computed as a whole. */
#ifndef CT_BLOCKIMAGES_H_
#define CT_BLOCKIMAGES_H_

#include "imageframe.h"
#include "periodicbox.h"

/* Particles of a wrapped block are at most half a box from the first in each direction, and a reach is at most half of
 * the box's width. So at most four numbers of each vector bring one block near another. */
enum { MOST_BLOCK_IMAGES = 64 };

/* The images of one block that are near another, as numbers of box vectors. */
typedef struct BlockImages {
  int count;
  int images[MOST_BLOCK_IMAGES][3];
} BlockImages;

/* Moves the first `count` particles of a block to their images nearest to the first of them. */
void ctWrapBlock(const PeriodicBox* box, int count, ctLeafPositions* positions);

/* Finds the images of wrapped block a that are within reach of wrapped block b; without a box, block a itself. */
void ctFindBlockImages(const PeriodicBox* box, const LeafFrame* a, const LeafFrame* b, double reach,
                       BlockImages* found);

/* False for one of two opposite images. */
static inline bool isFirstOfOpposite(const int image[3]) {
  return image[2] != 0 ? image[2] > 0 : image[1] != 0 ? image[1] > 0 : image[0] >= 0;
}

#endif /* CT_BLOCKIMAGES_H_ */
