/* Sweeps, compiled once for each instruction set by the file that includes this. */
#include "instructions.h"
#include "pairs.h"
#include "volume.h"

/* Functions that are compiled for clashes and for neighbours: `surfaces` is a constant wherever they are used. */
#define CT_FOR_BOTH static inline __attribute__((always_inline))

/* ---- Bounds ---- */

static void boundLeaf(const Block* block, Extents* around, int k) {
  const float* x[3] = {block->x, block->y, block->z};
  const unsigned empty = greater16(all16(0), load16(block->r));
  for (int d = 0; d < 3; d++) {
    around->low[d][k] = least16(load16(x[d]));
    around->high[d][k] = most16(blend16(empty, load16(x[d]), all16(-INFINITY)));
  }
  around->r[k] = most16(load16(block->r));
}

static void boundNode(const Extents* members, Extents* around, int k) {
  for (int d = 0; d < 3; d++) {
    around->low[d][k] = least16(load16(members->low[d]));
    around->high[d][k] = most16(load16(members->high[d]));
  }
  around->r[k] = most16(load16(members->r));
}

/* No coordinate or radius of member k is larger. */
static double extentOf(const Extents* around, int k) {
  double corner[3] = {0, 0, 0};
  for (int d = 0; d < 3 && around->r[k] >= 0; d++) {
    corner[d] = larger(fabs((double)around->low[d][k]), fabs((double)around->high[d][k]));
  }
  return sqrt(dot(corner, corner)) + larger((double)around->r[k], 0);
}

static void fillLeaf(const Snapshot* snapshot, const int* particle, int size, Block* block) {
  for (int k = 0; k < TREE_WIDTH; k++) {
    const bool empty = k >= size || particle[k] == CT_NULL;
    const double* x = empty ? NULL : snapshotPosition(snapshot, particle[k]);
    block->x[k] = empty ? INFINITY : (float)(x[0] - snapshot->origin[0]);
    block->y[k] = empty ? INFINITY : (float)(x[1] - snapshot->origin[1]);
    block->z[k] = empty ? INFINITY : (float)(x[2] - snapshot->origin[2]);
  }
}

static int sizeOfLeaf(const Tree* layout, int leaf) {
  int end;
  const int begin = treeSlots(layout, 0, leaf, &end);
  return end - begin;
}

static void boundSnapshot(Snapshot* snapshot, const Sequence* sequence, const Tree* layout) {
  Extents root; /* the root is member 0 of this */
  for (int level = 0; level < layout->levelCount; level++) {
    for (int i = 0; i < layout->levelSize[level]; i++) {
      const int item = layout->levelBegin[level] + i;
      const bool isRoot = level == treeTop(layout);
      Extents* around = isRoot ? &root : snapshotExtents(snapshot, layout, treeParent(layout, level, item));
      if (level == 0) {
        Block* block = &snapshot->leaf[item];
        fillLeaf(snapshot, sequence->slotParticle + item * TREE_WIDTH, sizeOfLeaf(layout, item), block);
        boundLeaf(block, around, i % TREE_WIDTH);
      } else {
        boundNode(snapshotExtents(snapshot, layout, item), around, i % TREE_WIDTH);
      }
    }
  }
  snapshot->extent = extentOf(&root, 0);
  snapshot->band = DOUBLE_MARGIN * snapshot->extent;
}

/* ---- Filters ---- */

typedef struct Pass {
  const Sweep* sweep;
  SweepTask* task;
  float reach;       /* with room for rounding */
  float nearSquared; /* of centres: pairs farther apart do not matter */
  float sureSquared; /* of centres: pairs nearer are neighbours */
} Pass;

/* Of sixteen boxes those that come near box k of others; bits. */
CT_FOR_BOTH unsigned nearExtent(const Pass* pass, const float* const low[3], const float* const high[3], const float* r,
                                const Extents* others, int k, bool surfaces) {
  Float16 squared = all16(0);
  for (int d = 0; d < 3; d++) {
    const Float16 above = sub16(load16(low[d]), all16(others->high[d][k]));
    const Float16 below = sub16(all16(others->low[d][k]), load16(high[d]));
    const Float16 gap = max16(max16(above, below), all16(0));
    squared = add16(squared, mul16(gap, gap));
  }
  if (!surfaces) {
    return greater16(all16(pass->nearSquared), squared);
  }
  const Float16 sum = max16(add16(load16(r), all16(others->r[k] + pass->reach)), all16(0));
  return greater16(mul16(sum, sum), squared);
}

