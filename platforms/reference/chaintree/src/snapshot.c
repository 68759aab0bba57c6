#include "snapshot.h"

#include <string.h>

bool ctSnapshotBuild(Snapshot* snapshot, Arena* arena, const Sequence* sequence, const Tree* layout) {
  const size_t leaves = (size_t)layout->levelBegin[1];
  const size_t inner = (size_t)layout->nodeCount - leaves;
  snapshot->leaf = ctArenaAllocate(arena, leaves, sizeof(Block));
  snapshot->boxes = ctArenaAllocate(arena, inner, sizeof(SnapshotBoxes));
  if (arena->failed) {
    return false;
  }
  for (int slot = 0; slot < layout->levelBegin[1] * TREE_WIDTH; slot++) {
    const bool isModelled = slot < layout->slotCount && slotIsModelled(sequence, slot);
    snapshot->leaf[coveringNode(slot)].r[memberIndex(slot)] =
        isModelled ? (float)slotRadius(sequence, slot) : -INFINITY;
  }
  for (size_t i = 0; i < inner; i++) {
    clearAxisBoxes(&snapshot->boxes[i].centres);
    for (int k = 0; k < TREE_WIDTH; k++) {
      snapshot->boxes[i].r[k] = -INFINITY;
    }
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

void ctSnapshotTakeTree(Snapshot* snapshot, const Sequence* sequence, World* world) {
  for (int leaf = 0; leaf < world->tree->levelSize[0]; leaf++) {
    const Frame frame = ctWorldReadFrame(world, leaf);
    takeLeaf(snapshot, sequence, world->tree, leaf, &frame);
  }
  snapshot->position = snapshot->moved;
  memset(snapshot->origin, 0, sizeof snapshot->origin);
}
