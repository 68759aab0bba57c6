/* Boxes of the items of a view, compiled once for each instruction set by the file that includes this. */
#ifndef CT_VIEWBOXES_BODY_H_
#define CT_VIEWBOXES_BODY_H_

#include "view_body.h"

static NodeBoxes* boxesOf(const Traversal* t, int node) {
  return &t->boxes[node - t->tree->levelBegin[1]];
}

/* Around the members of an item in its own frame; with it, the boxes of its children. */
static const Box* ownBox(Traversal* t, int level, int item) {
  const Tree* tree = t->tree;
  Box* box = &t->box[item];
  if (!tree->isFresh[item]) {
    return box;
  }
  tree->isFresh[item] = false;
  if (level == 0) {
    Block block;
    leafBlock(&tree->leaf[item], &block);
    *box = boxAround(&block, 0, NULL, &tree->bound[item]);
    return box;
  }
  NodeBoxes* boxes = boxesOf(t, item);
  Box inner[TREE_WIDTH];
  unsigned thin = 0;
  bool moved = false;
  int count;
  const int first = treeChildren(tree, level, item, &count);
  for (int k = 0; k < count; k++) {
    const int child = first + k;
    moved = moved || (k > 0 && tree->shortcutTime[child - 1] > boxes->ownTime);
    if (tree->bound[child].r < 0) {
      continue;
    }
    if (!moved && tree->contentTime[child] <= boxes->ownTime) {
      inner[k] = boxOf(&boxes->own, k);
      thin |= boxes->thin & 1u << k;
      continue;
    }
    float pose[12];
    floatMotion(&tree->pose[child], pose);
    const Box* own = ownBox(t, level - 1, child);
    inner[k] = movedBox(own, pose);
    thin |= (unsigned)own->thin << k;
    putBox(&boxes->own, k, &inner[k]);
  }
  boxes->thin = thin;
  boxes->ownTime = tree->time;
  boxes->restSince = NEVER;
  /* Nothing is around the root. */
  if (level < treeTop(tree)) {
    *box = boxAround(&treeMembers(tree, item)->block, thin, inner, &tree->bound[item]);
  }
  return box;
}

static BoxBlock* boxesInView(Traversal* t, int level, int node);

/* Around the members of an item that straddles, in the view. */
static Box straddlerBox(Traversal* t, int level, int item) {
  const Block* block = &straddlerOf(t, t->motion[item])->block;
  const Sphere middle = middleOfBlock(block);
  const Bound bound = {middle.x, middle.y, middle.z, middle.r + radiusAbout(middle, block, block->r), 0};
  if (level == 0 || bound.r < 0) {
    return boxAround(block, 0, NULL, &bound);
  }
  const BoxBlock* inView = boxesInView(t, level, item);
  Box inner[TREE_WIDTH];
  for (int k = 0; k < TREE_WIDTH; k++) {
    inner[k] = boxOf(inView, k);
  }
  return boxAround(block, boxesOf(t, item)->thinInView, inner, &bound);
}

/* Boxes of the children of an expanded node, in the view. */
static BoxBlock* boxesInView(Traversal* t, int level, int node) {
  NodeBoxes* boxes = boxesOf(t, node);
  ownBox(t, level, node);
  if (boxes->restSince != t->since[node]) {
    boxes->restSince = t->since[node];
    float frame[12];
    floatMotion(&t->frame[node], frame);
    boxes->rest = boxes->own;
    moveBoxes(&boxes->own, frame, 0xffff, &boxes->rest);
  }
  const int code = t->motion[node];
  if (code == 0 || (code > 0 && t->view->motions == NULL)) {
    boxes->thinInView = boxes->thin;
    return &boxes->rest;
  }
  if (boxes->stamp != t->stamp) {
    boxes->stamp = t->stamp;
    boxes->moved = boxes->rest;
    boxes->thinInView = boxes->thin;
    for (int k = 0; k < TREE_WIDTH;) {
      /* Children that move alike go together. */
      const int motion = motionOfMember(t, node, k);
      unsigned run = 0;
      for (; k < TREE_WIDTH && motion == motionOfMember(t, node, k); k++) {
        run |= 1u << k;
      }
      if (moves(t->view, motion)) {
        moveBoxes(&boxes->rest, t->motions[motion], run, &boxes->moved);
      } else if (motion < 0) {
        const int child = __builtin_ctz(run);
        const Box box = straddlerBox(t, level - 1, straddlerOf(t, motion)->item);
        putBox(&boxes->moved, child, &box);
        boxes->thinInView = (boxes->thinInView & ~run) | (unsigned)box.thin << child;
      }
    }
  }
  return &boxes->moved;
}

#endif /* CT_VIEWBOXES_BODY_H_ */