CT_FOR_BOTH unsigned membersNear(const Pass* pass, const Extents* members, const Extents* others, int k,
                                 bool surfaces) {
  const float* low[3] = {members->low[0], members->low[1], members->low[2]};
  const float* high[3] = {members->high[0], members->high[1], members->high[2]};
  return nearExtent(pass, low, high, members->r, others, k, surfaces);
}

/* The same against the box around all members of an item of a level below the top. */
CT_FOR_BOTH unsigned membersNearItem(const Pass* pass, int level, const Extents* members, int item, bool surfaces) {
  const Tree* layout = pass->sweep->layout;
  const Extents* others = snapshotExtents(&pass->sweep->snapshot, layout, treeParent(layout, level, item));
  return membersNear(pass, members, others, (item - layout->levelBegin[level]) % TREE_WIDTH, surfaces);
}

CT_FOR_BOTH unsigned slotsNear(const Pass* pass, int leaf, const Extents* others, int k, bool surfaces) {
  const Block* block = &pass->sweep->snapshot.leaf[leaf];
  const float* x[3] = {block->x, block->y, block->z};
  return nearExtent(pass, x, x, block->r, others, k, surfaces);
}

/* ---- Two leaves ---- */

typedef struct LeafPair {
  int a;
  int b;
  unsigned slots;           /* those of a that come near b */
  const uint16_t* excluded; /* per slot of a those of b that make no pair with it */
} LeafPair;

static double squaredApart(const Pass* pass, int slotA, int slotB) {
  const Snapshot* snapshot = &pass->sweep->snapshot;
  const int* particle = pass->sweep->sequence->slotParticle;
  return squaredDistance(snapshotPosition(snapshot, particle[slotA]), snapshotPosition(snapshot, particle[slotB]));
}

/* Per slot of a what has been found among those of b. */
typedef struct Found {
  uint16_t mask[TREE_WIDTH];
  unsigned any;
} Found;

static bool tellClashes(const Pass* pass, const LeafPair* pair, const Found* found) {
  const SweepTask* task = pass->task;
  for (unsigned slots = pair->slots; slots != 0; slots &= slots - 1) {
    const int k = __builtin_ctz(slots);
    const int slotA = pair->a * TREE_WIDTH + k;
    for (unsigned mask = found->mask[k]; mask != 0; mask &= mask - 1) {
      const int slotB = pair->b * TREE_WIDTH + __builtin_ctz(mask);
      if (!task->clash(task->context, slotA, slotB, squaredApart(pass, slotA, slotB))) {
        return false;
      }
    }
  }
  return true;
}

static bool findClashes(const Pass* pass, const LeafPair* pair) {
  const Block* blockA = &pass->sweep->snapshot.leaf[pair->a];
  const Block* blockB = &pass->sweep->snapshot.leaf[pair->b];
  const Float16 reach = add16(load16(blockB->r), all16(pass->reach));
  Found found;
  found.any = 0;
  for (unsigned slots = pair->slots; slots != 0; slots &= slots - 1) {
    const int k = __builtin_ctz(slots);
    const Float16 squared = squaredFrom(blockB, blockA->x[k], blockA->y[k], blockA->z[k]);
    const Float16 sum = max16(add16(reach, all16(blockA->r[k])), all16(0));
    const unsigned touching = greater16(mul16(sum, sum), squared) & ~(unsigned)pair->excluded[k];
    found.mask[k] = (uint16_t)touching;
    found.any |= touching;
  }
  return found.any == 0 || tellClashes(pass, pair, &found);
}

