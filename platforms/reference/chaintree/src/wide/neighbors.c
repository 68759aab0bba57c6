/* The sweep for neighbours, leaf by leaf. */
#include <limits.h>
#include <string.h>

#include "boxdescent.h"
#include "near.h"

/* ---- The candidates of a leaf ---- */

/* A search for the nodes of level 1 that are within reach of one of them and not before it. */
typedef struct NodeSearch {
  const Pass* pass;
  int own;
  const SnapshotBoxes* around; /* its siblings' boxes and its own */
  int count;                   /* of nodes found, which are in Sweep.nodes */
} NodeSearch;

/* The member that holds the own node, of a node that holds it. */
CT_VISITOR unsigned memberOverOwn(void* search, int level, int a, int b) {
  const NodeSearch* nodes = search;
  const int rank = nodes->own - nodes->pass->sweep->layout->levelBegin[1];
  (void)a;
  (void)b;
  return 1u << memberIndex(rank >> TREE_WIDTH_BITS * (level - 2));
}

CT_VISITOR unsigned membersNearOwn(void* search, int level, int a, int k, int b) {
  const NodeSearch* nodes = search;
  const Sweep* sweep = nodes->pass->sweep;
  nodes->pass->task->volumeTests += treeMemberCount(sweep->layout, level, b);
  return membersNear(nodes->pass, snapshotBoxes(&sweep->snapshot, sweep->layout, b), nodes->around,
                     memberIndex(nodes->own - sweep->layout->levelBegin[1]), false) &
         notBefore(a, k, b);
}

CT_VISITOR bool addNodes(void* search, int own, int first, unsigned near) {
  NodeSearch* nodes = search;
  const Sweep* sweep = nodes->pass->sweep;
  (void)own;
  nodes->count += (int)closeNumbers16(sweep->ranks, near, first, sweep->nodes + nodes->count);
  return true;
}

/* Lists the nodes of level 1 that are within reach of one of them and not before it. Returns how many. */
static int listNodes(const Pass* pass, int own) {
  const Sweep* sweep = pass->sweep;
  NodeSearch nodes = {pass, own, snapshotBoxes(&sweep->snapshot, sweep->layout, treeParent(sweep->layout, 1, own)), 0};
  const BoxVisitor visitor = {memberOverOwn, membersNearOwn, addNodes, false};
  descendBoxes(&nodes, sweep->layout, 2, visitor);
  return nodes.count;
}

/* Lists the leaves that are within reach of a leaf, which is child k of a node, and not before it. They lie in the
 * first `nodeCount` of `nodes`. Returns how many. */
static int listNear(const Pass* pass, int node, int k, int nodeCount) {
  const Sweep* sweep = pass->sweep;
  const Tree* layout = sweep->layout;
  const SnapshotBoxes* around = snapshotBoxes(&sweep->snapshot, layout, node);
  int* leaves = sweep->candidates.leaves;
  size_t count = 0;
  int members;
  for (int n = 0; n < nodeCount; n++) {
    const int other = sweep->nodes[n];
    const int first = treeChildren(layout, 1, other, &members);
    unsigned near = membersNear(pass, snapshotBoxes(&sweep->snapshot, layout, other), around, k, false);
    near &= other == node ? ~0u << k : ~0u;
    count += closeNumbers16(sweep->ranks, near, first, leaves + count);
  }
  pass->task->volumeTests += nodeCount * TREE_WIDTH;
  return (int)count;
}

/* ---- Slots near a leaf ---- */

/* Floats from one leaf to the next in a snapshot. */
enum { LEAF_FLOATS = (int)(sizeof(Block) / sizeof(float)) };

static inline int slotAt(int offset) {
  return offset / LEAF_FLOATS * TREE_WIDTH + offset % LEAF_FLOATS;
}

/* Clears pairs of candidates that are slots of one leaf: `forbidden` has, for each of its slots, bits of slots of the
 * own leaf. */
static void forbidPairs(const Candidates* candidates, int first, int count, const uint16_t* forbidden) {
  for (int i = first; i < first + count; i++) {
    const unsigned slot = (unsigned)slotAt(candidates->offset[i]) % TREE_WIDTH;
    candidates->pairs[i] = (uint16_t)(candidates->pairs[i] & ~forbidden[slot]);
  }
}

