/* The wide functions work on sixteen members at a time. The files in `wide` define them and are compiled once for each
 * instruction set. All sets give the same bits: every operation rounds each lane once, and none is fused. */
#ifndef CT_WIDE_H_
#define CT_WIDE_H_

#include "clearance.h"
#include "leaves.h"
#include "nearest.h"
#include "recentclashes.h"
#include "sweep.h"

/* F(result, name, parameters) for each wide function that the rest of the engine calls. */
/* clang-format off */
#define CT_WIDE_FUNCTIONS(F) \
  /* wide/refresh.c: the update of a tree, bottom-up. */ \
  F(void, refreshLeaf, (Tree* tree, const Sequence* sequence, int leaf)) \
  F(Frame, linkInLeaf, (const Sequence* sequence, int link, int leaf)) \
  F(Frame, linkAndLocalFrames, (const Sequence* sequence, int link, LocalFrames* localFrames)) \
  F(bool, refreshSideBranch, (Tree* tree, const Sequence* sequence, int link, int leaf)) \
  F(bool, refreshSlot, (Tree* tree, const Sequence* sequence, int slot, const Frame* inLeaf)) \
  F(void, refreshInnerNode, (Tree* tree, int level, int node, const int* changed, int count)) \
  F(void, refreshLeafBound, (Tree* tree, int leaf)) \
  F(void, widenAbove, (Tree* tree, int leaf)) \
  /* wide/world.c: see world.h. */ \
  F(void, updateWorldAt, (World* w, int level, int node)) \
  /* wide/descent.c, movers.c, images.c: see traverse.h. */ \
  F(int64_t, traverse, \
    (Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts)) \
  F(void, traverseFew, \
    (Traversal* t, const View* view, int begin, int end, CandidateFunction* function, SureClashFunction* clashes, \
     void* context, ctCounts* counts)) \
  F(void, traverseFewImages, \
    (Traversal* t, const View* view, const PeriodicBox* box, int begin, int end, CandidateFunction* function, \
     void* context, ctCounts* counts)) \
  F(int64_t, traverseImages, \
    (Traversal* t, const View* view, const PeriodicBox* box, bool isPlaced, CandidateFunction* function, \
     void* context, ctCounts* counts)) \
  F(void, traverseProbe, \
    (Traversal* t, const View* view, const double point[3], double radius, CandidateFunction* function, void* context, \
     ctCounts* counts)) \
  /* wide/recentclashes.c */ \
  F(bool, testRecentClashes, \
    (const RecentClashes* w, Traversal* t, const View* view, CandidateFunction* function, void* context, \
     ctCounts* counts, int64_t* cost)) \
  /* wide/clearance.c: testing and accepting return their cost. Drop earlier tests first. */ \
  F(void, measureClearances, (Clearance* c, Traversal* t, double reach)) \
  F(int64_t, testByClearance, \
    (Clearance* c, Traversal* t, const View* view, ClearanceFunction* function, void* context, ctCounts* counts)) \
  F(int64_t, acceptClearances, (Clearance* c, Traversal* t, const View* view)) \
  /* wide/snapshot.c, clashes.c, neighbors.c: see sweep.h. */ \
  F(void, boundSnapshot, (Snapshot* snapshot, const Sequence* sequence, const Tree* layout)) \
  F(void, sweepClashes, (Sweep* sweep, SweepTask* task)) \
  F(void, sweepNeighbors, (Sweep* sweep, SweepTask* task)) \
  F(void, neighborDistances, \
    (const double* position, double cutoff, size_t count, const int* lower, const int* higher, double* distances)) \
  /* wide/leaves.c, leafpairs.c: see leaves.h. */ \
  F(void, updateLeaves, (const LeafUpdate* update)) \
  F(void, listLeafPairs, (LeafTask* task)) \
  F(void, listChangedSlots, (LeafTask* task)) \
  /* wide/nearest.c: for ctGetMinimumDistance. */ \
  F(void, boundPoints, (const Tree* layout, const double (*point)[3], Block* block)) \
  F(void, boundCloud, (const Cloud* cloud, double low[3], double high[3])) \
  F(void, findNearest, (Nearest* nearest, const Cloud clouds[2]))
/* clang-format on */

/* The functions as one instruction set has them. */
#define CT_POINTER(result, name, parameters) result(*name) parameters;
typedef struct Wide {
  const char* name; /* of the instruction set */
  CT_WIDE_FUNCTIONS(CT_POINTER)
} Wide;
#undef CT_POINTER

/* The functions of the widest set that the machine has, unless the environment asks for a narrower one. */
const Wide* ctChooseWide(void);

#endif /* CT_WIDE_H_ */
