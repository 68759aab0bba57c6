#include "sweep.h"

#include "instructions.h"

void ctSweepInit(Sweep* sweep, const Tree* layout, const Sequence* sequence, const Exclusions* exclusions) {
  sweep->layout = layout;
  sweep->sequence = sequence;
  sweep->exclusions = exclusions;
  sweep->since = NEVER;
}

void ctSweepFree(Sweep* sweep) {
  ctArenaFree(&sweep->arena);
}

bool ctSweepReserve(Sweep* sweep) {
  if (sweep->stack != NULL) {
    return true;
  }
  /* What a visit leaves for later: all children of one node with all of another. */
  const size_t visits = (size_t)TREE_MAX_LEVELS * TREE_WIDTH * TREE_WIDTH;
  SweepVisit* stack = ctArenaAllocate(&sweep->arena, visits, sizeof(SweepVisit));
  if (!ctSnapshotBuild(&sweep->snapshot, &sweep->arena, sweep->sequence, sweep->layout)) {
    ctArenaFree(&sweep->arena);
    return false;
  }
  sweep->stack = stack;
  return true;
}

void ctSweepBound(Sweep* sweep) {
  sweep->layout->instructions->boundSnapshot(&sweep->snapshot, sweep->sequence, sweep->layout);
}

static void addCounts(ctCounts* counts, const SweepTask* task) {
  if (counts != NULL) {
    counts->volumeTests += task->volumeTests;
    counts->particleTests += task->particleTests;
  }
}

void ctSweepClashes(Sweep* sweep, double tolerance, ClashFunction* function, void* context, ctCounts* counts) {
  SweepTask task = {.reach = -tolerance, .clash = function, .context = context};
  sweep->layout->instructions->sweepClashes(sweep, &task);
  addCounts(counts, &task);
}

void ctSweepNeighbors(Sweep* sweep, double cutoff, PairSink* sink, DoubtFunction* isNear, void* context,
                      ctCounts* counts) {
  SweepTask task = {.reach = cutoff, .sink = sink, .isNear = isNear, .context = context};
  sweep->layout->instructions->sweepNeighbors(sweep, &task);
  addCounts(counts, &task);
}

void ctSweepDistances(const Sweep* sweep, double cutoff, size_t count, const int* lower, const int* higher,
                      double* distances) {
  sweep->layout->instructions->neighborDistances(sweep->snapshot.position, cutoff, count, lower, higher, distances);
}
