#include "snapshot.h"

#include <string.h>

static void clearExtents(Extents* extents) {
  for (int k = 0; k < TREE_WIDTH; k++) {
    for (int d = 0; d < 3; d++) {
      extents->low[d][k] = INFINITY;
      extents->high[d][k] = -INFINITY;
    }
    extents->r[k] = -INFINITY;
  }
}

bool ctSnapshotBuild(Snapshot* snapshot, Arena* arena, const Sequence* sequence, const Tree* layout) {
  const size_t leaves = (size_t)layout->levelBegin[1];
  const size_t nodes = (size_t)layout->itemCount - leaves;
  snapshot->leaf = ctArenaAllocate(arena, leaves, sizeof(Block));
  snapshot->extents = ctArenaAllocate(arena, nodes, sizeof(Extents));
  if (arena->failed) {
    return false;
  }
  for (int slot = 0; slot < layout->levelBegin[1] * TREE_WIDTH; slot++) {
    const bool empty = slot >= layout->slotCount || sequence->slotParticle[slot] == CT_NULL;
    snapshot->leaf[slot / TREE_WIDTH].r[slot % TREE_WIDTH] = empty ? -INFINITY : (float)slotRadius(sequence, slot);
  }
  for (size_t node = 0; node < nodes; node++) {
    clearExtents(&snapshot->extents[node]);
  }
  return true;
}

bool ctSnapshotReserve(Snapshot* snapshot, Arena* arena, const Sequence* sequence) {
  if (snapshot->moved == NULL) {
    snapshot->moved = ctArenaAllocate(arena, 3 * (size_t)sequence->particleCount, sizeof(double));
    arena->failed = false;
  }
  return snapshot->moved != NULL;
}

void ctSnapshotTakeReference(Snapshot* snapshot, const Sequence* sequence) {
  snapshot->position = sequence->reference;
  memcpy(snapshot->origin, sequence->worldOrigin, sizeof snapshot->origin);
}

static void takeLeaf(Snapshot* snapshot, const Sequence* sequence, const Tree* tree, int leaf, const Frame* frame) {
  int end;
  for (int slot = treeSlots(tree, 0, leaf, &end); slot < end; slot++) {
    const int particle = sequence->slotParticle[slot];
    if (particle != CT_NULL) {
      double local[3];
      treeLocal(tree, slot, local);
      transformPoint(frame, local, snapshot->moved + 3 * (size_t)particle);
    }
  }
}

static void takeItem(Snapshot* snapshot, const Sequence* sequence, const Tree* tree, int level, int item,
                     const Frame* frame) {
  if (level == 0) {
    takeLeaf(snapshot, sequence, tree, item, frame);
    return;
  }
  int count;
  const int first = treeChildren(tree, level, item, &count);
  for (int child = first; child < first + count; child++) {
    const Frame inWorld = transformCompose(frame, &tree->pose[child]);
    takeItem(snapshot, sequence, tree, level - 1, child, &inWorld);
  }
}

void ctSnapshotTakeTree(Snapshot* snapshot, const Sequence* sequence, const Tree* tree) {
  takeItem(snapshot, sequence, tree, treeTop(tree), treeRoot(tree), &tree->pose[treeRoot(tree)]);
  snapshot->position = snapshot->moved;
  memset(snapshot->origin, 0, sizeof snapshot->origin);
}
