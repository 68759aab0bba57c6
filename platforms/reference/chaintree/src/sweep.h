/* Sweeps find every pair of near particles of one state that is not excluded, by boxes along the world's axes. */
#ifndef CT_SWEEP_H_
#define CT_SWEEP_H_

#include "exclusion.h"
#include "ranks.h"
#include "snapshot.h"

/* Sizes of the parts in which a sweep for neighbours works. LEAVES_AT_ONCE bounds the memory for candidates: leaves
 * rarely have more leaves near them. */
enum { LEAVES_AT_ONCE = 1024, PAIRS_AT_ONCE = 512, CANDIDATES_AT_ONCE = 8, LOWER_AT_ONCE = 64 };

/* The slots, ascending, that are near a leaf and not before it; at most those of LEAVES_AT_ONCE leaves. */
typedef struct Candidates {
  int count;
  bool rises;      /* the lower particle of each pair is the leaf's */
  int* leaves;     /* all that are near the leaf and not before it */
  int* offset;     /* per slot: of its x from that of slot 0, in floats */
  int* particle;   /* per slot */
  uint16_t* pairs; /* per slot, bits: slots of the leaf that may be its neighbours; once compared, that are */
} Candidates;

typedef struct Sweep {
  const Tree* layout; /* its content is not read */
  const Sequence* sequence;
  const Exclusions* exclusions;
  Arena arena; /* of everything below, which is made when first needed */
  Snapshot snapshot;
  /* For neighbours. */
  Ranks* ranks; /* NULL: nothing is made yet */
  int* lowest;  /* per leaf: no particle is below */
  int* highest; /* per leaf: no particle is above, or INT_MAX if they do not ascend */
  int* nodes;   /* of level 1: near one of them */
  Candidates candidates;
} Sweep;

/* Receives neighbours, many at a time. */
typedef struct PairSink {
  int* lower; /* particles of each pair */
  int* higher;
  size_t count;
  size_t capacity;
  bool ascending; /* pairs are to ascend as far as that is cheap */
  /* Makes room for PAIRS_AT_ONCE more; returns false to end the sweep. */
  bool (*makeRoom)(struct PairSink* sink);
  void* context;
  bool isClosed; /* it has ended the sweep */
} PairSink;

/* Receives two slots and their squared distance; returns false to end the sweep. */
typedef bool ClashFunction(void* context, int slotA, int slotB, double squaredDistance);

/* Decides whether two slots whose distance is within rounding of the cutoff are neighbours. */
typedef bool DoubtFunction(void* context, int slotA, int slotB, double squaredDistance);

/* A sweep, and its cost. */
typedef struct SweepTask {
  double reach;         /* between surfaces for clashes, between centres for neighbours */
  ClashFunction* clash; /* where clashes go */
  PairSink* sink;       /* where neighbours go */
  DoubtFunction* isNear;
  void* context;
  int64_t volumeTests;
  int64_t particleTests;
} SweepTask;

void ctSweepInit(Sweep* sweep, const Tree* layout, const Sequence* sequence, const Exclusions* exclusions);
void ctSweepFree(Sweep* sweep);

/* Makes the snapshot and all scratch, if that is not done. False, and nothing changed, if there is no memory. */
bool ctSweepReserve(Sweep* sweep);

/* Recomputes floats and boxes of a snapshot whose positions are new. */
void ctSweepBound(Sweep* sweep);

/* Calls `function` at least for every pair of slots whose spheres overlap by more than `tolerance`, each once. */
void ctSweepClashes(Sweep* sweep, double tolerance, ClashFunction* function, void* context, ctCounts* counts);

/* Puts every pair of slots at most `cutoff` apart into the sink. */
void ctSweepNeighbors(Sweep* sweep, double cutoff, PairSink* sink, DoubtFunction* isNear, void* context,
                      ctCounts* counts);

/* The distances of neighbours, none above the cutoff: rounding is cut off. */
void ctSweepDistances(const Sweep* sweep, double cutoff, size_t count, const int* lower, const int* higher,
                      double* distances);

#endif /* CT_SWEEP_H_ */
