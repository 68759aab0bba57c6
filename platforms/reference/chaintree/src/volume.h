/* Spheres against spheres, sixteen at a time, in float: a filter that may let a pair through and never loses one. */
#ifndef CT_VOLUME_H_
#define CT_VOLUME_H_

#include "simd.h"
#include "tree.h"

/* Rounding to float, a motion in float, once on each side, and rounding of the test itself, relative to the largest
 * coordinate and reach. */
#define FLOAT_MARGIN 4e-6

/* Room, in nm, where all coordinates are so small that their squares vanish in float. */
#define FLOAT_FLOOR 1e-18f

static inline double floatMargin(double size) {
  return FLOAT_MARGIN * size + (double)FLOAT_FLOOR;
}

/* What two positions of one particle reached by different products of transforms differ by at most, relative to the
 * largest coordinate: some hundred roundings of 1e-16. Nearer than that to a limit the canonical distance decides. */
#define DOUBLE_MARGIN 4e-13

typedef struct Sphere {
  float x;
  float y;
  float z;
  float r;
} Sphere;

static inline Sphere sphereOf(const Block* block, int k) {
  return (Sphere){block->x[k], block->y[k], block->z[k], block->r[k]};
}

/* Squared distances of all members from a point. */
CT_INLINE Float16 squaredFrom(const Block* block, float x, float y, float z) {
  return squared16(sub16(load16(block->x), all16(x)), sub16(load16(block->y), all16(y)),
                   sub16(load16(block->z), all16(z)));
}

/* A sphere moved by rows of rotation and translation. */
static inline Sphere movedSphere(Sphere sphere, const float motion[12]) {
  const float* m = motion;
  return (Sphere){m[0] * sphere.x + m[1] * sphere.y + m[2] * sphere.z + m[3],
                  m[4] * sphere.x + m[5] * sphere.y + m[6] * sphere.z + m[7],
                  m[8] * sphere.x + m[9] * sphere.y + m[10] * sphere.z + m[11], sphere.r};
}

/* The particles of a leaf in its frame. */
static inline void leafBlock(const Leaf* leaf, Block* block) {
  for (int k = 0; k < TREE_WIDTH; k++) {
    block->x[k] = (float)leaf->x[k];
    block->y[k] = (float)leaf->y[k];
    block->z[k] = (float)leaf->z[k];
    block->r[k] = leaf->r[k];
  }
}

/* Radii around the centres of a leaf's particles only: 0, or -INFINITY for none. */
static inline void leafCentres(const Leaf* leaf, float* centres) {
  for (int k = 0; k < TREE_WIDTH; k++) {
    centres[k] = leaf->r[k] < 0 ? -INFINITY : 0;
  }
}

/* Bit k is set if member k is nearer than its radius + the sphere's + reach. */
static inline unsigned near16(const Block* block, Sphere sphere, float reach) {
  const Float16 sum = max16(add16(load16(block->r), all16(sphere.r + reach)), all16(0));
  return greater16(mul16(sum, sum), squaredFrom(block, sphere.x, sphere.y, sphere.z));
}

/* One coordinate of the members moved by a row of a motion. */
static inline Float16 moved16(const Block* block, const float row[4]) {
  const Float16 xy = add16(mul16(load16(block->x), all16(row[0])), mul16(load16(block->y), all16(row[1])));
  return add16(xy, add16(mul16(load16(block->z), all16(row[2])), all16(row[3])));
}

/* Members whose bit is set, moved by a motion (rows of rotation and translation); the others as they are in `to`. */
static inline void moveBlock(const Block* from, const float motion[12], unsigned mask, Block* to) {
  store16(to->x, blend16(mask, load16(to->x), moved16(from, motion)));
  store16(to->y, blend16(mask, load16(to->y), moved16(from, motion + 4)));
  store16(to->z, blend16(mask, load16(to->z), moved16(from, motion + 8)));
}

/* The middle of the box around all members; its radius is -INFINITY if there are none, else 0. */
static inline Sphere middleOfBlock(const Block* block) {
  const Float16 r = load16(block->r);
  const Float16 x = load16(block->x);
  const Float16 y = load16(block->y);
  const Float16 z = load16(block->z);
  const float lowX = least16(sub16(x, r));
  const float highX = most16(add16(x, r));
  if (!(lowX <= highX)) {
    return (Sphere){0, 0, 0, -INFINITY};
  }
  /* The sum with 0 makes one zero of both. */
  return (Sphere){0.5f * (lowX + highX) + 0.0f, 0.5f * (least16(sub16(y, r)) + most16(add16(y, r))) + 0.0f,
                  0.5f * (least16(sub16(z, r)) + most16(add16(z, r))) + 0.0f, 0};
}

/* The radius about a centre that holds all members, each with a radius of its own; without room for rounding. */
static inline float radiusAbout(Sphere centre, const Block* block, const float* radii) {
  return most16(add16(sqrt16(squaredFrom(block, centre.x, centre.y, centre.z)), load16(radii)));
}

#endif /* CT_VOLUME_H_ */
