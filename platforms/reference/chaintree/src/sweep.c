#include "sweep.h"

#include <limits.h>

#include "counts.h"
#include "wide.h"

void ctSweepInit(Sweep* sweep, const Tree* layout, const Sequence* sequence, const Exclusions* exclusions) {
  sweep->layout = layout;
  sweep->sequence = sequence;
  sweep->exclusions = exclusions;
  sweep->snapshot.builtFrom = NO_REVISION;
}

void ctSweepFree(Sweep* sweep) {
  ctArenaFree(&sweep->arena);
}

static void fillRanks(Ranks* ranks) {
  for (unsigned byte = 0; byte < 256; byte++) {
    for (unsigned bit = 0; bit < 8; bit++) {
      if ((byte >> bit & 1) != 0) {
        ranks->bit[byte][ranks->count[byte]++] = (uint8_t)bit;
      }
    }
  }
}

static void findParticles(Sweep* sweep) {
  const int* particle = sweep->sequence->slotParticle;
  for (int slot = 0; slot < sweep->layout->slotCount; slot++) {
    int* lowest = &sweep->lowest[coveringNode(slot)];
    int* highest = &sweep->highest[coveringNode(slot)];
    if (memberIndex(slot) == 0) {
      *lowest = INT_MAX;
      *highest = -1;
    }
    if (slotIsModelled(sweep->sequence, slot)) {
      *lowest = particle[slot] < *lowest ? particle[slot] : *lowest;
      *highest = particle[slot] > *highest ? particle[slot] : INT_MAX;
    }
  }
}

bool ctSweepReserve(Sweep* sweep) {
  if (sweep->ranks != NULL) {
    return true;
  }
  Arena* arena = &sweep->arena;
  Candidates* candidates = &sweep->candidates;
  const size_t leaves = (size_t)sweep->layout->levelBegin[1];
  const size_t slots = (leaves < LEAVES_AT_ONCE ? leaves : LEAVES_AT_ONCE) * TREE_WIDTH;
  Ranks* ranks = ctArenaAllocate(arena, 1, sizeof(Ranks));
  sweep->lowest = ctArenaAllocate(arena, leaves, sizeof *sweep->lowest);
  sweep->highest = ctArenaAllocate(arena, leaves, sizeof *sweep->highest);
  /* With room behind, since they are written sixteen at a time. */
  sweep->nodes = ctArenaAllocate(arena, (size_t)sweep->layout->levelSize[1] + TREE_WIDTH, sizeof *sweep->nodes);
  candidates->leaves = ctArenaAllocate(arena, leaves + TREE_WIDTH, sizeof *candidates->leaves);
  candidates->offset = ctArenaAllocate(arena, slots + TREE_WIDTH, sizeof *candidates->offset);
  candidates->particle = ctArenaAllocate(arena, slots + TREE_WIDTH, sizeof *candidates->particle);
  candidates->pairs = ctArenaAllocate(arena, slots + TREE_WIDTH, sizeof *candidates->pairs);
  if (!ctSnapshotBuild(&sweep->snapshot, arena, sweep->sequence, sweep->layout)) {
    ctArenaFree(arena);
    return false;
  }
  fillRanks(ranks);
  findParticles(sweep);
  sweep->ranks = ranks;
  return true;
}

void ctSweepBound(Sweep* sweep) {
  sweep->layout->wide->boundSnapshot(&sweep->snapshot, sweep->sequence, sweep->layout);
}

void ctSweepClashes(Sweep* sweep, double tolerance, ClashFunction* function, void* context, ctCounts* counts) {
  SweepTask task = {.reach = -tolerance, .clash = function, .context = context};
  sweep->layout->wide->sweepClashes(sweep, &task);
  addTests(counts, task.volumeTests, task.particleTests);
}

void ctSweepNeighbors(Sweep* sweep, double cutoff, PairSink* sink, DoubtFunction* isNear, void* context,
                      ctCounts* counts) {
  SweepTask task = {.reach = cutoff, .sink = sink, .isNear = isNear, .context = context};
  sweep->layout->wide->sweepNeighbors(sweep, &task);
  addTests(counts, task.volumeTests, task.particleTests);
}

void ctSweepDistances(const Sweep* sweep, double cutoff, size_t count, const int* lower, const int* higher,
                      double* distances) {
  sweep->layout->wide->neighborDistances(sweep->snapshot.position, cutoff, count, lower, higher, distances);
}
