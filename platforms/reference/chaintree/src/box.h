/* Oriented boxes: tighter than spheres around long or flat sets of particles. */
#ifndef CT_BOX_H_
#define CT_BOX_H_

#include <string.h>

#include "costs.h"
#include "volume.h"

typedef float Row4 __attribute__((vector_size(16)));

/* Row d holds coordinate d of the centre and of the three unit axes. */
typedef struct Box {
  Row4 row[3];
  Row4 half; /* 0, and half the boxes along the axes */
  bool thin; /* its volume is much less than its sphere's: see THIN_SHARE */
  Revision builtFrom;
} Box;

/* Boxes of the children of a node, as a structure of arrays. */
typedef struct BoxBlock {
  float centre[3][TREE_WIDTH];
  float axis[3][3][TREE_WIDTH]; /* [which][coordinate] */
  float half[3][TREE_WIDTH];
  unsigned thin; /* bit k: that of child k is */
} BoxBlock;

static inline Row4 all4(float a) {
  return (Row4){a, a, a, a};
}

/* A box moved by rows of rotation and translation. */
static inline Box movedBox(const Box* box, const float motion[12]) {
  Box moved = *box;
  for (int d = 0; d < 3; d++) {
    const float* m = motion + 4 * d;
    const Row4 shift = {m[3], 0, 0, 0};
    moved.row[d] = all4(m[0]) * box->row[0] + all4(m[1]) * box->row[1] + all4(m[2]) * box->row[2] + shift;
  }
  return moved;
}

/* The coordinates of sixteen points along a vector. */
static inline Float16 along16(Float16 x, Float16 y, Float16 z, float ux, float uy, float uz) {
  return add16(add16(mul16(x, all16(ux)), mul16(y, all16(uy))), mul16(z, all16(uz)));
}

/* The member for which a value is largest; of several the first. */
static inline int largestMember(Float16 values) {
  return __builtin_ctz(~greater16(all16(most16(values)), values) & 0xffffu);
}

/* Makes v the unit vector along it; `otherwise`, if it has no length. */
static inline void unitOr(const float otherwise[3], float v[3]) {
  const float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (int d = 0; d < 3; d++) {
    v[d] = length > 0 ? v[d] / length : otherwise[d];
  }
}

/* A unit vector across u. */
static inline void acrossUnit(const float u[3], float v[3]) {
  static const float x[3] = {1, 0, 0};
  const bool alongX = fabsf(u[0]) > 0.9f;
  /* The cross product with the x or y axis, whichever is farther from u. */
  v[0] = alongX ? u[2] : 0;
  v[1] = alongX ? 0 : u[2];
  v[2] = alongX ? -u[0] : -u[1];
  unitOr(x, v);
}

/* Makes axis 1 orthogonal to axis 0 again, where rounding has tilted it, and axis 2 the cross product of both. */
static inline void squareAxes(float axes[3][3], const float otherwise[3]) {
  const float* u = axes[0];
  float* v = axes[1];
  const float left = v[0] * u[0] + v[1] * u[1] + v[2] * u[2];
  for (int d = 0; d < 3; d++) {
    v[d] -= left * u[d];
  }
  unitOr(otherwise, v);
  axes[2][0] = u[1] * v[2] - u[2] * v[1];
  axes[2][1] = u[2] * v[0] - u[0] * v[2];
  axes[2][2] = u[0] * v[1] - u[1] * v[0];
}

/* Axes for a box around spheres: along the line between two distant ones, and towards the one farthest from that line.
 */
static inline void chooseAxes(const Block* block, Sphere middle, float axes[3][3]) {
  const Float16 dx = sub16(load16(block->x), all16(middle.x));
  const Float16 dy = sub16(load16(block->y), all16(middle.y));
  const Float16 dz = sub16(load16(block->z), all16(middle.z));
  const unsigned none = greater16(all16(0), load16(block->r));
  const Float16 never = all16(-1);
  const int one = largestMember(blend16(none, squared16(dx, dy, dz), never));
  const Float16 farFromOne = blend16(none, squaredFrom(block, block->x[one], block->y[one], block->z[one]), never);
  const int other = largestMember(farFromOne);
  static const float x[3] = {1, 0, 0};
  float* u = axes[0];
  u[0] = block->x[other] - block->x[one];
  u[1] = block->y[other] - block->y[one];
  u[2] = block->z[other] - block->z[one];
  unitOr(x, u);
  const Float16 along = along16(dx, dy, dz, u[0], u[1], u[2]);
  const Float16 fx = sub16(dx, mul16(along, all16(u[0])));
  const Float16 fy = sub16(dy, mul16(along, all16(u[1])));
  const Float16 fz = sub16(dz, mul16(along, all16(u[2])));
  const Float16 farAcross = blend16(none, squared16(fx, fy, fz), never);
  const int far = largestMember(farAcross);
  float* v = axes[1];
  float lanes[3][TREE_WIDTH];
  store16(lanes[0], fx);
  store16(lanes[1], fy);
  store16(lanes[2], fz);
  float across[3];
  acrossUnit(u, across);
  /* If all spheres lie on that line, their distances from it are rounding, without a direction. */
  const bool isLine = !(most16(farAcross) > 1e-6f * most16(farFromOne));
  for (int d = 0; d < 3; d++) {
    v[d] = isLine ? across[d] : lanes[d][far];
  }
  unitOr(across, v);
  squareAxes(axes, across);
}