/* Of pairs of which float cannot tell, adds those that are neighbours. */
static void addDoubtful(const Pass* pass, const LeafPair* pair, const Found* found) {
  PairSink* sink = pass->task->sink;
  const int* particle = pass->sweep->sequence->slotParticle;
  for (unsigned slots = pair->slots; slots != 0; slots &= slots - 1) {
    const int k = __builtin_ctz(slots);
    const int slotA = pair->a * TREE_WIDTH + k;
    for (unsigned mask = found->mask[k]; mask != 0; mask &= mask - 1) {
      const int slotB = pair->b * TREE_WIDTH + __builtin_ctz(mask);
      if (pass->task->isNear(pass->task->context, slotA, slotB, squaredApart(pass, slotA, slotB))) {
        const bool rising = particle[slotA] < particle[slotB];
        sink->lower[sink->count] = particle[rising ? slotA : slotB];
        sink->higher[sink->count++] = particle[rising ? slotB : slotA];
      }
    }
  }
}

static bool addNeighbors(const Pass* pass, const LeafPair* pair) {
  PairSink* sink = pass->task->sink;
  if (sink->capacity - sink->count < PAIRS_OF_LEAVES && !sink->makeRoom(sink)) {
    return false;
  }
  const Block* blockA = &pass->sweep->snapshot.leaf[pair->a];
  const Block* blockB = &pass->sweep->snapshot.leaf[pair->b];
  const int* particlesA = pass->sweep->sequence->slotParticle + pair->a * TREE_WIDTH;
  const Ids16 particlesB = loadIds16(pass->sweep->sequence->slotParticle + pair->b * TREE_WIDTH);
  const uint16_t* excluded = pair->excluded;
  const Float16 nearSquared = all16(pass->nearSquared);
  const Float16 sureSquared = all16(pass->sureSquared);
  int* lower = sink->lower + sink->count;
  int* higher = sink->higher + sink->count;
  Found doubtful;
  doubtful.any = 0;
  for (unsigned slots = pair->slots; slots != 0; slots &= slots - 1) {
    const int k = __builtin_ctz(slots);
    const Float16 squared = squaredFrom(blockB, blockA->x[k], blockA->y[k], blockA->z[k]);
    const unsigned near = greater16(nearSquared, squared) & ~(unsigned)excluded[k];
    const unsigned sure = greater16(sureSquared, squared) & near;
    const int count = pairs16(sure, particlesB, particlesA[k], lower, higher);
    lower += count;
    higher += count;
    doubtful.mask[k] = (uint16_t)(near ^ sure);
    doubtful.any |= near ^ sure;
  }
  sink->count = (size_t)(lower - sink->lower);
  if (doubtful.any != 0) {
    addDoubtful(pass, pair, &doubtful);
  }
  return true;
}

/* ---- The sweep ---- */

/* A leaf against leaves whose bits are set, counted from leaf firstB, with boxes aroundB. */
CT_FOR_BOTH bool sweepLeaves(const Pass* pass, int a, int firstB, const Extents* aroundB, unsigned near,
                             bool surfaces) {
  static const uint16_t nothing[TREE_WIDTH] = {0};
  uint16_t ownExcluded[TREE_WIDTH];
  const Exclusions* exclusions = pass->sweep->exclusions;
  const int sizeA = sizeOfLeaf(pass->sweep->layout, a);
  int partner = exclusionsFrom(exclusions, a, firstB);
  bool goesOn = true;
  for (; goesOn && near != 0; near &= near - 1) {
    const int l = __builtin_ctz(near);
    LeafPair pair = {a, firstB + l, (1u << sizeA) - 1, nothing};
    while (partner < exclusions->begin[a + 1] && exclusions->partner[partner] < pair.b) {
      partner++;
    }
    if (partner < exclusions->begin[a + 1] && exclusions->partner[partner] == pair.b) {
      pair.excluded = exclusions->mask[partner];
    }
    if (pair.b == a) {
      /* Each pair once. */
      for (int k = 0; k < TREE_WIDTH; k++) {
        ownExcluded[k] = (uint16_t)(pair.excluded[k] | ((2u << k) - 1));
      }
      pair.excluded = ownExcluded;
      pass->task->particleTests += sizeA * (sizeA - 1) / 2;
    } else {
      pair.slots = slotsNear(pass, a, aroundB, l, surfaces);
      pass->task->volumeTests += sizeA;
      pass->task->particleTests += __builtin_popcount(pair.slots) * sizeOfLeaf(pass->sweep->layout, pair.b);
    }
    if (pair.slots != 0) {
      goesOn = surfaces ? findClashes(pass, &pair) : addNeighbors(pass, &pair);
    }
  }
  return goesOn;
}

