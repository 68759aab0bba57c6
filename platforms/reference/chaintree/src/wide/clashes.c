/* The sweep for clashes. */
#include "boxdescent.h"
#include "near.h"

/* ---- Filters ---- */

/* The members (bits) whose boxes are within reach of the box of a node below the top. */
CT_INLINE unsigned membersNearNode(const Pass* pass, int level, const SnapshotBoxes* members, int node) {
  const Tree* layout = pass->sweep->layout;
  const SnapshotBoxes* others = snapshotBoxes(&pass->sweep->snapshot, layout, treeParent(layout, level, node));
  return membersNear(pass, members, others, memberIndex(node - layout->levelBegin[level]), true);
}

/* The slots (bits) of leaf a that are within reach of box k of others. */
CT_INLINE unsigned slotsNearMember(const Pass* pass, int a, const SnapshotBoxes* others, int k) {
  const Slots slots = slotsOf(&pass->sweep->snapshot.leaf[a]);
  const AxisBox box = memberOf(others, k);
  return slotsNear(pass, &slots, &box, true);
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

CT_INLINE bool findClashes(const Pass* pass, const LeafPair* pair) {
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

/* Sweeps a leaf against leaves firstB + k for each bit k. False ends the sweep. */
static bool sweepLeaves(void* search, int a, int firstB, unsigned near) {
  static const uint16_t nothing[TREE_WIDTH] = {0};
  const Pass* pass = search;
  uint16_t ownExcluded[TREE_WIDTH];
  const Exclusions* exclusions = pass->sweep->exclusions;
  const SnapshotBoxes* aroundB = &pass->sweep->snapshot.boxes[coveringNode(firstB)]; /* level 1 comes first */
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
CT_VISITOR unsigned membersNearOther(void* search, int level, int a, int b) {
  const Pass* pass = search;
  const Tree* layout = pass->sweep->layout;
  const SnapshotBoxes* aroundA = snapshotBoxes(&pass->sweep->snapshot, layout, a);
  if (a == b) {
    return ~greater16(all16(0), load16(aroundA->r)) & 0xffff;
  }
  pass->task->volumeTests += treeMemberCount(layout, level, a);
  const unsigned rows = membersNearNode(pass, level, aroundA, b);
  if (rows == 0) {
    return 0;
  }
  pass->task->volumeTests += treeMemberCount(layout, level, b);
  const SnapshotBoxes* aroundB = snapshotBoxes(&pass->sweep->snapshot, layout, b);
  return membersNearNode(pass, level, aroundB, a) == 0 ? 0 : rows;
}

CT_VISITOR unsigned membersNearMember(void* search, int level, int a, int k, int b) {
  const Pass* pass = search;
  const Tree* layout = pass->sweep->layout;
  const SnapshotBoxes* aroundA = snapshotBoxes(&pass->sweep->snapshot, layout, a);
  const SnapshotBoxes* aroundB = snapshotBoxes(&pass->sweep->snapshot, layout, b);
  pass->task->volumeTests += treeMemberCount(layout, level, b) - (a == b ? k : 0);
  return membersNear(pass, aroundB, aroundA, k, true) & notBefore(a, k, b);
}

void CT_WIDE(sweepClashes)(Sweep* sweep, SweepTask* task) {
  Pass pass = startPass(sweep, task);
  const BoxVisitor visitor = {membersNearOther, membersNearMember, sweepLeaves, false};
  descendBoxes(&pass, sweep->layout, 1, visitor);
}
