/* The members of nodes in the world and in a view, compiled once for each instruction set by the file that includes
 * this. */
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

/* The motion of a slot. */
static int motionOfSlot(const View* view, int slot) {
  return view->pieces[pieceOf(view, slot)].body;
}

/* The motion of a member of an expanded node, coded like Traversal.motion. */
static int motionOfMember(const Traversal* t, int node, int k) {
  const int code = t->motion[node];
  return code < 0 ? straddlerOf(t, code)->motion[k] : code;
}

/* Computes the world coordinates of a leaf's members from its frame. */
static void worldLeaf(Traversal* t, int leaf) {
  const Frame* f = &t->frame[t->entryOf[leaf]];
  const Leaf* own = &t->tree->leaf[leaf];
  Block* world = &t->world[t->entryOf[leaf]];
  store16(world->x, rounded16(own->x, own->y, own->z, f->m[0]));
  store16(world->y, rounded16(own->x, own->y, own->z, f->m[1]));
  store16(world->z, rounded16(own->x, own->y, own->z, f->m[2]));
  if (t->worldHasSurfaces) {
    store16(world->r, load16(own->r));
  } else {
    leafCentres(own, world->r);
  }
}

/* Two at a time, as frames are stored: a processor waits for what it loads at once and has stored in parts. */
static void floatMotion(const Frame* f, float motion[12]) {
  typedef double Doubles __attribute__((vector_size(16)));
  typedef float Floats __attribute__((vector_size(8)));
  for (int i = 0; i < 12; i += 2) {
    Doubles pair;
    memcpy(&pair, f->m[0] + i, sizeof pair);
    const Floats rounded = __builtin_convertvector(pair, Floats);
    memcpy(motion + i, &rounded, sizeof rounded);
  }
}