/* Gathers the candidates of a leaf, which has this box, from entries first ... last - 1 of the list of leaves. */
static void gatherCandidates(const Pass* pass, int leaf, const AxisBox* box, int first, int last) {
  /* Within the leaf, each pair once. */
  static const uint16_t behind[TREE_WIDTH] = {0xffff, 0xfffe, 0xfffc, 0xfff8, 0xfff0, 0xffe0, 0xffc0, 0xff80,
                                              0xff00, 0xfe00, 0xfc00, 0xf800, 0xf000, 0xe000, 0xc000, 0x8000};
  const Sweep* sweep = pass->sweep;
  const Exclusions* exclusions = sweep->exclusions;
  Candidates* candidates = &pass->sweep->candidates;
  int partner = exclusionsFrom(exclusions, leaf, candidates->leaves[first]);
  int lowest = INT_MAX;
  int count = 0;
  for (int i = first; i < last; i++) {
    const int other = candidates->leaves[i];
    const Slots slots = slotsOf(&sweep->snapshot.leaf[other]);
    const unsigned near = slotsNear(pass, &slots, box, false);
    closeNumbers16(sweep->ranks, near, other * LEAF_FLOATS, candidates->offset + count);
    storeShorts(candidates->pairs + count, allShorts(0xffff));
    const int size = (int)closeRanks16(sweep->ranks, near, loadIds(sweep->sequence->slotParticle + other * TREE_WIDTH),
                                       candidates->particle + count);
    if (other == leaf) {
      forbidPairs(candidates, count, size, behind);
    } else {
      lowest = sweep->lowest[other] < lowest ? sweep->lowest[other] : lowest;
    }
    if (exclusionReaches(exclusions, leaf, other, &partner)) {
      forbidPairs(candidates, count, size, exclusions->mask[exclusionPartner(exclusions, other, leaf)]);
    }
    count += size;
  }
  pass->task->volumeTests += (last - first) * TREE_WIDTH;
  candidates->count = count;
  /* Up to CANDIDATES_AT_ONCE more are compared. */
  storeShorts(candidates->pairs + count, allShorts(0));
  pass->task->particleTests += (int64_t)count * TREE_WIDTH;
  candidates->rises = sweep->highest[leaf] < lowest;
}

/* ---- Pairs of a leaf and its candidates ---- */

/* A leaf and its candidates. Copies of all pointers, since a compiler must assume that writing pairs changes the
 * originals. */
typedef struct Own {
  Slots slots;
  Ids16 ids;
  Candidates candidates;
  const float* coordinates;
} Own;

CT_INLINE Own ownOf(const Pass* pass, int leaf) {
  const Sweep* sweep = pass->sweep;
  return (Own){slotsOf(&sweep->snapshot.leaf[leaf]), loadIds(sweep->sequence->slotParticle + leaf * TREE_WIDTH),
               sweep->candidates, sweep->snapshot.leaf->x};
}

CT_INLINE Float16 squaredFromCandidate(const Own* own, int i) {
  const float* x = own->coordinates + own->candidates.offset[i];
  const float* y = x + TREE_WIDTH;
  const float* z = y + TREE_WIDTH;
  return squared16(sub16(own->slots.x[0], all16(*x)), sub16(own->slots.x[1], all16(*y)),
                   sub16(own->slots.x[2], all16(*z)));
}

/* Drops the slots of the leaf that are out of reach of a candidate. */
CT_INLINE void compareCandidate(const Own* own, int i, Under* under) {
  uint16_t* pairs = &own->candidates.pairs[i];
  *pairs = (uint16_t)(*pairs & under16(under, squaredFromCandidate(own, i)));
}

/* Decides about pairs of CANDIDATES_AT_ONCE candidates that are within FLOAT_MARGIN of the cutoff, by distances in
 * double. */
static __attribute__((noinline)) void settleDoubts(const Pass* pass, int leaf, int first) {
  const SweepTask* task = pass->task;
  const Own own = ownOf(pass, leaf);
  for (int i = first; i < first + CANDIDATES_AT_ONCE; i++) {
    const int slot = slotAt(own.candidates.offset[i]);
    uint16_t* pairs = &own.candidates.pairs[i];
    unsigned doubtful = *pairs & ~greater16(all16(pass->sureSquared), squaredFromCandidate(&own, i));
    for (; doubtful != 0; doubtful &= doubtful - 1) {
      const int ownSlot = leaf * TREE_WIDTH + __builtin_ctz(doubtful);
      if (!task->isNear(task->context, ownSlot, slot, squaredApart(pass, ownSlot, slot))) {
        *pairs = (uint16_t)(*pairs & ~(doubtful & -doubtful));
      }
    }
  }
}

CT_INLINE void compareCandidates(const Pass* pass, int leaf, const Own* own, int first) {
  Under under = underLimits16(pass->nearSquared, pass->sureSquared);
  for (int i = first; i < first + CANDIDATES_AT_ONCE; i++) {
    compareCandidate(own, i, &under);
  }
  if (someBetween16(&under)) {
    settleDoubts(pass, leaf, first);
  }
}

static bool hasRoom(PairSink* sink) {
  return sink->capacity - sink->count >= PAIRS_AT_ONCE || sink->makeRoom(sink);
}

/* Prefetches memory that will be written soon: long lists are rarely in caches. Harmless past their end. */
CT_INLINE void fetchAhead(const int* list) {
  for (int i = 512; i < 512 + 64; i += 16) {
    __builtin_prefetch(list + i, 1);
  }
}

