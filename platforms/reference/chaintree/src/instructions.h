/* The functions that are compiled once for each instruction set: those that work on sixteen members at a time. */
#ifndef CT_INSTRUCTIONS_H_
#define CT_INSTRUCTIONS_H_

#include "clearance.h"
#include "leaves.h"
#include "nearest.h"
#include "sweep.h"
#include "witness.h"

typedef struct InstructionSet {
  const char* name;

  /* The update of a tree, bottom-up; see refresh_body.h. */
  void (*refreshLeaf)(Tree* tree, const Sequence* sequence, int leaf);
  Frame (*linkInLeaf)(const Sequence* sequence, int link);
  Frame (*openLeaf)(const Sequence* sequence, int link, Openings* openings);
  bool (*refreshTwig)(Tree* tree, const Sequence* sequence, int link, int leaf);
  void (*refreshInnerNode)(Tree* tree, int level, int node, const int* changed, int count);
  void (*refreshLeafBound)(Tree* tree, int leaf);
  void (*widenAbove)(Tree* tree, int leaf);

  /* For ctTraversalLeafFrame, ctTraverse, ctTraverseFew and ctTraverseProbe. */
  void (*updateWorldLeaf)(Traversal* t, int leaf);
  int64_t (*traverse)(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts);
  void (*traverseFew)(Traversal* t, const View* view, int begin, int end, CandidateFunction* function,
                      ClashFunction* clashes, void* context, ctCounts* counts);
  void (*probe)(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                void* context, ctCounts* counts);

  /* See witness_body.h. */
  bool (*askWitnesses)(const Witnesses* w, Traversal* t, const View* view, CandidateFunction* function, void* context,
                       ctCounts* counts, int64_t* cost);

  /* See clearance.h and clearance_body.h; tests and commits return what they have cost. */
  void (*measureClearances)(Clearance* c, Traversal* t, double reach);
  int64_t (*testByClearance)(Clearance* c, Traversal* t, const View* view, ClearanceFunction* function, void* context,
                             ctCounts* counts);
  int64_t (*commitClearances)(Clearance* c, Traversal* t, const View* view);

  /* For ctSweepBound, ctSweepClashes, ctSweepNeighbors and ctSweepDistances. */
  void (*boundSnapshot)(Snapshot* snapshot, const Sequence* sequence, const Tree* layout);
  void (*sweepClashes)(Sweep* sweep, SweepTask* task);
  void (*sweepNeighbors)(Sweep* sweep, SweepTask* task);
  void (*neighborDistances)(const double* position, double cutoff, size_t count, const int* lower, const int* higher,
                            double* distances);

  /* See leaves.h; leaves_body.h and leafpairs_body.h. */
  void (*updateLeaves)(const LeafUpdate* update);
  void (*listLeafPairs)(LeafTask* task);

  /* For ctGetMinimumDistance; see nearest_body.h. */
  void (*boundPoints)(const Tree* layout, const double (*point)[3], Block* block);
  void (*findNearest)(Nearest* nearest, const Cloud clouds[2]);
} InstructionSet;

/* The widest that the machine has, unless the environment asks for a narrower one. */
const InstructionSet* ctChooseInstructions(void);

extern const InstructionSet ctPortable;
#ifdef __x86_64__
extern const InstructionSet ctAvx2;
extern const InstructionSet ctAvx512;
#endif

#endif /* CT_INSTRUCTIONS_H_ */
