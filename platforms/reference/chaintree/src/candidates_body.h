/* Neighbours of the slots of a leaf, compiled once for each instruction set by the file that includes this. */
#include <limits.h>
#include <string.h>

#include "near_body.h"

/* ---- The candidates of a leaf ---- */

/* Adds to `nodes` those of level 1 below an item of a higher level that come near one of them and do not lie before
 * it; returns how many there are then. */
static int listNodes(const Pass* pass, int level, int item, int node, int count) {
  const Tree* layout = pass->sweep->layout;
  const Snapshot* snapshot = &pass->sweep->snapshot;
  int members;
  const int first = treeChildren(layout, level, item, &members);
  const int rank = node - layout->levelBegin[1];
  /* The item over the node in the level of the members. */
  const int over = layout->levelBegin[level - 1] + (rank >> TREE_WIDTH_BITS * (level - 2));
  const Extents* around = snapshotExtents(snapshot, layout, treeParent(layout, 1, node));
  unsigned near = membersNear(pass, snapshotExtents(snapshot, layout, item), around, rank % TREE_WIDTH, false);
  near &= over > first ? ~0u << (over - first) : ~0u;
  pass->task->volumeTests += members;
  for (; near != 0; near &= near - 1) {
    const int member = first + __builtin_ctz(near);
    if (level == 2) {
      pass->sweep->nodes[count++] = member;
    } else {
      count = listNodes(pass, level - 1, member, node, count);
    }
  }
  return count;
}

/* Makes a list of the leaves that come near a leaf, which is member k of a node, and lie behind it; the first
 * `nodeCount` of `nodes` hold those that do. Returns how many. */
static int listNear(const Pass* pass, int node, int k, int nodeCount) {
  const Sweep* sweep = pass->sweep;
  const Tree* layout = sweep->layout;
  const Extents* around = snapshotExtents(&sweep->snapshot, layout, node);
  int* leaves = sweep->candidates.leaves;
  int count = 0;
  int members;
  for (int n = 0; n < nodeCount; n++) {
    const int other = sweep->nodes[n];
    const int first = treeChildren(layout, 1, other, &members);
    unsigned near = membersNear(pass, snapshotExtents(&sweep->snapshot, layout, other), around, k, false);
    near &= other == node ? ~1u << k : ~0u;
    count += indices16(near, first, leaves + count);
  }
  pass->task->volumeTests += nodeCount * TREE_WIDTH;
  return count;
}

/* Adds the octets of a leaf to the candidates of another; `rows` are the slots of that which may come near each of
 * them. */
static inline int addCandidates(const Pass* pass, const Slots* slots, int leaf, int count, const uint16_t* rows) {
  const Sweep* sweep = pass->sweep;
  const Candidates* candidates = &sweep->candidates;
  const Extent* boxes = &sweep->snapshot.octet[leaf * OCTETS];
  for (int c = 0; c < OCTETS; c++) {
    const unsigned near = slotsNear(pass, slots, &boxes[c], false) & rows[c];
    candidates->slot[count] = leaf * TREE_WIDTH + c * OCTET_WIDTH;
    candidates->near[count] = (uint16_t)near;
    count += near != 0;
  }
  return count;
}

/* Of pairs of a leaf with an octet, marks those that do not count: excluded ones, and within the leaf all but one way
 * round. */
static void restrictPairs(Candidates* candidates, int i, const uint16_t* excluded, bool isOwn) {
  CandidateWord* word = &candidates->word[i / CANDIDATE_WORD];
  for (int k = 0; k < TREE_WIDTH; k++) {
    const unsigned earlier = isOwn ? (2u << k) - 1 : 0;
    word->allowed[k][i % CANDIDATE_WORD] = (uint8_t)(~(excluded[k] | earlier) >> candidates->slot[i] % TREE_WIDTH);
  }
}

static void restrictCandidates(const Pass* pass, int leaf) {
  static const uint16_t nothing[TREE_WIDTH] = {0};
  const Exclusions* exclusions = pass->sweep->exclusions;
  Candidates* candidates = &pass->sweep->candidates;
  for (int w = 0; w * CANDIDATE_WORD < candidates->count; w++) {
    memset(candidates->word[w].allowed, 0xff, sizeof candidates->word->allowed);
  }
  for (int i = 0; i < candidates->count && candidates->slot[i] / TREE_WIDTH == leaf; i++) {
    restrictPairs(candidates, i, nothing, true);
  }
  int i = 0;
  for (int p = exclusionsFrom(exclusions, leaf, leaf); p < exclusions->begin[leaf + 1]; p++) {
    const int partner = exclusions->partner[p];
    while (i < candidates->count && candidates->slot[i] / TREE_WIDTH < partner) {
      i++;
    }
    for (; i < candidates->count && candidates->slot[i] / TREE_WIDTH == partner; i++) {
      restrictPairs(candidates, i, exclusions->mask[p], partner == leaf);
    }
  }
}

