#include "viewboxes.h"

/* The boxes of an inner node's children. */
static ChildBoxes* boxesOf(const Traversal* t, int node) {
  return &t->boxes[node - t->tree->levelBegin[1]];
}

/* The box around the members of a node, in its own frame. Makes it, and the boxes of the node's children, if they are
 * outdated. */
static const Box* ownBox(Traversal* t, int level, int node) {
  const Tree* tree = t->tree;
  Box* box = &t->box[node];
  const Revision since = box->builtFrom;
  if (tree->contentRevision[node] <= since) {
    return box;
  }
  if (level == 0) {
    Block block;
    leafBlock(&tree->leaf[node], &block);
    *box = boxAround(&block, NULL, &tree->bound[node]);
    box->builtFrom = tree->changes.now;
    return box;
  }
  ChildBoxes* boxes = boxesOf(t, node);
  bool moved = false;
  int count;
  const int first = treeChildren(tree, level, node, &count);
  for (int k = 0; k < count; k++) {
    const int child = first + k;
    moved = moved || (k > 0 && tree->shortcutRevision[child - 1] > since);
    if (tree->bound[child].r >= 0 && (moved || tree->contentRevision[child] > since)) {
      float pose[12];
      floatMotion(&tree->pose[child], pose);
      const Box inner = movedBox(ownBox(t, level - 1, child), pose);
      putBox(&boxes->own, k, &inner);
    }
  }
  boxes->worldFrom = NO_REVISION;
  /* The box of the root is not needed. */
  if (level < treeTop(tree)) {
    *box = boxAround(&treeMembers(tree, node)->block, &boxes->own, &tree->bound[node]);
  }
  box->builtFrom = tree->changes.now;
  return box;
}

/* The box around the members of a mixed node, in the view. */
static Box mixedNodeBox(Traversal* t, int level, int node) {
  const Block* block = &mixedNodeOf(t, t->body[node])->block;
  const Sphere middle = middleOfBlock(block);
  const Bound bound = {middle.x, middle.y, middle.z, middle.r + radiusAbout(middle, block, block->r), 0};
  if (level == 0 || bound.r < 0) {
    return boxAround(block, NULL, &bound);
  }
  return boxAround(block, CT_WIDE(boxesInView)(t, level, node), &bound);
}

/* The boxes of the children of a mixed node, in the view. */
static const BoxBlock* mixedNodeBoxes(Traversal* t, int level, int node) {
  const ChildBoxes* boxes = boxesOf(t, node);
  MixedNode* s = mixedNodeOf(t, t->body[node]);
  if (s->isBoxed) {
    return &s->boxes;
  }
  s->isBoxed = true;
  s->boxes = boxes->world;
  for (int k = 0; k < TREE_WIDTH;) {
    /* Children of one body are moved together. */
    const int body = s->body[k];
    unsigned run = 0;
    for (; k < TREE_WIDTH && body == s->body[k]; k++) {
      run |= 1u << k;
    }
    if (moves(t->view, body)) {
      BoxBlock moved;
      moveBoxes(&boxes->world, t->motions[body], &moved);
      replaceBoxes(&s->boxes, run, &moved);
    } else if (body < 0) {
      const int child = __builtin_ctz(run);
      const Box box = mixedNodeBox(t, level - 1, mixedNodeOf(t, body)->node);
      putBox(&s->boxes, child, &box);
    }
  }
  return &s->boxes;
}

/* Moves the boxes of children into the world, unless they are right. The node must be placed. */
static void updateWorldBoxes(const Traversal* t, int level, int node, ChildBoxes* boxes) {
  if (nodeMovedSince(t->tree, level, node, boxes->worldFrom)) {
    float frame[12];
    floatMotion(&t->world->frame[t->world->entryOf[node]], frame);
    moveBoxes(&boxes->own, frame, &boxes->world);
  }
  boxes->worldFrom = t->tree->changes.now;
}

const BoxBlock* CT_WIDE(boxesInView)(Traversal* t, int level, int node) {
  ChildBoxes* boxes = boxesOf(t, node);
  ownBox(t, level, node);
  if (boxes->worldFrom != t->tree->changes.now) {
    updateWorldBoxes(t, level, node, boxes);
  }
  const int code = t->body[node];
  if (code < 0) {
    return mixedNodeBoxes(t, level, node);
  }
  if (!moves(t->view, code)) {
    return &boxes->world;
  }
  MovedBoxes* moved = &t->movedBoxes[boxes->movedAt % t->movedBoxesCapacity];
  if (moved->node != node || moved->descent != t->descent ||
      t->movedBoxesCount - boxes->movedAt > t->movedBoxesCapacity - BOXES_PER_VISIT) {
    boxes->movedAt = t->movedBoxesCount++;
    moved = &t->movedBoxes[boxes->movedAt % t->movedBoxesCapacity];
    moved->node = node;
    moved->descent = t->descent;
    moveBoxes(&boxes->world, t->motions[code], &moved->boxes);
  }
  return &moved->boxes;
}