/* Members of node a that may be near members of node b. Where both wind through the same room the boxes of all but few
 * of their members may be far from the other's (section 4). */
CT_FOR_BOTH unsigned rowsOf(const Pass* pass, const SweepVisit* visit, int countA, int countB, bool surfaces) {
  const Snapshot* snapshot = &pass->sweep->snapshot;
  const Tree* layout = pass->sweep->layout;
  if (visit->a == visit->b) {
    return (1u << countA) - 1;
  }
  pass->task->volumeTests += countA;
  const Extents* aroundA = snapshotExtents(snapshot, layout, visit->a);
  const unsigned rows = membersNearItem(pass, visit->level, aroundA, visit->b, surfaces);
  if (rows == 0) {
    return 0;
  }
  pass->task->volumeTests += countB;
  const Extents* aroundB = snapshotExtents(snapshot, layout, visit->b);
  return membersNearItem(pass, visit->level, aroundB, visit->a, surfaces) == 0 ? 0 : rows;
}

CT_FOR_BOTH void sweepPairs(const Pass* pass, bool surfaces) {
  const Sweep* sweep = pass->sweep;
  const Tree* layout = sweep->layout;
  const int root = treeRoot(layout);
  if (treeTop(layout) == 0) {
    sweepLeaves(pass, root, root, NULL, 1, surfaces);
    return;
  }
  int depth = 0;
  sweep->stack[depth++] = (SweepVisit){treeTop(layout), root, root};
  while (depth > 0) {
    const SweepVisit visit = sweep->stack[--depth];
    int countA;
    int countB;
    const int firstA = treeChildren(layout, visit.level, visit.a, &countA);
    const int firstB = treeChildren(layout, visit.level, visit.b, &countB);
    const Extents* aroundA = snapshotExtents(&sweep->snapshot, layout, visit.a);
    const Extents* aroundB = snapshotExtents(&sweep->snapshot, layout, visit.b);
    const unsigned rows = rowsOf(pass, &visit, countA, countB, surfaces);
    for (int i = 0; i < countA; i++) {
      /* What is left for later goes last in, first out: leaves come in ascending order. */
      const int k = visit.level == 1 ? i : countA - 1 - i;
      if ((rows >> k & 1) == 0 || aroundA->r[k] < 0) {
        continue;
      }
      unsigned near = membersNear(pass, aroundB, aroundA, k, surfaces);
      if (visit.a == visit.b) {
        near &= ~0u << k;
      }
      pass->task->volumeTests += visit.a == visit.b ? countB - k : countB;
      if (visit.level == 1) {
        if (!sweepLeaves(pass, firstA + k, firstB, aroundB, near, surfaces)) {
          return;
        }
        continue;
      }
      while (near != 0) {
        const int l = 31 - __builtin_clz(near);
        sweep->stack[depth++] = (SweepVisit){visit.level - 1, firstA + k, firstB + l};
        near &= ~(1u << l);
      }
    }
  }
}

static Pass startPass(const Sweep* sweep, SweepTask* task) {
  const double margin = floatMargin(sweep->snapshot.extent + fabs(task->reach));
  const float near = (float)(task->reach + margin);
  const float sure = (float)larger(task->reach - margin, 0);
  return (Pass){sweep, task, near, near * near, sure * sure};
}

static void sweepClashes(const Sweep* sweep, SweepTask* task) {
  const Pass pass = startPass(sweep, task);
  sweepPairs(&pass, true);
}

static void sweepNeighbors(const Sweep* sweep, SweepTask* task) {
  const Pass pass = startPass(sweep, task);
  sweepPairs(&pass, false);
}

static void neighborDistances(const double* position, double cutoff, size_t count, const int* lower, const int* higher,
                              double* distances) {
  size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    distances4(position, lower + i, higher + i, cutoff, distances + i);
  }
  for (; i < count; i++) {
    const double* a = position + 3 * (size_t)lower[i];
    const double* b = position + 3 * (size_t)higher[i];
    distances[i] = lesser(sqrt(squaredDistance(a, b)), cutoff);
  }
}