/* Turns what each octet comes near into what comes near each slot. */
static void transposeCandidates(Candidates* candidates) {
  memset(candidates->near + candidates->count, 0, TREE_WIDTH * sizeof *candidates->near);
  for (int first = 0; first < candidates->count; first += CANDIDATE_WORD) {
    uint64_t* near = candidates->word[first / CANDIDATE_WORD].near;
    memset(near, 0, sizeof candidates->word->near);
    for (int i = first; i < first + CANDIDATE_WORD && i < candidates->count; i += TREE_WIDTH) {
      uint16_t columns[TREE_WIDTH];
      transposeBits(candidates->near + i, columns);
      for (int k = 0; k < TREE_WIDTH; k++) {
        near[k] |= (uint64_t)columns[k] << (i - first);
      }
    }
  }
}

/* Gathers the candidates of a leaf from the leaves that come near it. */
static void gatherCandidates(const Pass* pass, int leaf, int leafCount) {
  /* Of the leaf itself, slots before the last of each octet. */
  static const uint16_t earlier[OCTETS] = {0x7f, 0x7fff};
  static const uint16_t all[OCTETS] = {0xffff, 0xffff};
  const Sweep* sweep = pass->sweep;
  Candidates* candidates = &pass->sweep->candidates;
  const Slots slots = slotsOf(&sweep->snapshot.leaf[leaf]);
  const int own = addCandidates(pass, &slots, leaf, 0, earlier);
  int count = own;
  for (int i = 0; i < leafCount; i++) {
    count = addCandidates(pass, &slots, candidates->leaves[i], count, all);
  }
  pass->task->volumeTests += (leafCount + 1) * OCTETS * TREE_WIDTH;
  candidates->count = count;
  int lowest = INT_MAX;
  for (int i = 0; i < count; i++) {
    const unsigned slot = (unsigned)candidates->slot[i];
    const int low = sweep->lowest[slot / OCTET_WIDTH];
    lowest = i >= own && low < lowest ? low : lowest;
    candidates->x[i] = sweep->snapshot.leaf[slot / TREE_WIDTH].x + slot % TREE_WIDTH;
    candidates->particle[i] = sweep->sequence->slotParticle + slot;
  }
  candidates->rises = sweep->highest[leaf] < lowest;
  restrictCandidates(pass, leaf);
  transposeCandidates(candidates);
}

/* ---- A slot and its candidates ---- */

/* A slot of a leaf, and one word of its candidates. */
typedef struct Row {
  Float8 x; /* of the slot, in all lanes */
  Float8 y;
  Float8 z;
  const uint8_t* allowed;
  const float* const* octets;
  const int* const* particles;
  int particle;
} Row;

CT_INLINE Row rowOfSlot(const Pass* pass, int leaf, int k, int w) {
  const Candidates* candidates = &pass->sweep->candidates;
  const Block* block = &pass->sweep->snapshot.leaf[leaf];
  return (Row){all8(block->x[k]),
               all8(block->y[k]),
               all8(block->z[k]),
               candidates->word[w].allowed[k],
               candidates->x + w * CANDIDATE_WORD,
               candidates->particle + w * CANDIDATE_WORD,
               pass->sweep->sequence->slotParticle[leaf * TREE_WIDTH + k]};
}

CT_INLINE Float8 squaredFromOctet(const Row* row, unsigned i) {
  const float* x = row->octets[i];
  return squared8(sub8(row->x, load8(x)), sub8(row->y, load8(x + TREE_WIDTH)), sub8(row->z, load8(x + 2 * TREE_WIDTH)));
}