static inline void putBox(BoxBlock* block, int k, const Box* box) {
  block->thin = (block->thin & ~(1u << k)) | (unsigned)box->thin << k;
  for (int d = 0; d < 3; d++) {
    block->centre[d][k] = box->row[d][0];
    for (int i = 0; i < 3; i++) {
      block->axis[i][d][k] = box->row[d][i + 1];
    }
    block->half[d][k] = box->half[d + 1];
  }
}

static inline Float16 dot16(float x, float y, float z, const float v[3][TREE_WIDTH]) {
  return along16(load16(v[0]), load16(v[1]), load16(v[2]), x, y, z);
}

/* Half the boxes of boxes along a unit vector. */
static inline Float16 reachAlong(const BoxBlock* boxes, const float u[3]) {
  Float16 reach = all16(0);
  for (int i = 0; i < 3; i++) {
    const Float16 cosine = absolute16(dot16(u[0], u[1], u[2], boxes->axis[i]));
    reach = add16(reach, mul16(cosine, load16(boxes->half[i])));
  }
  return reach;
}

/* The axes of the longest thin box, made orthonormal again. */
static inline void axesOfLongest(const BoxBlock* boxes, float axes[3][3]) {
  const Float16 longest = max16(max16(load16(boxes->half[0]), load16(boxes->half[1])), load16(boxes->half[2]));
  const int k = largestMember(blend16(boxes->thin, all16(-1), longest));
  for (int i = 0; i < 2; i++) {
    for (int d = 0; d < 3; d++) {
      axes[i][d] = boxes->axis[i][d][k];
    }
  }
  unitOr(axes[0], axes[0]);
  squareAxes(axes, axes[1]);
}

/* A box around spheres, or around the boxes of those members whose boxes are thin, if there are boxes. In that case it
 * takes the axes of the longest thin box: the axes of a layer of rods are those of the rods, not those of its corners.
 *
 * Room for rounding: 1.6e-5 is 268 u (u = 2^-24) of B, the sum of the magnitudes of the bound's centre and radius,
 * which no coordinate of the members exceeds, nor half a box along an axis. It is for all errors in proportion to B:
 *
 * - The fit. The axes are orthonormal up to 5 u (the last has a length of 1 up to 5 u), and the centre is their sum:
 *   12 u. Coordinates along them: 3 u; sums and differences with radii: 3 u; the centre, a sum of three products: 7 u;
 *   the members' centres, rounded: u; the length of an axis: 5 u. Together 31 u B.
 * - A box is moved up to twice, to the world and into the view, or to the frame of its parent: each time its axes are
 *   off by 7 u, and no longer orthogonal by 23 u. A test along one of them takes them for orthogonal: up to 51 u of
 *   three halves, 153 u B. Along an axis of another box they are off by 14 u, and their cosines by 4 u: 54 u B.
 * - The sum of three halves times cosines: 6 u of it, 18 u B.
 *
 * That is 256 u B. What is in proportion to the coordinate bound E, FLOAT_MARGIN covers with its 67 u E: centres moved
 * twice, 14 u E for either box; their difference, of at most 2 E, and its sum of three products along an axis: 22 u E.
 * For 4 million pairs of random boxes, up to as large as the scene and moved twice, the whole error never exceeded 8 u
 * E. */
