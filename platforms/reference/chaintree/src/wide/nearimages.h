/* Which members of a node are near a sphere in some periodic image. A sphere meets the image of another only if, along
 * each normal of the box's faces, it meets it in some image: so one test stands for all images. */
#ifndef CT_NEAR_IMAGES_H_
#define CT_NEAR_IMAGES_H_

#include <math.h>

#include "../images.h"
#include "../traverse.h"
#include "../volume.h"
#include "set.h"

/* PeriodicBox.inverse and PeriodicBox.across. */
typedef struct Lattice {
  float inverse[3][3];
  float across[3];
} Lattice;

static inline Lattice latticeOf(const PeriodicBox* box) {
  Lattice lattice;
  for (int k = 0; k < 3; k++) {
    for (int d = 0; d < 3; d++) {
      lattice.inverse[k][d] = (float)box->inverse[k][d];
    }
    lattice.across[k] = (float)box->across[k];
  }
  return lattice;
}

/* Members (bits) of node b that are not before member k of node a: where both move, each pair is compared once. */
static inline unsigned membersNotBefore(int a, int k, int b) {
  return a < b ? ~0u : a == b ? ~0u << k : 0;
}

/* A point less another, in box vectors. */
CT_INLINE void vectorsApart(const Lattice* lattice, const Float16 apart[3], Float16 vectors[3]) {
  for (int k = 0; k < 3; k++) {
    vectors[k] = mul16(apart[k], all16(lattice->inverse[k][k]));
    for (int d = k + 1; d < 3; d++) {
      vectors[k] = add16(vectors[k], mul16(apart[d], all16(lattice->inverse[k][d])));
    }
  }
}

/* The nearest whole numbers below 2^22. */
CT_INLINE Float16 nearestWhole16(Float16 x) {
  return sub16(add16(x, all16(0x1.8p23f)), all16(0x1.8p23f));
}

/* Members (bits) that meet in an image with a shift, given how far they are apart in box vectors, and these reaches.
 * Beyond 2^22, where numbers are not rounded to whole ones, reaches are larger than 1, since they have room for
 * rounding. */
CT_INLINE unsigned meetImages16(const Float16 vectors[3], const Float16 reaches[3]) {
  Float16 beyond = all16(-INFINITY);      /* how far the nearest image is beyond reach */
  Float16 othersBeyond = all16(INFINITY); /* the same without the scene itself, in all directions */
  for (int k = 0; k < 3; k++) {
    const Float16 off = absolute16(sub16(vectors[k], nearestWhole16(vectors[k])));
    beyond = max16(beyond, sub16(off, reaches[k]));
    othersBeyond = min16(othersBeyond, sub16(sub16(all16(1), absolute16(vectors[k])), reaches[k]));
  }
  return ~(greater16(beyond, all16(0)) | greater16(othersBeyond, all16(0))) & 0xffff;
}

/* Members (bits) that are near a sphere in an image with a shift, at least. The reach has room for rounding, see
 * imageReach. */
CT_INLINE unsigned nearImages16(const Lattice* lattice, const Block* block, Sphere sphere, float reach) {
  const Float16 apart[3] = {sub16(load16(block->x), all16(sphere.x)), sub16(load16(block->y), all16(sphere.y)),
                            sub16(load16(block->z), all16(sphere.z))};
  const Float16 sum = add16(load16(block->r), all16(sphere.r + reach));
  Float16 vectors[3];
  vectorsApart(lattice, apart, vectors);
  const Float16 reaches[3] = {mul16(sum, all16(lattice->across[0])), mul16(sum, all16(lattice->across[1])),
                              mul16(sum, all16(lattice->across[2]))};
  return meetImages16(vectors, reaches);
}

/* True if spheres that are this near meet in one image at most. */
static inline bool haveOneImage(const Lattice* lattice, float sum) {
  const float across = lattice->across[0] > lattice->across[1] ? lattice->across[0] : lattice->across[1];
  return sum * (across > lattice->across[2] ? across : lattice->across[2]) < 0.5f;
}

/* Writes the shift of that image of sphere a; false if it has none. */
static inline bool shiftOf(const Lattice* lattice, const PeriodicBox* box, Sphere a, Sphere b, float shift[3]) {
  const float apart[3] = {a.x - b.x, a.y - b.y, a.z - b.z};
  Image image;
  for (int k = 0; k < 3; k++) {
    float vectors = 0;
    for (int d = k; d < 3; d++) {
      vectors += apart[d] * lattice->inverse[k][d];
    }
    image.n[k] = -(int)rintf(vectors);
  }
  ctImageShift(box, image.n, image.shift);
  for (int d = 0; d < 3; d++) {
    shift[d] = (float)image.shift[d];
  }
  return isImage(&image);
}

/* Calls the function for two slots in their nearest image, if that has a shift. False ends a search. */
static inline bool tellNearestImage(Traversal* t, const PeriodicBox* box, const int slots[2],
                                    const double positions[2][3], CandidateFunction* function, void* context) {
  double apart[3];
  subtract(positions[0], positions[1], apart);
  const Image image = ctNearestImage(box, apart);
  if (!isImage(&image)) {
    return true;
  }
  t->image = &image;
  const bool continues =
      function(context, slots[0], slots[1], squaredImageDistance(positions[0], positions[1], &image));
  t->image = NULL;
  return continues;
}

#endif /* CT_NEAR_IMAGES_H_ */