/* Adds the neighbours of a slot; those of which float cannot tell by their distance in double. */
static __attribute__((noinline)) void addDoubtful(const Pass* pass, int leaf, int k, int w) {
  const SweepTask* task = pass->task;
  const Candidates* candidates = &pass->sweep->candidates;
  PairSink* sink = task->sink;
  const Row row = rowOfSlot(pass, leaf, k, w);
  const int slot = leaf * TREE_WIDTH + k;
  for (uint64_t left = candidates->word[w].near[k]; left != 0; left &= left - 1) {
    const unsigned i = (unsigned)__builtin_ctzll(left);
    const Float8 squared = squaredFromOctet(&row, i);
    unsigned near = greater8(all8(pass->nearSquared), squared) & row.allowed[i];
    unsigned doubtful = near & ~greater8(all8(pass->sureSquared), squared);
    for (; doubtful != 0; doubtful &= doubtful - 1) {
      const int other = candidates->slot[w * CANDIDATE_WORD + (int)i] + __builtin_ctz(doubtful);
      if (!task->isNear(task->context, slot, other, squaredApart(pass, slot, other))) {
        near &= ~(1u << __builtin_ctz(doubtful));
      }
    }
    sink->count += pairs8(pass->sweep->ranks, near, row.particle, row.particles[i], sink->lower + sink->count,
                          sink->higher + sink->count);
  }
}

/* Has fetched what will be written soon: long lists are seldom in the caches. Past their end that does no harm. */
CT_INLINE void fetchAhead(const int* list) {
  for (int i = 256; i < 256 + 64; i += 16) {
    __builtin_prefetch(list + i, 1);
  }
}

/* Adds the neighbours of the slots of a leaf whose candidates have been gathered; `rises` is theirs. False ends
 * the sweep. */
CT_INLINE bool addNeighbors(const Pass* pass, int leaf, bool rises) {
  const Candidates candidates = pass->sweep->candidates;
  const Ranks* ranks = pass->sweep->ranks;
  PairSink* sink = pass->task->sink;
  for (int k = 0; k < TREE_WIDTH; k++) {
    for (int w = 0; w * CANDIDATE_WORD < candidates.count; w++) {
      uint64_t left = candidates.word[w].near[k];
      if (left == 0) {
        continue;
      }
      if (sink->capacity - sink->count < PAIRS_AT_ONCE && !sink->makeRoom(sink)) {
        return false;
      }
      pass->task->particleTests += __builtin_popcountll(left) * OCTET_WIDTH;
      const Row row = rowOfSlot(pass, leaf, k, w);
      int* lower = sink->lower + sink->count;
      int* higher = sink->higher + sink->count;
      fetchAhead(lower);
      fetchAhead(higher);
      Under under = underLimits8(pass->nearSquared, pass->sureSquared);
      size_t count = 0;
      for (; left != 0; left &= left - 1) {
        const unsigned i = (unsigned)__builtin_ctzll(left);
        const unsigned near = under8(&under, squaredFromOctet(&row, i)) & row.allowed[i];
        count += rises ? closeRanks8(ranks, near, row.particles[i], higher + count)
                       : pairs8(ranks, near, row.particle, row.particles[i], lower + count, higher + count);
      }
      if (someBetween8(&under)) {
        addDoubtful(pass, leaf, k, w);
        continue;
      }
      sink->count += count;
      /* So many at a time that once is mostly enough: how many there are is hard to foresee. */
      for (size_t n = 0; n < count && rises; n += LOWER_AT_ONCE) {
        for (size_t j = n; j < n + LOWER_AT_ONCE; j++) {
          lower[j] = row.particle;
        }
      }
    }
  }
  return true;
}

static bool addNeighborsOfLeaf(const Pass* pass, int leaf) {
  return pass->sweep->candidates.rises ? addNeighbors(pass, leaf, true) : addNeighbors(pass, leaf, false);
}

/* Leaf after leaf, each with itself and those behind it: rows of pairs that ascend if particles and slots do. */
static void addAllNeighbors(const Pass* pass) {
  const Sweep* sweep = pass->sweep;
  const Tree* layout = sweep->layout;
  const int top = treeTop(layout);
  if (top == 0) {
    gatherCandidates(pass, 0, 0);
    addNeighborsOfLeaf(pass, 0);
    return;
  }
  for (int node = layout->levelBegin[1]; node < layout->levelBegin[1] + layout->levelSize[1]; node++) {
    int nodeCount = 1;
    sweep->nodes[0] = node;
    if (top > 1) {
      nodeCount = listNodes(pass, top, treeRoot(layout), node, 0);
    }
    int members;
    const int first = treeChildren(layout, 1, node, &members);
    for (int k = 0; k < members; k++) {
      gatherCandidates(pass, first + k, listNear(pass, node, k, nodeCount));
      if (!addNeighborsOfLeaf(pass, first + k)) {
        return;
      }
    }
  }
}
