/* Frames and members of nodes in the world. */
#ifndef CT_WIDEWORLD_H_
#define CT_WIDEWORLD_H_

#include <string.h>

#include "../volume.h"
#include "set.h"

/* Recomputes the changed parts of a node's frame and members in the world. Its parent's must be up to date. */
void CT_WIDE(recomputeWorld)(World* w, int level, int node);

/* Two at a time, as frames are stored: a processor waits for whole loads of what was stored in parts. */
static inline void floatMotion(const Frame* f, float motion[12]) {
  typedef double Doubles __attribute__((vector_size(16)));
  typedef float Floats __attribute__((vector_size(8)));
  for (int i = 0; i < 12; i += 2) {
    Doubles pair;
    memcpy(&pair, f->m[0] + i, sizeof pair);
    const Floats rounded = __builtin_convertvector(pair, Floats);
    memcpy(motion + i, &rounded, sizeof rounded);
  }
}

/* Marks world coordinates, which are still right, as of this revision: the next check is quicker. */
static inline void confirmWorld(World* w, int node) {
  w->builtFrom[node] = w->tree->changes.now;
}

/* Updates the world coordinates of a node's members to the state. Its parent's must be up to date. */
static inline void updateWorld(World* w, int level, int node) {
  if (!hasWorld(w, node)) {
    CT_WIDE(recomputeWorld)(w, level, node);
  }
}

CT_NOINLINE void updateLostLeaf(World* w, int leaf) {
  updateWorld(w, 0, leaf);
}

/* World coordinates that were brought up to date before. A leaf may have lost its entry since then; its parent has not.
 */
CT_INLINE Block* worldOf(World* w, int node) {
  if (w->entryOf[node] == CT_NULL) {
    updateLostLeaf(w, node);
  }
  return &w->members[w->entryOf[node]];
}

#endif /* CT_WIDEWORLD_H_ */
