/* What a view makes of the items of a tree, compiled once for each instruction set by the file that includes this. */
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

/* Of which rigid body a member of an expanded item is, coded like Traversal.motion. */
static int motionOfMember(const Traversal* t, int item, int k) {
  const int code = t->motion[item];
  return code < 0 ? straddlerOf(t, code)->motion[k] : code;
}

static void restLeaf(Traversal* t, int leaf) {
  const Frame* f = &t->frame[t->restAt[leaf]];
  const Leaf* own = &t->tree->leaf[leaf];
  Block* rest = &t->rest[t->restAt[leaf]];
  for (int k = 0; k < TREE_WIDTH; k++) {
    const double x = own->x[k];
    const double y = own->y[k];
    const double z = own->z[k];
    rest->x[k] = (float)(f->m[0][0] * x + f->m[0][1] * y + f->m[0][2] * z + f->m[0][3]);
    rest->y[k] = (float)(f->m[1][0] * x + f->m[1][1] * y + f->m[1][2] * z + f->m[1][3]);
    rest->z[k] = (float)(f->m[2][0] * x + f->m[2][1] * y + f->m[2][2] * z + f->m[2][3]);
  }
  if (t->sinceSurfaces) {
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

static void restNode(Traversal* t, int item) {
  const Members* own = treeMembers(t->tree, item);
  Block* rest = &t->rest[t->restAt[item]];
  float motion[12];
  floatMotion(&t->frame[t->restAt[item]], motion);
  moveBlock(&own->block, motion, 0xffff, rest);
  memcpy(rest->r, t->sinceSurfaces ? own->block.r : own->centres, sizeof rest->r);
}

/* Whether an item is where it was when it was last put into the world. A leaf that is there unchanged is dated anew, so
 * as to be told more quickly next time; of nodes the date is that of boxes, too. */
static bool isThere(Traversal* t, int level, int item) {
  if (t->since[item] == NEVER) {
    return false;
  }
  int end;
  treeSlots(t->tree, level, item, &end);
  const bool stays = treeLeavesStay(t->tree, t->since[item], (end + TREE_WIDTH - 1) / TREE_WIDTH);
  if (stays && level == 0 && t->tree->contentTime[item] <= t->since[item]) {
    t->since[item] = t->tree->time;
  }
  return stays;
}

/* Gives a leaf the place of the one that has been put to rest longest ago. */
static void takePlace(Traversal* t, int leaf) {
  const int place = t->nextPlace;
  const int other = t->leafAt[place];
  if (other != CT_NULL) {
    t->since[other] = NEVER;
    t->restAt[other] = CT_NULL;
    t->inView[other] = NULL; /* positions are read off what is at rest */
  }
  t->leafAt[place] = leaf;
  t->restAt[leaf] = place;
  t->nextPlace = place + 1 < t->leafPlaces ? place + 1 : 0;
}

static void moveToRest(Traversal* t, int level, int item) {
  const Tree* tree = t->tree;
  if (!isThere(t, level, item)) {
    if (t->restAt[item] == CT_NULL) {
      takePlace(t, item);
    }
    const int place = t->restAt[item];
    t->frame[place] = tree->pose[item];
    if (level < treeTop(tree)) {
      const int parent = treeParent(tree, level, item);
      t->frame[place] = transformCompose(&t->frame[t->restAt[parent]], &tree->pose[item]);
    }
  } else if (tree->contentTime[item] <= t->since[item]) {
    return;
  }
  t->since[item] = tree->time;
  if (level == 0) {
    restLeaf(t, item);
  } else {
    restNode(t, item);
  }
}

/* Puts the members of an item into the world as the state has them. Its parent has been there before. */
static inline void putToRest(Traversal* t, int level, int item) {
  const int64_t since = t->since[item];
  if (t->tree->contentTime[item] > since || !treeStays(t->tree, since)) {
    moveToRest(t, level, item);
  }
}

/* With all nodes over it. */
static void putLeafToRest(Traversal* t, int leaf) {
  for (int level = treeTop(t->tree); level >= 0; level--) {
    putToRest(t, level, t->tree->levelBegin[level] + (leaf >> TREE_WIDTH_BITS * level));
  }
}

/* Members of an item at rest, put there before; its parent is there still. */
static Block* restOf(Traversal* t, int item) {
  if (t->restAt[item] == CT_NULL) {
    putToRest(t, 0, item);
  }
  return &t->rest[t->restAt[item]];
}

/* The members of an item that moves. */
static Block* moveItem(Traversal* t, int item) {
  const int place = t->movedCount;
  t->movedCount = place + 1 < t->movedPlaces ? place + 1 : 0;
  Block* moved = &t->moved[place];
  const int other = t->movedItem[place];
  if (t->inView[other] == moved) {
    t->inView[other] = NULL;
  }
  t->movedItem[place] = item;
  Block* rest = restOf(t, item);
  moveBlock(rest, t->motions[t->motion[item]], 0xffff, moved);
  memcpy(moved->r, rest->r, sizeof moved->r);
  return moved;
}

/* Once a descent. Its parent has been expanded. */
static void expand(Traversal* t, int level, int item) {
  if (t->itemStamp[item] == t->stamp) {
    return;
  }
  t->itemStamp[item] = t->stamp;
  putToRest(t, level, item);
  t->inView[item] = moves(t->view, t->motion[item]) ? moveItem(t, item) : restOf(t, item);
}

static Sphere boundOfStraddler(const Traversal* t, const Straddler* s) {
  Sphere bound = middleOfBlock(&s->block);
  /* Straddlers lie within straddlers: each level adds its own rounding. */
  bound.r += radiusAbout(bound, &s->block, s->block.r) + (float)floatMargin(t->extent);
  return bound;
}

/* An item that straddles pieces, and all such below it; `piece` holds its first slot. */
static const Straddler* expandStraddler(Traversal* t, int level, int item, int piece) {
  const View* view = t->view;
  const Tree* tree = t->tree;
  t->itemStamp[item] = t->stamp;
  t->motion[item] = straddlerCode(t->straddlerCount);
  Straddler* s = &t->straddlers[t->straddlerCount++];
  s->item = item;
  putToRest(t, level, item);
  Block* rest = restOf(t, item);
  s->block = *rest;
  s->isBoxed = false;
  memset(s->motion, 0, sizeof s->motion);
  t->inView[item] = &s->block;
  int end;
  const int begin = treeSlots(tree, level, item, &end);
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
    memset(t->itemStamp, 0, (size_t)tree->itemCount * sizeof(uint32_t));
    for (int i = 0; i < t->movedBoxesPlaces; i++) {
      t->movedBoxes[i].stamp = 0;
    }
    t->stamp = 1;
  }
  if (t->sinceSurfaces != view->surfaces) {
    for (int item = 0; item < tree->itemCount; item++) {
      t->since[item] = NEVER;
    }
    t->sinceSurfaces = view->surfaces;
  }
  t->straddlerCount = 0;
  t->movedCount = 0;
  t->movedBoxesCount = 0;
}

/* A sphere at rest of a body of this motion, where the view has it. */
static Sphere sphereInView(const Traversal* t, Sphere sphere, int motion) {
  return moves(t->view, motion) ? movedSphere(sphere, t->motions[motion]) : sphere;
}

static Block* viewAgain(Traversal* t, int item) {
  const int code = t->motion[item];
  Block* rest = restOf(t, item);
  return code < 0 ? &straddlerOf(t, code)->block : moves(t->view, code) ? moveItem(t, item) : rest;
}

/* An expanded item: its members as they lie in the view. */
static const Block* blockOf(Traversal* t, int item) {
  if (t->inView[item] == NULL) {
    t->inView[item] = viewAgain(t, item);
  }
  return t->inView[item];
}

/* Those of two. The second may have taken the room of the first, which then is made again, elsewhere. */
static void blocksOf(Traversal* t, int a, int b, const Block* blocks[2]) {
  blockOf(t, a);
  blocks[1] = blockOf(t, b);
  blocks[0] = blockOf(t, a);
}

/* Members of an item that are of a rigid body; none, if that straddles. */
static unsigned ofBody(const Traversal* t, int item, int motion) {
  const int code = t->motion[item];
  if (code < 0) {
    return motion < 0 ? 0 : equal16(straddlerOf(t, code)->motion, motion);
  }
  return code == motion ? 0xffff : 0;
}

#endif /* CT_VIEW_BODY_H_ */
