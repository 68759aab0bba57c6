/* Runs of leaves that move against each other in a view, and how far at most. */
#ifndef CT_LEAFRUNS_H_
#define CT_LEAFRUNS_H_

#include "../costs.h"
#include "view.h"

/* Divides the leaves of a view into runs. False if there is no memory. */
bool CT_WIDE(listRuns)(Clearance* c, const Traversal* t);

/* Calls `visit` for each two runs that move against each other, once their displacements are bounded. Ends with true as
 * soon as `visit` returns true. Adds the cost of the bounds. */
typedef bool RunPairFunction(Clearance* c, Traversal* t, const RunPair* pair, void* context);
bool CT_WIDE(forEachRunPair)(Clearance* c, Traversal* t, RunPairFunction* visit, void* context, int64_t* cost);

/* The spheres of sixteen leaves in the world. */
static inline const Block* leafSpheres(const Traversal* t, int block) {
  return &t->world->members[t->world->entryOf[t->tree->levelBegin[1] + block]];
}

static inline Sphere leafSphere(const Traversal* t, int leaf) {
  return sphereOf(leafSpheres(t, coveringNode(leaf)), memberIndex(leaf));
}

/* Turns lengths into units, rounded down: by the factor too, whose 16.8 u are more than the 3 u of the quotient, the
 * product and the factor itself (u = 2^-24). */
CT_INLINE Short16 unitsOf(const Clearance* c, Float16 lengths) {
  const Float16 most = all16((float)MOST_CLEARANCE);
  return shortsOf16(min16(max16(mul16(lengths, all16(0.999999f / c->unit)), all16(0)), most));
}

/* The row for the bounds of a pair. All that are not kept have the last one. */
static inline uint16_t* displacementsOf(const Clearance* c, int pair) {
  return c->displacements + (size_t)(pair < MOST_BOUND_PAIRS ? pair : MOST_BOUND_PAIRS - 1) * (size_t)c->stride;
}

#endif /* CT_LEAFRUNS_H_ */
