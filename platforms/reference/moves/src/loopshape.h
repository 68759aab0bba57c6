/* loopshape.h: a loop as ctgrowth.h describes it, checked and arranged: what all members of all populations share. */
#ifndef CT_LOOPSHAPE_H_
#define CT_LOOPSHAPE_H_

#include "ctgrowth.h"
#include "spheregrid.h"

/* A set of joints that are drawn together. */
typedef struct JointSet {
  const int* joints;
  int count;
  const ctDensity* density;
  int uniformCount;
  int body; /* the piece of the path that bears it, or -1 for a set of the path */
} JointSet;

/* Which pairs of particles never clash: a list of partners for each particle that moves. */
typedef struct Partners {
  int* firsts;
  int* items;
} Partners;

typedef struct LoopShape {
  int pathCount;
  int jointCount;      /* also the number of pieces, with the fixed one */
  double (*points)[3]; /* of the axis of each joint: its third particle */
  double (*axes)[3];
  double* angles; /* of the joints as given */
  int* parents;   /* of each piece, for side chains; k - 1 for piece k of the path */
  int* bodies;    /* the piece of the path that each piece is or hangs on */
  int particleCount;
  int* order;  /* of the caller's particles, by pieces */
  int* firsts; /* where the particles of each piece begin */
  Sphere* spheres;
  uint8_t* roles;
  Sphere* bounds; /* around each piece */
  Partners partners;
  Partners fixedPartners;
  Sphere* fixedSpheres;
  uint8_t* fixedRoles;
  SphereGrid grid;
  double tolerance;
  double allowance;
  int setCount;
  JointSet* sets;
  int* setJoints;
  int* setOf; /* of each joint, or -1 */
} LoopShape;

/* False if there is no memory or the definition contradicts its comments; then *problem says so. Either way the shape
 * has to be freed. */
bool makeLoopShape(const ctGrowthDefinition* definition, LoopShape* shape, const char** problem);

void freeLoopShape(LoopShape* shape);

/* The largest overlap that a pair may have. */
static inline double toleranceOf(const LoopShape* shape, uint8_t role1, uint8_t role2) {
  const bool mayBond = ((role1 & CT_GROWTH_DONOR) && (role2 & CT_GROWTH_ACCEPTOR)) ||
                       ((role1 & CT_GROWTH_ACCEPTOR) && (role2 & CT_GROWTH_DONOR));
  return shape->tolerance + (mayBond ? shape->allowance : 0);
}

static inline bool arePartners(const Partners* partners, int i, int j) {
  for (int k = partners->firsts[i]; k < partners->firsts[i + 1]; k++) {
    if (partners->items[k] == j) {
      return true;
    }
  }
  return false;
}

#endif /* CT_LOOPSHAPE_H_ */
