/* The sweep for clashes. */
#include "near.h"

/* ---- Filters ---- */

/* The members (bits) whose boxes are within reach of the box of a node below the top. */
static unsigned membersNearNode(const Pass* pass, int level, const SnapshotBoxes* members, int node) {
  const Tree* layout = pass->sweep->layout;
  const SnapshotBoxes* others = snapshotBoxes(&pass->sweep->snapshot, layout, treeParent(layout, level, node));
  return membersNear(pass, members, others, memberIndex(node - layout->levelBegin[level]), true);
}

/* The slots (bits) of leaf a that are within reach of box k of others. */
static unsigned slotsNearMember(const Pass* pass, int a, const SnapshotBoxes* others, int k) {
  const Slots slots = slotsOf(&pass->sweep->snapshot.leaf[a]);
  const AxisBox coordinateBound = memberOf(others, k);
  return slotsNear(pass, &slots, &coordinateBound, true);
}

/* ---- Clashes of two leaves ---- */

typedef struct LeafPair {
  int a;
  int b;
  unsigned slots;           /* bits: slots of a that are near b */
  const uint16_t* excluded; /* per slot of a, bits: slots of b that make no pair with it */
} LeafPair;

/* Per slot of a, bits: the slots of b that may clash with it. */
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

/* ---- Sweeps ---- */

/* Sweeps a leaf against leaves firstB + k for each bit k; their boxes are aroundB. False ends the sweep. */
static bool sweepLeaves(const Pass* pass, int a, int firstB, const SnapshotBoxes* aroundB, unsigned near) {
  static const uint16_t nothing[TREE_WIDTH] = {0};
  uint16_t ownExcluded[TREE_WIDTH];
  const Exclusions* exclusions = pass->sweep->exclusions;
  const int sizeA = sizeOfLeaf(pass->sweep->layout, a);
  int partner = exclusionsFrom(exclusions, a, firstB);
  bool continues = true;
  for (; continues && near != 0; near &= near - 1) {
    const int l = __builtin_ctz(near);
    LeafPair pair = {a, firstB + l, (1u << sizeA) - 1, nothing};
    if (exclusionReaches(exclusions, a, pair.b, &partner)) {
      pair.excluded = exclusions->mask[partner];
    }
    if (pair.b == a) {
      /* Each pair once, and no slot with itself. */
      for (int k = 0; k < TREE_WIDTH; k++) {
        ownExcluded[k] = (uint16_t)(pair.excluded[k] | ((2u << k) - 1));
      }
      pair.excluded = ownExcluded;
      pass->task->particleTests += sizeA * (sizeA - 1) / 2;
    } else {
      pair.slots = slotsNearMember(pass, a, aroundB, l);
      pass->task->volumeTests += sizeA;
      pass->task->particleTests += __builtin_popcount(pair.slots) * sizeOfLeaf(pass->sweep->layout, pair.b);
    }
    if (pair.slots != 0) {
      continues = findClashes(pass, &pair);
    }
  }
  return continues;
}

/* The members (bits) of node a that are near node b. Where the boxes of two nodes overlap, most of their members may
 * still be far from each other's boxes (section 4). */
static unsigned rowsOf(const Pass* pass, const SweepVisit* visit, int countA, int countB) {
  const Snapshot* snapshot = &pass->sweep->snapshot;
  const Tree* layout = pass->sweep->layout;
  if (visit->a == visit->b) {
    return (1u << countA) - 1;
  }
  pass->task->volumeTests += countA;
  const SnapshotBoxes* aroundA = snapshotBoxes(snapshot, layout, visit->a);
  const unsigned rows = membersNearNode(pass, visit->level, aroundA, visit->b);
  if (rows == 0) {
    return 0;
  }
  pass->task->volumeTests += countB;
  const SnapshotBoxes* aroundB = snapshotBoxes(snapshot, layout, visit->b);
  return membersNearNode(pass, visit->level, aroundB, visit->a) == 0 ? 0 : rows;
}

static void sweepPairs(const Pass* pass) {
  const Sweep* sweep = pass->sweep;
  const Tree* layout = sweep->layout;
  const int root = treeRoot(layout);
  if (treeTop(layout) == 0) {
    sweepLeaves(pass, root, root, NULL, 1);
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
    const SnapshotBoxes* aroundA = snapshotBoxes(&sweep->snapshot, layout, visit.a);
    const SnapshotBoxes* aroundB = snapshotBoxes(&sweep->snapshot, layout, visit.b);
    const unsigned rows = rowsOf(pass, &visit, countA, countB);
    for (int i = 0; i < countA; i++) {
      /* Descending, except leaves: the stack turns the order round, so leaves are swept in ascending order. */
      const int k = visit.level == 1 ? i : countA - 1 - i;
      if ((rows >> k & 1) == 0 || aroundA->r[k] < 0) {
        continue;
      }
      unsigned near = membersNear(pass, aroundB, aroundA, k, true);
      if (visit.a == visit.b) {
        near &= ~0u << k;
      }
      pass->task->volumeTests += visit.a == visit.b ? countB - k : countB;
      if (visit.level == 1) {
        if (!sweepLeaves(pass, firstA + k, firstB, aroundB, near)) {
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

void CT_WIDE(sweepClashes)(Sweep* sweep, SweepTask* task) {
  const Pass pass = startPass(sweep, task);
  sweepPairs(&pass);
}
