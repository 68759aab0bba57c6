/* The members of nodes in the world and in a view. */
#ifndef CT_VIEW_H_
#define CT_VIEW_H_

#include "../descent.h"
#include "world.h"

/* Moves the members of a node into the view. */
Block* CT_WIDE(moveNode)(Traversal* t, int node);

/* Members of a placed node whose entry another node has taken. */
Block* CT_WIDE(viewAgain)(Traversal* t, int node);

/* Places a mixed node in the view; mixed nodes below it must be placed. `piece` holds its first slot. */
void CT_WIDE(placeMixedNode)(Traversal* t, int level, int node, int piece);

/* Places all mixed nodes of a view of many pieces. */
void CT_WIDE(placeMixedNodes)(Traversal* t);

/* Starts a descent of a new view: takes its motions, and bounds how large the scene is in it. */
void CT_WIDE(startView)(Traversal* t, const View* view);

/* The same for a search for pairs, whose candidates go to `function`. */
Visit CT_WIDE(startVisit)(Traversal* t, const View* view, CandidateFunction* function, void* context);

static inline bool moves(const View* view, int body) {
  return body > 0 && view->motions != NULL;
}

/* True if a body does not turn: then it keeps its distances to its own images. */
static inline bool keepsDirection(const View* view, int body) {
  return body == 0 || view->trialMotions == NULL || isTranslation(&view->trialMotions[body]);
}

/* The piece that holds a slot. */
static inline int pieceOf(const View* view, int slot) {
  int piece = view->pieceCount - 1;
  while (view->pieces[piece].slotBegin > slot) {
    piece--;
  }
  return piece;
}

/* The body of a slot. */
static inline int bodyOfSlot(const View* view, int slot) {
  return view->pieces[pieceOf(view, slot)].body;
}

/* The body of a member of a node that is placed in the view, coded like Traversal.body. */
static inline int bodyOfMember(const Traversal* t, int node, int k) {
  const int code = t->body[node];
  return code < 0 ? mixedNodeOf(t, code)->body[k] : code;
}

/* Places the members of a node in the view, once a descent. Its parent must be placed. */
static inline void placeInView(Traversal* t, int level, int node) {
  if (t->placedIn[node] == t->descent) {
    return;
  }
  t->placedIn[node] = t->descent;
  updateWorld(t->world, level, node);
  t->inView[node] = moves(t->view, t->body[node]) ? CT_WIDE(moveNode)(t, node) : worldOf(t->world, node);
}

/* The box around all members along the world's axes; low above high if there are none. */
static inline void boundsOfBlock(const Block* block, double low[3], double high[3]) {
  float least[8];
  boxOfBlock(block, least);
  for (int d = 0; d < 3; d++) {
    low[d] = (double)least[d];
    high[d] = -(double)least[3 + d];
  }
}

/* The margin of tests in float if one side is shifted. */
static inline double imageMargin(const Traversal* t, const double shift[3]) {
  return floatMargin(t->coordinateBound + fabs(t->view->reach) + sqrt(dot(shift, shift)));
}

/* The reach by which images are chosen: no shift is longer than three times the bound of coordinates and the reach. */
static inline double imageReach(const Traversal* t) {
  return t->view->reach + floatMargin(4 * (t->coordinateBound + fabs(t->view->reach)));
}

static inline Sphere shifted(Sphere sphere, const float shift[3], float sign) {
  return (Sphere){sphere.x + sign * shift[0], sphere.y + sign * shift[1], sphere.z + sign * shift[2], sphere.r};
}

/* No coordinate or radius of the state is larger. */
static inline double sizeOfState(const Tree* tree) {
  const Bound* bound = &tree->bound[treeRoot(tree)];
  const double centre[3] = {bound->x, bound->y, bound->z};
  return bound->r < 0 ? 0 : sqrt(dot(centre, centre)) + (double)bound->r;
}

/* Moves a sphere of this body from the world into the view. */
static inline Sphere sphereInView(const Traversal* t, Sphere sphere, int body) {
  return moves(t->view, body) ? movedSphere(sphere, t->motions[body]) : sphere;
}

/* Members of a placed node in the view. */
static inline const Block* blockOf(Traversal* t, int node) {
  if (t->inView[node] == NULL) {
    t->inView[node] = CT_WIDE(viewAgain)(t, node);
  }
  return t->inView[node];
}

/* Members of two placed nodes. The second may take the entry of the first, so the first is fetched again. */
static inline void blocksOf(Traversal* t, int a, int b, const Block* blocks[2]) {
  blockOf(t, a);
  blocks[1] = blockOf(t, b);
  blocks[0] = blockOf(t, a);
}

/* The members of a node that are of this body, as bits; none, if it is the code of a mixed node. */
static inline unsigned ofBody(const Traversal* t, int node, int body) {
  const int code = t->body[node];
  if (code < 0) {
    return body < 0 ? 0 : equal16(mixedNodeOf(t, code)->body, body);
  }
  return code == body ? 0xffff : 0;
}

#endif /* CT_VIEW_H_ */
