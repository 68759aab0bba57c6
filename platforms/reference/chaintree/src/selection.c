#include "selection.h"

#include <stdlib.h>

#include "order.h"

/* ---- Marks ---- */

/* Marks the members of inner nodes below which a slot is marked. */
static void markAbove(const Tree* layout, uint16_t* mask) {
  for (int level = 0; level < treeTop(layout); level++) {
    for (int i = 0; i < layout->levelSize[level]; i++) {
      const int node = layout->levelBegin[level] + i;
      if (mask[node] != 0) {
        uint16_t* above = &mask[treeParent(layout, level, node)];
        *above = (uint16_t)(*above | 1u << memberIndex(i));
      }
    }
  }
}

static void markSlot(uint16_t* mask, int slot) {
  mask[coveringNode(slot)] = (uint16_t)(mask[coveringNode(slot)] | 1u << memberIndex(slot));
}

static int countMarks(const Tree* layout, const uint16_t* mask) {
  int count = 0;
  for (int leaf = 0; leaf < layout->levelSize[0]; leaf++) {
    count += __builtin_popcount(mask[leaf]);
  }
  return count;
}

/* False if there is no memory. */
static bool buildUnmodelled(ctSelection* selection, int count, const int* particles) {
  const Sequence* s = &selection->scene->sequence;
  int given = 0;
  for (int i = 0; i < count; i++) {
    given += modelledSlot(s, particles[i]) == CT_NULL;
  }
  if (given == 0) {
    return true;
  }
  selection->unmodelled = ctArenaAllocate(&selection->arena, (size_t)given, sizeof(int));
  if (selection->arena.failed) {
    return false;
  }
  int* unmodelled = selection->unmodelled;
  given = 0;
  for (int i = 0; i < count; i++) {
    if (modelledSlot(s, particles[i]) == CT_NULL) {
      unmodelled[given++] = particles[i];
    }
  }
  ctSortInts(unmodelled, given);
  for (int i = 0; i < given; i++) {
    if (i == 0 || unmodelled[i] != unmodelled[i - 1]) {
      unmodelled[selection->unmodelledCount++] = unmodelled[i];
    }
  }
  Tree* layout = &selection->unmodelledLayout;
  ctTreeLayOut(layout, selection->unmodelledCount);
  const size_t nodes = (size_t)layout->nodeCount;
  selection->unmodelledMask = ctArenaAllocate(&selection->arena, nodes, sizeof(uint16_t));
  selection->unmodelledBlock = ctArenaAllocate(&selection->arena, nodes, sizeof(Block));
  selection->unmodelledPoint =
      ctArenaAllocate(&selection->arena, (size_t)selection->unmodelledCount, sizeof(double[3]));
  if (selection->arena.failed) {
    return false;
  }
  for (int slot = 0; slot < selection->unmodelledCount; slot++) {
    markSlot(selection->unmodelledMask, slot);
  }
  markAbove(layout, selection->unmodelledMask);
  return true;
}

static bool build(ctSelection* selection, int count, const int* particles) {
  const Tree* layout = &selection->scene->ownTree;
  selection->mask = ctArenaAllocate(&selection->arena, (size_t)layout->nodeCount, sizeof(uint16_t));
  if (selection->arena.failed || !buildUnmodelled(selection, count, particles)) {
    return false;
  }
  for (int i = 0; i < count; i++) {
    const int slot = modelledSlot(&selection->scene->sequence, particles[i]);
    if (slot != CT_NULL) {
      markSlot(selection->mask, slot);
    }
  }
  markAbove(layout, selection->mask);
  selection->count = countMarks(layout, selection->mask) + selection->unmodelledCount;
  return true;
}

bool ctSelectionHolds(const ctSelection* selection, int particle) {
  const int slot = modelledSlot(&selection->scene->sequence, particle);
  if (slot != CT_NULL) {
    return (selection->mask[coveringNode(slot)] >> memberIndex(slot) & 1) != 0;
  }
  const int i = ascendingFrom(selection->unmodelled, 0, selection->unmodelledCount, particle);
  return i < selection->unmodelledCount && selection->unmodelled[i] == particle;
}

/* ---- The list of a scene ---- */

static void enlist(ctSelection* selection, ctSelection** list) {
  selection->next = *list;
  selection->listedAt = list;
  if (selection->next != NULL) {
    selection->next->listedAt = &selection->next;
  }
  *list = selection;
}

static void delist(ctSelection* selection) {
  if (selection->listedAt != NULL) {
    *selection->listedAt = selection->next;
    if (selection->next != NULL) {
      selection->next->listedAt = selection->listedAt;
    }
  }
  selection->listedAt = NULL;
}

void ctDisownSelections(ctChainTree* scene) {
  while (scene->selections != NULL) {
    ctSelection* selection = scene->selections;
    delist(selection);
    selection->scene = NULL;
  }
}

/* ---- Life ---- */

ctStatus ctSelect(ctChainTree* tree, int count, const int* particles, ctSelection** selection) {
  if (selection != NULL) {
    *selection = NULL;
  }
  CT_REQUIRE(tree, selection);
  const ctStatus status = ctCheckParticles(tree, count, particles);
  if (status != ctSuccess) {
    return status;
  }
  ctSelection* made = calloc(1, sizeof *made);
  if (made != NULL) {
    made->scene = tree;
    made->nearest[0] = CT_NULL;
    if (build(made, count, particles)) {
      enlist(made, &tree->selections);
      *selection = made;
      return ctSuccess;
    }
  }
  ctFreeSelection(made);
  return ctFailOutOfMemory(tree);
}

void ctFreeSelection(ctSelection* selection) {
  if (selection != NULL) {
    delist(selection);
    ctArenaFree(&selection->arena);
    free(selection);
  }
}
