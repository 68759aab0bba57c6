/* What a view makes of the nodes of a tree, compiled once for each instruction set by the file that includes this. */
#ifndef CT_VIEW_BODY_H_
#define CT_VIEW_BODY_H_

#include <string.h>

#include "descent.h"

static bool moves(const View* view, int motion) {
  return motion > 0 && view->motions != NULL;
}

/* The piece that holds a slot. */
static int pieceOf(const View* view, int slot) {
  int piece = view->pieceCount - 1;
  while (view->pieces[piece].slotBegin > slot) {
    piece--;
  }
  return piece;
}

/* Of which rigid body a slot is. */
static int motionOfSlot(const View* view, int slot) {
  return view->pieces[pieceOf(view, slot)].motion;
}

/* Of which rigid body a member of an expanded node is, coded like Traversal.motion. */
static int motionOfMember(const Traversal* t, int node, int k) {
  const int code = t->motion[node];
  return code < 0 ? straddlerOf(t, code)->motion[k] : code;
}

static void worldLeaf(Traversal* t, int leaf) {
  const Frame* f = &t->frame[t->entryOf[leaf]];
  const Leaf* own = &t->tree->leaf[leaf];
  Block* rest = &t->world[t->entryOf[leaf]];
  for (int k = 0; k < TREE_WIDTH; k++) {
    const double x = own->x[k];
    const double y = own->y[k];
    const double z = own->z[k];
    rest->x[k] = (float)(f->m[0][0] * x + f->m[0][1] * y + f->m[0][2] * z + f->m[0][3]);
    rest->y[k] = (float)(f->m[1][0] * x + f->m[1][1] * y + f->m[1][2] * z + f->m[1][3]);
    rest->z[k] = (float)(f->m[2][0] * x + f->m[2][1] * y + f->m[2][2] * z + f->m[2][3]);
  }
  if (t->worldHasSurfaces) {
    memcpy(rest->r, own->r, sizeof rest->r);
  } else {
    leafCentres(own, rest->r);
  }
}

static void floatMotion(const Frame* f, float motion[12]) {
  const double* m = f->m[0];
  for (int i = 0; i < 12; i++) {
    motion[i] = (float)m[i];
  }
}

static void worldInnerNode(Traversal* t, int node) {
  const Members* own = treeMembers(t->tree, node);
  Block* rest = &t->world[t->entryOf[node]];
  float motion[12];
  floatMotion(&t->frame[t->entryOf[node]], motion);
  moveBlock(&own->block, motion, 0xffff, rest);
  memcpy(rest->r, t->worldHasSurfaces ? own->block.r : own->centres, sizeof rest->r);
}

/* Whether a node is where it was when it was last put into the world. A leaf that is there unchanged is dated anew, so
 * as to be told more quickly next time; of nodes the date is that of boxes, too. */
static bool isThere(Traversal* t, int level, int node) {
  if (t->worldTime[node] == NEVER) {
    return false;
  }
  int end;
  treeSlots(t->tree, level, node, &end);
  const bool stays = treeLeavesStay(t->tree, t->worldTime[node], (end + TREE_WIDTH - 1) / TREE_WIDTH);
  if (stays && level == 0 && t->tree->contentTime[node] <= t->worldTime[node]) {
    t->worldTime[node] = t->tree->time;
  }
  return stays;
}

/* Gives a leaf the entry of the one that has been put to rest longest ago. */
static void takeEntry(Traversal* t, int leaf) {
  const int entry = t->nextEntry;
  const int other = t->leafOfEntry[entry];
  if (other != CT_NULL) {
    t->worldTime[other] = NEVER;
    t->entryOf[other] = CT_NULL;
    t->inView[other] = NULL; /* positions are read off what is at rest */
  }
  t->leafOfEntry[entry] = leaf;
  t->entryOf[leaf] = entry;
  t->nextEntry = entry + 1 < t->leafEntryCount ? entry + 1 : 0;
}

