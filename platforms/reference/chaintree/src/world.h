/* Where the nodes of the tree are in the world: their frames, and their members in float. Coordinates are from the
 * sequence's worldOrigin. They are computed when they are first needed, and again once the tree has moved. Leaves share
 * entries: the leaf that has had one longest loses its own to the next. */
#ifndef CT_WORLD_H_
#define CT_WORLD_H_

#include "tree.h"

typedef struct World {
  const Tree* tree;
  Revision* builtFrom; /* per node: frame and members are of this revision; NO_REVISION: it has none */
  int* entryOf;        /* per node: its entry in the two arrays below; CT_NULL: another leaf has taken that */

  /* Entries: one for each inner node, and this many for the leaves updated last. */
  int leafEntryCount;
  int nextEntry;    /* of a leaf, to be replaced next */
  int* leafOfEntry; /* per entry of a leaf; CT_NULL: it is free */
  Frame* frame;
  Block* members;
  Block** inView; /* Traversal.inView: NULL for a leaf that loses its entry */
} World;

bool ctWorldBuild(World* world, Arena* arena, const Tree* tree);

/* The frame of a leaf, which gets an entry. */
const Frame* ctWorldLeafFrame(World* world, int leaf);

/* The same without an entry, for callers that read many leaves. */
Frame ctWorldReadFrame(World* world, int leaf);

/* True if frame and members of a node are known to be right. */
static inline bool hasWorld(const World* w, int node) {
  const Revision since = w->builtFrom[node];
  return w->tree->contentRevision[node] <= since && !movedSince(&w->tree->changes, since);
}

#endif /* CT_WORLD_H_ */
