/* The members of nodes in the world and in a view. */
#ifndef CT_VIEW_H_
#define CT_VIEW_H_

#include <string.h>

#include "../descent.h"
#include "set.h"

/* Recomputes what has changed of a node's frame and members in the world. Its parent's must be up to date. */
void CT_WIDE(recomputeWorld)(Traversal* t, int level, int node);

/* Moves the members of a node into the view. */
Block* CT_WIDE(moveNode)(Traversal* t, int node);

/* The members of an expanded node whose entry another node has taken. */
Block* CT_WIDE(viewAgain)(Traversal* t, int node);

/* Expands a node that straddles pieces; such nodes below it must be expanded. `piece` holds its first slot. */
void CT_WIDE(expandStraddler)(Traversal* t, int level, int node, int piece);

/* Begins a descent with a new view: takes its motions, and bounds how large the scene is in it. */
void CT_WIDE(startView)(Traversal* t, const View* view);

/* The same for a search for pairs, whose candidates go to `function`. */
Visit CT_WIDE(startVisit)(Traversal* t, const View* view, CandidateFunction* function, void* context);

static inline bool moves(const View* view, int motion) {
  return motion > 0 && view->motions != NULL;
}

/* The piece that holds a slot. */
static inline int pieceOf(const View* view, int slot) {
  int piece = view->pieceCount - 1;
  while (view->pieces[piece].slotBegin > slot) {
    piece--;
  }
  return piece;
}

/* The motion of a slot. */
static inline int motionOfSlot(const View* view, int slot) {
  return view->pieces[pieceOf(view, slot)].body;
}

/* The motion of a member of an expanded node, coded like Traversal.motion. */
static inline int motionOfMember(const Traversal* t, int node, int k) {
  const int code = t->motion[node];
  return code < 0 ? straddlerOf(t, code)->motion[k] : code;
}

/* Two at a time, as frames are stored: a processor waits for what it loads at once and has stored in parts. */
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

/* True if the node's frame in the world is the one that is kept. */
static inline bool hasFrame(const Traversal* t, int level, int node) {
  const Tree* tree = t->tree;
  const int64_t since = t->worldTime[node];
  if (since == NEVER) {
    return false;
  }
  if (level < treeTop(tree) && t->frameTime[treeParent(tree, level, node) - tree->levelBegin[1]] > since) {
    return false; /* mostly: the parent has moved since, or something in it */
  }
  int end;
  treeSlots(tree, level, node, &end);
  return treeLeavesStay(tree, since, (end + TREE_WIDTH - 1) / TREE_WIDTH);
}

/* Marks a node's world coordinates, which are still right, as of now: the next look at them is quicker. */
static inline void confirmWorld(Traversal* t, int node) {
  t->worldTime[node] = t->tree->time;
}

/* Brings the world coordinates of a node's members up to date with the state. Its parent's must be so. */
static inline void updateWorld(Traversal* t, int level, int node) {
  if (!traversalHasWorld(t, node)) {
    CT_WIDE(recomputeWorld)(t, level, node);
  }
}

CT_NOINLINE void updateLostLeaf(Traversal* t, int leaf) {
  updateWorld(t, 0, leaf);
}

/* The members of a node in the world, which were brought up to date before. A leaf may have lost its entry since then;
 * its parent has not. */
CT_INLINE Block* worldOf(Traversal* t, int node) {
  if (t->entryOf[node] == CT_NULL) {
    updateLostLeaf(t, node);
  }
  return &t->world[t->entryOf[node]];
}

/* Brings the members of a node into the view, once a descent. Its parent must be expanded. */
static inline void expand(Traversal* t, int level, int node) {
  if (t->nodeStamp[node] == t->stamp) {
    return;
  }
  t->nodeStamp[node] = t->stamp;
  updateWorld(t, level, node);
  t->inView[node] = moves(t->view, t->motion[node]) ? CT_WIDE(moveNode)(t, node) : worldOf(t, node);
}

/* No coordinate or radius of the state is larger. */
static inline double sizeOfState(const Tree* tree) {
  const Bound* bound = &tree->bound[treeRoot(tree)];
  const double centre[3] = {bound->x, bound->y, bound->z};
  return bound->r < 0 ? 0 : sqrt(dot(centre, centre)) + (double)bound->r;
}

/* Moves a sphere of this motion from the world into the view. */
static inline Sphere sphereInView(const Traversal* t, Sphere sphere, int motion) {
  return moves(t->view, motion) ? movedSphere(sphere, t->motions[motion]) : sphere;
}

/* The members of an expanded node in the view. */
static inline const Block* blockOf(Traversal* t, int node) {
  if (t->inView[node] == NULL) {
    t->inView[node] = CT_WIDE(viewAgain)(t, node);
  }
  return t->inView[node];
}

/* The members of two expanded nodes in the view. The second may take the entry of the first: so the first is asked for
 * again. */
static inline void blocksOf(Traversal* t, int a, int b, const Block* blocks[2]) {
  blockOf(t, a);
  blocks[1] = blockOf(t, b);
  blocks[0] = blockOf(t, a);
}

/* The members of a node that have this motion, as bits; none, if it is the code of a straddler. */
static inline unsigned ofBody(const Traversal* t, int node, int motion) {
  const int code = t->motion[node];
  if (code < 0) {
    return motion < 0 ? 0 : equal16(straddlerOf(t, code)->motion, motion);
  }
  return code == motion ? 0xffff : 0;
}

#endif /* CT_VIEW_H_ */
