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
  if (!tree->boxIsOutdated[node]) {
    return box;
  }
  tree->boxIsOutdated[node] = false;
  if (level == 0) {
    Block block;
    leafBlock(&tree->leaf[node], &block);
    *box = boxAround(&block, NULL, &tree->bound[node]);
    return box;
  }
  ChildBoxes* boxes = boxesOf(t, node);
  bool moved = false;
  int count;
  const int first = treeChildren(tree, level, node, &count);
  for (int k = 0; k < count; k++) {
    const int child = first + k;
    moved = moved || (k > 0 && tree->shortcutRevision[child - 1] > boxes->ownRevision);
    if (tree->bound[child].r >= 0 && (moved || tree->contentRevision[child] > boxes->ownRevision)) {
      float pose[12];
      floatMotion(&tree->pose[child], pose);
      const Box inner = movedBox(ownBox(t, level - 1, child), pose);
      putBox(&boxes->own, k, &inner);
    }
  }
  boxes->ownRevision = tree->revision + 1; /* bounds are tight then */
  boxes->worldRevision = NO_REVISION;
  /* The box of the root is not needed. */
  if (level < treeTop(tree)) {
    *box = boxAround(&treeMembers(tree, node)->block, &boxes->own, &tree->bound[node]);
  }
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

const BoxBlock* CT_WIDE(boxesInView)(Traversal* t, int level, int node) {
  ChildBoxes* boxes = boxesOf(t, node);
  ownBox(t, level, node);
  const int64_t membersRevision = t->world->membersRevision[node - t->tree->levelBegin[1]];
  if (boxes->worldRevision != membersRevision) {
    boxes->worldRevision = membersRevision;
    float frame[12];
    floatMotion(&t->world->frame[t->world->entryOf[node]], frame);
    moveBoxes(&boxes->own, frame, &boxes->world);
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