/* The same for an inner node. */
static void worldInnerNode(Traversal* t, int node) {
  const Members* own = treeMembers(t->tree, node);
  Block* world = &t->world[t->entryOf[node]];
  float motion[12];
  floatMotion(&t->frame[t->entryOf[node]], motion);
  moveAll(&own->block, t->worldHasSurfaces ? own->block.r : own->centres, motion, world);
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
static void confirmWorld(Traversal* t, int node) {
  t->worldTime[node] = t->tree->time;
}

/* Gives a leaf the entry of the leaf that has had one longest. */
static void takeEntry(Traversal* t, int leaf) {
  const int entry = t->nextEntry;
  const int other = t->leafOfEntry[entry];
  if (other != CT_NULL) {
    t->worldTime[other] = NEVER;
    t->entryOf[other] = CT_NULL;
    t->inView[other] = NULL; /* its coordinates are overwritten */
  }
  t->leafOfEntry[entry] = leaf;
  t->entryOf[leaf] = entry;
  t->nextEntry = entry + 1 < t->leafEntryCount ? entry + 1 : 0;
}

/* Recomputes a node's frame in the world from that of its parent. */
static void recomputeFrame(Traversal* t, int level, int node) {
  const Tree* tree = t->tree;
  if (t->entryOf[node] == CT_NULL) {
    takeEntry(t, node);
  }
  Frame* frame = &t->frame[t->entryOf[node]];
  if (level == treeTop(tree)) {
    *frame = tree->pose[node];
    return;
  }
  const int parent = treeParent(tree, level, node);
  *frame = transformCompose(&t->frame[t->entryOf[parent]], &tree->pose[node]);
  if (level > 0) {
    t->frameTime[node - tree->levelBegin[1]] = tree->time;
  }
}

/* Recomputes what has changed of a node's frame and members in the world. */
static void recomputeWorld(Traversal* t, int level, int node) {
  const Tree* tree = t->tree;
  if (!hasFrame(t, level, node)) {
    recomputeFrame(t, level, node);
  } else if (tree->contentTime[node] <= t->worldTime[node]) {
    confirmWorld(t, node);
    return;
  }
  t->worldTime[node] = tree->contentTime[node] > tree->time ? tree->contentTime[node] : tree->time;
  if (level == 0) {
    worldLeaf(t, node);
  } else {
    worldInnerNode(t, node);
    t->membersTime[node - tree->levelBegin[1]] = t->worldTime[node];
  }
}

/* Brings the world coordinates of a node's members up to date with the state. Its parent's must be so. */
static inline void updateWorld(Traversal* t, int level, int node) {
  if (!traversalHasWorld(t, node)) {
    recomputeWorld(t, level, node);
  }
}

/* Brings the world coordinates of a leaf up to date, and those of the nodes over it. */
static void updateWorldLeaf(Traversal* t, int leaf) {
  for (int level = treeTop(t->tree); level >= 0; level--) {
    updateWorld(t, level, t->tree->levelBegin[level] + (leaf >> TREE_WIDTH_BITS * level));
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

/* Moves the members of a node into the view. */
static Block* moveNode(Traversal* t, int node) {
  const int entry = t->nextMoved;
  t->nextMoved = entry + 1 < t->movedCapacity ? entry + 1 : 0;
  Block* moved = &t->moved[entry];
  const int other = t->movedNode[entry];
  if (t->inView[other] == moved) {
    t->inView[other] = NULL;
  }
  t->movedNode[entry] = node;
  Block* world = worldOf(t, node);
  moveAll(world, world->r, t->motions[t->motion[node]], moved);
  return moved;
}

/* Brings the members of a node into the view, once a descent. Its parent must be expanded. */
static void expand(Traversal* t, int level, int node) {
  if (t->nodeStamp[node] == t->stamp) {
    return;
  }
  t->nodeStamp[node] = t->stamp;
  updateWorld(t, level, node);
  t->inView[node] = moves(t->view, t->motion[node]) ? moveNode(t, node) : worldOf(t, node);
}

/* A sphere around a straddler's members in the view. */
static Sphere boundOfStraddler(const Traversal* t, const Straddler* s) {
  Sphere bound = middleOfBlock(&s->block);
  /* The members may be straddlers: each level adds its own rounding, see FLOAT_MARGIN. */
  bound.r += radiusAbout(bound, &s->block, s->block.r) + (float)floatMargin(t->extent);
  return bound;
}

/* Expands a node that straddles pieces; such nodes below it must be expanded. `piece` holds its first slot. */
static void expandStraddler(Traversal* t, int level, int node, int piece) {
  const View* view = t->view;
  const Tree* tree = t->tree;
  t->nodeStamp[node] = t->stamp;
  t->motion[node] = straddlerCode(t->straddlerCount);
  Straddler* s = &t->straddlers[t->straddlerCount++];
  s->node = node;
  s->isBoxed = false;
  t->inView[node] = &s->block;
  updateWorld(t, level, node);
  const Block* world = worldOf(t, node);
  Float16 x = load16(world->x);
  Float16 y = load16(world->y);
  Float16 z = load16(world->z);
  Float16 r = load16(world->r);
  Float16 motions = allInts16(0);
  int end;
  const int begin = treeSlots(tree, level, node, &end);
  const int bits = TREE_WIDTH_BITS * level; /* of the width of a member */
  const int first = level == 0 ? 0 : tree->levelBegin[level - 1] + (begin >> bits);
  const int count = (end - begin + (1 << bits) - 1) >> bits;
  int k = 0;
  while (k < count) {
    const int from = begin + (k << bits);
    while (piece + 1 < view->pieceCount && view->pieces[piece + 1].slotBegin <= from) {
      piece++;
    }
    const int next = piece + 1 < view->pieceCount ? view->pieces[piece + 1].slotBegin : end;
    const int wholes = next < end ? (next - begin) >> bits : count;
    if (wholes > k) {
      const int motion = view->pieces[piece].body;
      const unsigned mask = (1u << wholes) - (1u << k);
      if (moves(view, motion)) {
        x = blend16(mask, x, moved16(world, t->motions[motion]));
        y = blend16(mask, y, moved16(world, t->motions[motion] + 4));
        z = blend16(mask, z, moved16(world, t->motions[motion] + 8));
      }
      motions = blend16(mask, motions, allInts16(motion));
      k = wholes;
    } else if (level > 0) { /* a slot straddles nothing */
      const int code = t->motion[first + k];
      const Sphere bound = boundOfStraddler(t, straddlerOf(t, code));
      x = blend16(1u << k, x, all16(bound.x));
      y = blend16(1u << k, y, all16(bound.y));
      z = blend16(1u << k, z, all16(bound.z));
      r = blend16(1u << k, r, all16(bound.r));
      motions = blend16(1u << k, motions, allInts16(code));
      k++;
    }
  }
  store16(s->block.x, x);
  store16(s->block.y, y);
  store16(s->block.z, z);
  store16(s->block.r, r);
  storeInts16(s->motion, motions);
}

/* No coordinate or radius of the state is larger. */
static double sizeOfState(const Tree* tree) {
  const Bound* bound = &tree->bound[treeRoot(tree)];
  const double centre[3] = {bound->x, bound->y, bound->z};
  return bound->r < 0 ? 0 : sqrt(dot(centre, centre)) + (double)bound->r;
}

/* Begins a descent with a new view: takes its motions, and bounds how large the scene is in it. */
static void startView(Traversal* t, const View* view) {
  const Tree* tree = t->tree;
  t->view = view;
  const double size = sizeOfState(tree);
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
    t->firstNodesTime = NEVER;
    t->steadyTime = NEVER;
  }
  t->straddlerCount = 0;
  t->nextMoved = 0;
  t->movedBoxesCount = 0;
}

/* Moves a sphere of this motion from the world into the view. */
static Sphere sphereInView(const Traversal* t, Sphere sphere, int motion) {
  return moves(t->view, motion) ? movedSphere(sphere, t->motions[motion]) : sphere;
}

/* The members of an expanded node whose entry another node has taken. */
static Block* viewAgain(Traversal* t, int node) {
  const int code = t->motion[node];
  Block* world = worldOf(t, node);
  return code < 0 ? &straddlerOf(t, code)->block : moves(t->view, code) ? moveNode(t, node) : world;
}

/* The members of an expanded node in the view. */
static const Block* blockOf(Traversal* t, int node) {
  if (t->inView[node] == NULL) {
    t->inView[node] = viewAgain(t, node);
  }
  return t->inView[node];
}

/* The members of two expanded nodes in the view. The second may take the entry of the first: so the first is asked for
 * again. */
static void blocksOf(Traversal* t, int a, int b, const Block* blocks[2]) {
  blockOf(t, a);
  blocks[1] = blockOf(t, b);
  blocks[0] = blockOf(t, a);
}

/* The members of a node that have this motion, as bits; none, if it is the code of a straddler. */
static unsigned ofBody(const Traversal* t, int node, int motion) {
  const int code = t->motion[node];
  if (code < 0) {
    return motion < 0 ? 0 : equal16(straddlerOf(t, code)->motion, motion);
  }
  return code == motion ? 0xffff : 0;
}

#endif /* CT_VIEW_BODY_H_ */