static inline Box boxAround(const Block* block, const BoxBlock* boxes, const Bound* bound) {
  Box box;
  float axes[3][3];
  const bool hasThin = boxes != NULL && boxes->thin != 0;
  if (hasThin) {
    axesOfLongest(boxes, axes);
  } else {
    chooseAxes(block, (Sphere){bound->x, bound->y, bound->z, 0}, axes);
  }
  float centre[3] = {0, 0, 0};
  float half[4] = {0, 0, 0, 0};
  for (int i = 0; i < 3; i++) {
    const float* u = axes[i];
    Float16 along = along16(load16(block->x), load16(block->y), load16(block->z), u[0], u[1], u[2]);
    Float16 reach = load16(block->r);
    if (hasThin) {
      along = blend16(boxes->thin, along, dot16(u[0], u[1], u[2], boxes->centre));
      reach = blend16(boxes->thin, reach, reachAlong(boxes, u));
    }
    const float low = least16(sub16(along, reach));
    const float high = most16(add16(along, reach));
    const float at = 0.5f * (low + high);
    half[i + 1] = 0.5f * (high - low);
    for (int d = 0; d < 3; d++) {
      centre[d] += at * u[d];
    }
  }
  const float rounding = 1.6e-5f * (fabsf(bound->x) + fabsf(bound->y) + fabsf(bound->z) + bound->r);
  for (int d = 0; d < 3; d++) {
    box.row[d] = (Row4){centre[d], axes[0][d], axes[1][d], axes[2][d]};
  }
  box.half = (Row4){0, half[1] + rounding, half[2] + rounding, half[3] + rounding};
  const float sphere = 4.18879f * bound->r * bound->r * bound->r;
  box.thin = 8 * box.half[1] * box.half[2] * box.half[3] < THIN_SHARE * sphere;
  return box;
}

/* Boxes moved by rows of rotation and translation; `from` and `to` differ. */
static inline void moveBoxes(const BoxBlock* from, const float motion[12], BoxBlock* to) {
  for (int d = 0; d < 3; d++) {
    const float* m = motion + 4 * d;
    store16(to->centre[d], add16(dot16(m[0], m[1], m[2], from->centre), all16(m[3])));
    for (int i = 0; i < 3; i++) {
      store16(to->axis[i][d], dot16(m[0], m[1], m[2], from->axis[i]));
    }
  }
  memcpy(to->half, from->half, sizeof to->half);
  to->thin = from->thin;
}

/* Copies boxes whose bit is set from another block. */
static inline void replaceBoxes(BoxBlock* boxes, unsigned mask, const BoxBlock* by) {
  for (int d = 0; d < 3; d++) {
    store16(boxes->centre[d], blend16(mask, load16(boxes->centre[d]), load16(by->centre[d])));
    for (int i = 0; i < 3; i++) {
      store16(boxes->axis[i][d], blend16(mask, load16(boxes->axis[i][d]), load16(by->axis[i][d])));
    }
  }
}

/* Bit k: box k of b is out of reach of box i of a, as seen along an axis of either. These are the first six of the
 * fifteen axes of the separating axis theorem. */
static inline unsigned boxesApart(const BoxBlock* a, int i, const BoxBlock* b, float reach) {
  const Float16 x = sub16(load16(b->centre[0]), all16(a->centre[0][i]));
  const Float16 y = sub16(load16(b->centre[1]), all16(a->centre[1][i]));
  const Float16 z = sub16(load16(b->centre[2]), all16(a->centre[2][i]));
  unsigned apart = 0;
  Float16 reachOfA[3] = {all16(reach), all16(reach), all16(reach)}; /* along the axes of b */
  for (int j = 0; j < 3; j++) {
    const float ux = a->axis[j][0][i];
    const float uy = a->axis[j][1][i];
    const float uz = a->axis[j][2][i];
    const float half = a->half[j][i];
    Float16 both = all16(half + reach);
    for (int k = 0; k < 3; k++) {
      const Float16 cosine = absolute16(dot16(ux, uy, uz, b->axis[k]));
      both = add16(both, mul16(cosine, load16(b->half[k])));
      reachOfA[k] = add16(reachOfA[k], mul16(cosine, all16(half)));
    }
    const Float16 along = along16(x, y, z, ux, uy, uz);
    apart |= greater16(absolute16(along), both);
  }
  for (int k = 0; k < 3; k++) {
    const Float16 along =
        add16(add16(mul16(x, load16(b->axis[k][0])), mul16(y, load16(b->axis[k][1]))), mul16(z, load16(b->axis[k][2])));
    apart |= greater16(absolute16(along), add16(reachOfA[k], load16(b->half[k])));
  }
  return apart;
}

/* Bit k: sphere k of a block is not farther than reach from box i along any of its axes. */
static inline unsigned nearBox(const Block* block, const BoxBlock* boxes, int i, float reach) {
  const Float16 x = sub16(load16(block->x), all16(boxes->centre[0][i]));
  const Float16 y = sub16(load16(block->y), all16(boxes->centre[1][i]));
  const Float16 z = sub16(load16(block->z), all16(boxes->centre[2][i]));
  unsigned apart = 0;
  for (int j = 0; j < 3; j++) {
    const Float16 along = along16(x, y, z, boxes->axis[j][0][i], boxes->axis[j][1][i], boxes->axis[j][2][i]);
    apart |= greater16(absolute16(along), add16(load16(block->r), all16(boxes->half[j][i] + reach)));
  }
  return ~apart;
}

#endif /* CT_BOX_H_ */
