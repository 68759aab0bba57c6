/* Spheres against spheres, sixteen at a time, in float: a filter. It may let a pair through that is out of reach, and
 * never loses one within reach. */
#ifndef CT_VOLUME_H_
#define CT_VOLUME_H_

#include "simd.h"
#include "tree.h"

/* Room for all roundings between the positions in double and a test in float, relative to the view's coordinate bound E
 * + |reach|. 4e-6 is 67 u, where u = 2^-24 is half a unit in the last place. No rounding moves a test by more than
 * this:
 *
 * - The centre of a node's sphere in its parent's frame, at most 2 E away: 2 u E.
 * - Its motion into the world, by a frame in float. A coordinate is a sum of three products and a translation. It
 *   is off by 4 u of the magnitudes of the products, which make a vector of at most sqrt(3) 2 E, and by 3 u of the
 *   translation, at most E: 17 u E. (A leaf's particles are moved in double and rounded once: u E.)
 * - The motion of the view, from |x| to |x| plus a translation that together are at most E: 7 u E.
 *   These 26 u E arise for either sphere: 52 u E.
 * - The test: radii rounded to float, their sum with the reach, its square, the differences, their squares and the sum
 *   of those: 6 u of the sum of radii and reach, which is at most 2 E + |reach|: 12 u E + 6 u |reach|.
 *
 * That is 64 u (E + |reach|). A mixed node's sphere is made around spheres that are off by those 26 u E, and by its own
 * radius, by 5 u of it: each level of mixed nodes adds a margin of its own, enough for radii up to 8 E. */
#define FLOAT_MARGIN 4e-6

/* Room, in nm, where coordinates are so small that their squares vanish in float: a reach of 1e-18 has a square of
 * 1e-36, a normal number, from which a square that has vanished differs by less than 1e-44. */
#define FLOAT_FLOOR 1e-18f

static inline double floatMargin(double size) {
  return FLOAT_MARGIN * size + (double)FLOAT_FLOOR;
}

/* Room for what a distance may differ by if it is computed by way of different products of transforms, relative to the
 * view's coordinate bound. Nearer than that to a limit the canonical distance decides.
 *
 * The distance in a trial and that after its acceptance share all shortcuts that its acceptance leaves alone, bit by
 * bit. They differ by the products that it recomputes: up to 16 local frames in a leaf and 15 shortcuts in each of up
 * to 8 levels, 136 products for a particle, however long the chain. Each is off by up to 36 v of the coordinate bound
 * (v = 2^-53): if every rounding of both particles is the largest possible, and all are in one direction, the sum is
 * 9800 v. The margin is 10,800 v. (Roundings are independent of each other: chains of 10^3 to 10^6 links, compact or
 * stretched, have shown 16 v at most.) */
#define DOUBLE_MARGIN 1.2e-12

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

/* The radii around the centres alone of a leaf's particles: 0, or -INFINITY for none. */
static inline void leafCentres(const Leaf* leaf, float* centres) {
  const Float16 none = all16(-INFINITY);
  store16(centres, blend16(greater16(all16(0), load16(leaf->r)), all16(0), none));
}

/* Bit k is set if member k is nearer than its radius + the sphere's + reach. */
static inline unsigned near16(const Block* block, Sphere sphere, float reach) {
  const Float16 sum = max16(add16(load16(block->r), all16(sphere.r + reach)), all16(0));
  return greater16(mul16(sum, sum), squaredFrom(block, sphere.x, sphere.y, sphere.z));
}

/* A row of a motion times the members: one coordinate of each. */
static inline Float16 moved16(const Block* block, const float row[4]) {
  const Float16 xy = add16(mul16(load16(block->x), all16(row[0])), mul16(load16(block->y), all16(row[1])));
  return add16(xy, add16(mul16(load16(block->z), all16(row[2])), all16(row[3])));
}

/* Moves the members whose bit is set by a motion (rows of rotation and translation); leaves the others in `to` alone.
 */
static inline void moveBlock(const Block* from, const float motion[12], unsigned mask, Block* to) {
  store16(to->x, blend16(mask, load16(to->x), moved16(from, motion)));
  store16(to->y, blend16(mask, load16(to->y), moved16(from, motion + 4)));
  store16(to->z, blend16(mask, load16(to->z), moved16(from, motion + 8)));
}

/* Moves all members and sets these radii. Stores them in the pieces in which they will be loaded: a processor waits for
 * whole loads of what was stored in parts. */
static inline void moveAll(const Block* from, const float* radii, const float motion[12], Block* to) {
  store16(to->x, moved16(from, motion));
  store16(to->y, moved16(from, motion + 4));
  store16(to->z, moved16(from, motion + 8));
  store16(to->r, load16(radii));
}

/* The box around all members: its low end, and the opposite of its high end. */
CT_INLINE void boxOfBlock(const Block* block, float least[8]) {
  const Float16 r = load16(block->r);
  const Float16 x = load16(block->x);
  const Float16 y = load16(block->y);
  const Float16 z = load16(block->z);
  /* Four at a time; the most of a number is the least of its opposite. */
  const Float16 zero = all16(0);
  const Float16 first[4] = {sub16(x, r), sub16(y, r), sub16(z, r), sub16(zero, add16(x, r))};
  const Float16 last[4] = {sub16(zero, add16(y, r)), sub16(zero, add16(z, r)), zero, zero};
  least4x16(first, least);
  least4x16(last, least + 4);
}

/* The middle of the box around all members; its radius is -INFINITY if there are none, else 0. */
static inline Sphere middleOfBlock(const Block* block) {
  float least[8];
  boxOfBlock(block, least);
  if (!(least[0] <= -least[3])) {
    return (Sphere){0, 0, 0, -INFINITY};
  }
  /* Adding 0 turns -0 into 0: all paths give the same bits. */
  return (Sphere){0.5f * (least[0] - least[3]) + 0.0f, 0.5f * (least[1] - least[4]) + 0.0f,
                  0.5f * (least[2] - least[5]) + 0.0f, 0};
}

/* The radius about a centre of a sphere around all members, each with a radius of its own. It is computed with a
 * rounding of up to 5 u of it, for which callers make room. */
static inline float radiusAbout(Sphere centre, const Block* block, const float* radii) {
  return most16(add16(sqrt16(squaredFrom(block, centre.x, centre.y, centre.z)), load16(radii)));
}

/* A sphere around all members. */
static inline Sphere sphereAroundBlock(const Block* block) {
  Sphere around = middleOfBlock(block);
  around.r += radiusAbout(around, block, block->r) * (1 + 1e-6f);
  return around;
}

#endif /* CT_VOLUME_H_ */