static void recomputeWorld(Traversal* t, int level, int node) {
  const Tree* tree = t->tree;
  if (!isThere(t, level, node)) {
    if (t->entryOf[node] == CT_NULL) {
      takeEntry(t, node);
    }
    const int entry = t->entryOf[node];
    t->frame[entry] = tree->pose[node];
    if (level < treeTop(tree)) {
      const int parent = treeParent(tree, level, node);
      t->frame[entry] = transformCompose(&t->frame[t->entryOf[parent]], &tree->pose[node]);
    }
  } else if (tree->contentTime[node] <= t->worldTime[node]) {
    return;
  }
  t->worldTime[node] = tree->time;
  if (level == 0) {
    worldLeaf(t, node);
  } else {
    worldInnerNode(t, node);
  }
}

/* Puts the members of a node into the world as the state has them. Its parent has been there before. */
static inline void updateWorld(Traversal* t, int level, int node) {
  const int64_t since = t->worldTime[node];
  if (t->tree->contentTime[node] > since || !treeStays(t->tree, since)) {
    recomputeWorld(t, level, node);
  }
}

/* With all nodes over it. */
static void updateWorldLeaf(Traversal* t, int leaf) {
  for (int level = treeTop(t->tree); level >= 0; level--) {
    updateWorld(t, level, t->tree->levelBegin[level] + (leaf >> TREE_WIDTH_BITS * level));
  }
}

/* Members of a node at rest, put there before; its parent is there still. */
static Block* worldOf(Traversal* t, int node) {
  if (t->entryOf[node] == CT_NULL) {
    updateWorld(t, 0, node);
  }
  return &t->world[t->entryOf[node]];
}

/* The members of a node that moves. */
static Block* moveNode(Traversal* t, int node) {
  const int entry = t->nextMoved;
  t->nextMoved = entry + 1 < t->movedCapacity ? entry + 1 : 0;
  Block* moved = &t->moved[entry];
  const int other = t->movedNode[entry];
  if (t->inView[other] == moved) {
    t->inView[other] = NULL;
  }
  t->movedNode[entry] = node;
  Block* rest = worldOf(t, node);
  moveBlock(rest, t->motions[t->motion[node]], 0xffff, moved);
  memcpy(moved->r, rest->r, sizeof moved->r);
  return moved;
}

/* Once a descent. Its parent has been expanded. */
static void expand(Traversal* t, int level, int node) {
  if (t->nodeStamp[node] == t->stamp) {
    return;
  }
  t->nodeStamp[node] = t->stamp;
  updateWorld(t, level, node);
  t->inView[node] = moves(t->view, t->motion[node]) ? moveNode(t, node) : worldOf(t, node);
}

static Sphere boundOfStraddler(const Traversal* t, const Straddler* s) {
  Sphere bound = middleOfBlock(&s->block);
  /* Straddlers lie within straddlers: each level adds its own rounding. */
  bound.r += radiusAbout(bound, &s->block, s->block.r) + (float)floatMargin(t->extent);
  return bound;
}

/* A node that straddles pieces, and all such below it; `piece` holds its first slot. */
static const Straddler* expandStraddler(Traversal* t, int level, int node, int piece) {
  const View* view = t->view;
  const Tree* tree = t->tree;
  t->nodeStamp[node] = t->stamp;
  t->motion[node] = straddlerCode(t->straddlerCount);
  Straddler* s = &t->straddlers[t->straddlerCount++];
  s->node = node;
  updateWorld(t, level, node);
  Block* rest = worldOf(t, node);
  s->block = *rest;
  s->isBoxed = false;
  memset(s->motion, 0, sizeof s->motion);
  t->inView[node] = &s->block;
  int end;
  const int begin = treeSlots(tree, level, node, &end);
  const int width = 1 << TREE_WIDTH_BITS * level;
  const int first = level == 0 ? 0 : tree->levelBegin[level - 1] + begin / width;
  const int count = (end - begin + width - 1) / width;
  int k = 0;
  while (k < count) {
    const int from = begin + k * width;
    while (piece + 1 < view->pieceCount && view->pieces[piece + 1].slotBegin <= from) {
      piece++;
    }
    const int next = piece + 1 < view->pieceCount ? view->pieces[piece + 1].slotBegin : end;
    const int wholes = next < end ? (next - begin) / width : count;
    if (wholes > k) {
      const int motion = view->pieces[piece].motion;
      if (moves(view, motion)) {
        moveBlock(rest, t->motions[motion], (1u << wholes) - (1u << k), &s->block);
      }
      /* How many there are can hardly be foreseen: so no branch depends on it. */
      for (int l = 0; l < TREE_WIDTH; l++) {
        s->motion[l] = k <= l && l < wholes ? motion : s->motion[l];
      }
      k = wholes;
    } else if (level > 0) { /* a slot straddles nothing */
      const Sphere bound = boundOfStraddler(t, expandStraddler(t, level - 1, first + k, piece));
      s->block.x[k] = bound.x;
      s->block.y[k] = bound.y;
      s->block.z[k] = bound.z;
      s->block.r[k] = bound.r;
      s->motion[k] = t->motion[first + k];
      k++;
    }
  }
  return s;
}

