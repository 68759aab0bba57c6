#include "world.h"

/* Computes the world coordinates of a leaf's members from its frame. */
static void worldLeaf(World* w, int leaf) {
  const Frame* f = &w->frame[w->entryOf[leaf]];
  const Leaf* own = &w->tree->leaf[leaf];
  Block* world = &w->members[w->entryOf[leaf]];
  store16(world->x, rounded16(own->x, own->y, own->z, f->m[0]));
  store16(world->y, rounded16(own->x, own->y, own->z, f->m[1]));
  store16(world->z, rounded16(own->x, own->y, own->z, f->m[2]));
  store16(world->r, load16(own->r));
}

/* The same for an inner node. */
static void worldInnerNode(World* w, int node) {
  const Members* own = treeMembers(w->tree, node);
  Block* world = &w->members[w->entryOf[node]];
  float motion[12];
  floatMotion(&w->frame[w->entryOf[node]], motion);
  moveAll(&own->block, own->block.r, motion, world);
}

/* Gives a leaf the entry of the leaf that has had one longest. */
static void takeEntry(World* w, int leaf) {
  const int entry = w->nextEntry;
  const int other = w->leafOfEntry[entry];
  if (other != CT_NULL) {
    w->builtFrom[other] = NO_REVISION;
    w->entryOf[other] = CT_NULL;
    w->inView[other] = NULL; /* its coordinates are overwritten */
  }
  w->leafOfEntry[entry] = leaf;
  w->entryOf[leaf] = entry;
  w->nextEntry = entry + 1 < w->leafEntryCount ? entry + 1 : 0;
}

/* Recomputes a node's frame in the world from that of its parent. */
static void recomputeFrame(World* w, int level, int node) {
  const Tree* tree = w->tree;
  if (w->entryOf[node] == CT_NULL) {
    takeEntry(w, node);
  }
  Frame* frame = &w->frame[w->entryOf[node]];
  if (level == treeTop(tree)) {
    *frame = tree->pose[node];
    return;
  }
  const int parent = treeParent(tree, level, node);
  *frame = transformCompose(&w->frame[w->entryOf[parent]], &tree->pose[node]);
}

/* Recomputes the changed parts of a node's frame and members in the world. */
void CT_WIDE(recomputeWorld)(World* w, int level, int node) {
  const Tree* tree = w->tree;
  if (nodeMovedSince(tree, level, node, w->builtFrom[node])) {
    recomputeFrame(w, level, node);
  } else if (tree->contentRevision[node] <= w->builtFrom[node]) {
    confirmWorld(w, node);
    return;
  }
  w->builtFrom[node] = tree->changes.now;
  if (level == 0) {
    worldLeaf(w, node);
  } else {
    worldInnerNode(w, node);
  }
}

/* Updates a node and the nodes over it. */
void CT_WIDE(updateWorldAt)(World* w, int level, int node) {
  const Tree* tree = w->tree;
  const int index = node - tree->levelBegin[level];
  for (int above = treeTop(tree); above >= level; above--) {
    updateWorld(w, above, tree->levelBegin[above] + (index >> TREE_WIDTH_BITS * (above - level)));
  }
}