/* Adds pairs candidate by candidate. False ends the sweep. */
CT_INLINE bool addAsTheyCome(const Pass* pass, int leaf, bool rises) {
  const Ranks* ranks = pass->sweep->ranks;
  PairSink* sink = pass->task->sink;
  const Own own = ownOf(pass, leaf);
  compareCandidates(pass, leaf, &own, 0);
  for (int first = 0; first < own.candidates.count; first += CANDIDATES_AT_ONCE) {
    if (!hasRoom(sink)) {
      return false;
    }
    int* lower = sink->lower + sink->count;
    int* higher = sink->higher + sink->count;
    fetchAhead(lower);
    fetchAhead(higher);
    /* Compares the next candidates while pairs of these are written: neither waits for the other. */
    const int next = first + CANDIDATES_AT_ONCE;
    Under under = underLimits16(pass->nearSquared, pass->sureSquared);
    size_t count = 0;
    for (int i = 0; i < CANDIDATES_AT_ONCE; i++) {
      const unsigned pairs = own.candidates.pairs[first + i];
      const int particle = own.candidates.particle[first + i];
      compareCandidate(&own, next + i, &under);
      count += rises ? pairsBelow16(ranks, pairs, own.ids, particle, lower + count, higher + count)
                     : pairs16(ranks, pairs, own.ids, particle, lower + count, higher + count);
    }
    sink->count += count;
    if (someBetween16(&under)) {
      settleDoubts(pass, leaf, next);
    }
  }
  return true;
}

/* Adds pairs slot by slot of a leaf whose particles are all below their candidates, so that pairs ascend. False ends
 * the sweep. */
static bool addRows(const Pass* pass, int leaf) {
  const Sweep* sweep = pass->sweep;
  const Candidates candidates = sweep->candidates;
  PairSink* sink = pass->task->sink;
  const Own own = ownOf(pass, leaf);
  for (int i = 0; i < candidates.count; i += CANDIDATES_AT_ONCE) {
    compareCandidates(pass, leaf, &own, i);
  }
  for (int i = 0; i < candidates.count; i += TREE_WIDTH) {
    uint16_t pairs[TREE_WIDTH];
    memcpy(pairs, candidates.pairs + i, sizeof pairs);
    transposeBits(pairs, candidates.pairs + i);
  }
  for (int k = 0; k < TREE_WIDTH; k++) {
    const int particle = sweep->sequence->slotParticle[leaf * TREE_WIDTH + k];
    for (int i = 0; i < candidates.count; i += PAIRS_AT_ONCE) {
      if (!hasRoom(sink)) {
        return false;
      }
      const int end = candidates.count - i < PAIRS_AT_ONCE ? candidates.count : i + PAIRS_AT_ONCE;
      int* lower = sink->lower + sink->count;
      int* higher = sink->higher + sink->count;
      size_t count = 0;
      fetchAhead(lower);
      fetchAhead(higher);
      for (int j = i; j < end; j += TREE_WIDTH) {
        count += closeRanks16(sweep->ranks, candidates.pairs[j + k], loadIds(candidates.particle + j), higher + count);
      }
      /* Enough at a time that one turn mostly suffices: processors would mispredict more. */
      for (size_t n = 0; n < count; n += LOWER_AT_ONCE) {
        for (size_t j = n; j < n + LOWER_AT_ONCE; j++) {
          lower[j] = particle;
        }
      }
      sink->count += count;
    }
  }
  return true;
}

/* Adds pairs of a leaf with the first `leafCount` leaves of the list. False ends the sweep. */
static bool addNeighbors(const Pass* pass, int leaf, const AxisBox* box, int leafCount) {
  const Candidates* candidates = &pass->sweep->candidates;
  bool continues = true;
  for (int first = 0; first < leafCount && continues; first += LEAVES_AT_ONCE) {
    gatherCandidates(pass, leaf, box, first, leafCount - first < LEAVES_AT_ONCE ? leafCount : first + LEAVES_AT_ONCE);
    if (!candidates->rises) {
      continues = addAsTheyCome(pass, leaf, false);
    } else {
      continues = pass->task->sink->ascending ? addRows(pass, leaf) : addAsTheyCome(pass, leaf, true);
    }
  }
  return continues;
}

/* Adds pairs of each leaf with itself and with later ones. */
static void addAllNeighbors(const Pass* pass) {
  const Sweep* sweep = pass->sweep;
  const Tree* layout = sweep->layout;
  if (treeTop(layout) == 0) {
    const AxisBox everywhere = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}, INFINITY};
    sweep->candidates.leaves[0] = 0;
    addNeighbors(pass, 0, &everywhere, 1);
    return;
  }
  for (int node = layout->levelBegin[1]; node < layout->levelBegin[1] + layout->levelSize[1]; node++) {
    const int nodeCount = listNodes(pass, node);
    int members;
    const int first = treeChildren(layout, 1, node, &members);
    for (int k = 0; k < members; k++) {
      const AxisBox box = memberOf(snapshotBoxes(&sweep->snapshot, layout, node), k);
      if (!addNeighbors(pass, first + k, &box, listNear(pass, node, k, nodeCount))) {
        return;
      }
    }
  }
}

void CT_WIDE(sweepNeighbors)(Sweep* sweep, SweepTask* task) {
  const Pass pass = startPass(sweep, task);
  addAllNeighbors(&pass);
}

void CT_WIDE(neighborDistances)(const double* position, double cutoff, size_t count, const int* lower,
                                const int* higher, double* distances) {
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