/* A new view: its motions, and how large the scene is in it. */
static void startView(Traversal* t, const View* view) {
  const Tree* tree = t->tree;
  const int root = treeRoot(tree);
  const Bound* bound = &tree->bound[root];
  const double centre[3] = {bound->x, bound->y, bound->z};
  t->view = view;
  const double size = bound->r < 0 ? 0 : sqrt(dot(centre, centre)) + (double)bound->r;
  double shift = 0;
  if (view->motions != NULL) {
    for (int i = 1; i < view->motionCount; i++) {
      double translation[3];
      translationOf(&view->motions[i], translation);
      shift = larger(shift, sqrt(dot(translation, translation)));
      floatMotion(&view->motions[i], t->motions[i]);
    }
  }
  t->extent = size + shift;
  t->band = DOUBLE_MARGIN * t->extent;
  if (++t->stamp == 0) {
    memset(t->nodeStamp, 0, (size_t)tree->nodeCount * sizeof(uint32_t));
    for (int i = 0; i < t->movedBoxesCapacity; i++) {
      t->movedBoxes[i].stamp = 0;
    }
    t->stamp = 1;
  }
  if (t->worldHasSurfaces != view->surfaces) {
    for (int node = 0; node < tree->nodeCount; node++) {
      t->worldTime[node] = NEVER;
    }
    t->worldHasSurfaces = view->surfaces;
  }
  t->straddlerCount = 0;
  t->nextMoved = 0;
  t->movedBoxesCount = 0;
}

/* A sphere at rest of a body of this motion, where the view has it. */
static Sphere sphereInView(const Traversal* t, Sphere sphere, int motion) {
  return moves(t->view, motion) ? movedSphere(sphere, t->motions[motion]) : sphere;
}

static Block* viewAgain(Traversal* t, int node) {
  const int code = t->motion[node];
  Block* rest = worldOf(t, node);
  return code < 0 ? &straddlerOf(t, code)->block : moves(t->view, code) ? moveNode(t, node) : rest;
}

/* An expanded node: its members as they lie in the view. */
static const Block* blockOf(Traversal* t, int node) {
  if (t->inView[node] == NULL) {
    t->inView[node] = viewAgain(t, node);
  }
  return t->inView[node];
}

/* Those of two. The second may have taken the room of the first, which then is made again, elsewhere. */
static void blocksOf(Traversal* t, int a, int b, const Block* blocks[2]) {
  blockOf(t, a);
  blocks[1] = blockOf(t, b);
  blocks[0] = blockOf(t, a);
}

/* Members of a node that are of a rigid body; none, if that straddles. */
static unsigned ofBody(const Traversal* t, int node, int motion) {
  const int code = t->motion[node];
  if (code < 0) {
    return motion < 0 ? 0 : equal16(straddlerOf(t, code)->motion, motion);
  }
  return code == motion ? 0xffff : 0;
}

#endif /* CT_VIEW_BODY_H_ */
