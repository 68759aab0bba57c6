#include "world.h"

#include "wide.h"

/* Most entries for leaves: with more of them, caches of the processor would miss more often than entries spare work. A
 * visit needs at least two. */
enum { MOST_LEAF_ENTRIES = 8192 };

bool ctWorldBuild(World* w, Arena* arena, const Tree* tree) {
  const size_t nodes = (size_t)tree->nodeCount;
  const int leaves = tree->levelBegin[1];
  const size_t inner = nodes - (size_t)leaves;
  w->tree = tree;
  w->leafEntryCount = leaves < MOST_LEAF_ENTRIES ? leaves : MOST_LEAF_ENTRIES;
  const size_t entries = (size_t)w->leafEntryCount + inner;
  w->builtFrom = ctArenaAllocate(arena, nodes, sizeof(Revision));
  w->entryOf = ctArenaAllocate(arena, nodes, sizeof(int));
  w->leafOfEntry = ctArenaAllocate(arena, (size_t)w->leafEntryCount, sizeof(int));
  w->frame = ctArenaAllocate(arena, entries, sizeof(Frame));
  w->members = ctArenaAllocate(arena, entries, sizeof(Block));
  if (arena->failed) {
    return false;
  }
  for (int entry = 0; entry < w->leafEntryCount; entry++) {
    w->leafOfEntry[entry] = CT_NULL;
  }
  for (int node = 0; node < tree->nodeCount; node++) {
    w->builtFrom[node] = NO_REVISION;
    w->entryOf[node] = node < leaves ? CT_NULL : w->leafEntryCount + node - leaves;
  }
  return true;
}

const Frame* ctWorldLeafFrame(World* w, int leaf) {
  if (!hasWorld(w, leaf)) {
    w->tree->wide->updateWorldAt(w, 0, leaf);
  }
  return &w->frame[w->entryOf[leaf]];
}

Frame ctWorldReadFrame(World* w, int leaf) {
  const Tree* tree = w->tree;
  if (treeTop(tree) == 0) {
    return tree->pose[leaf];
  }
  const int parent = treeParent(tree, 0, leaf);
  if (!hasWorld(w, parent)) {
    tree->wide->updateWorldAt(w, 1, parent);
  }
  return transformCompose(&w->frame[w->entryOf[parent]], &tree->pose[leaf]);
}
