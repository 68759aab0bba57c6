/* How an item of the tree follows from what is below it; compiled once for each instruction set by the file that
 * includes this. */
#include <string.h>

#include "instructions.h"
#include "volume.h"

/* ---- Bounds ---- */

/* The radii have room for the rounding to float, relative to coordinates about the item's own origin. */
static Bound boundOfMembers(const Block* block, const float* centres) {
  const Sphere middle = middleOfBlock(block);
  if (middle.r < 0) {
    return (Bound){0, 0, 0, -INFINITY, -INFINITY};
  }
  const float r = radiusAbout(middle, block, block->r);
  const float rounding = 1e-6f * (fabsf(middle.x) + fabsf(middle.y) + fabsf(middle.z) + r) + FLOAT_FLOOR;
  return (Bound){middle.x, middle.y, middle.z, r + rounding, radiusAbout(middle, block, centres) + rounding};
}

static Bound boundOfLeaf(const Leaf* leaf) {
  Block block;
  leafBlock(leaf, &block);
  return boundOfMembers(&block, leaf->centres);
}

/* ---- Update, bottom-up ---- */

static int firstLink(const Tree* tree, const Sequence* sequence, int leaf) {
  return leaf < tree->levelSize[0] ? sequence->slotLink[leaf * TREE_WIDTH] : CT_NULL;
}

/* The frame of the next link, and its axis. */
static void stepFrame(Tree* tree, const Sequence* sequence, int link, Frame* frame) {
  const Frame step = sequenceStep(sequence, link);
  *frame = transformCompose(frame, &step);
  rotate(frame, sequence->axis[link + 1], tree->axis[link + 1]);
}

static void refreshLeaf(Tree* tree, const Sequence* sequence, int leaf) {
  const int begin = leaf * TREE_WIDTH;
  const int end = begin + TREE_WIDTH < tree->slotCount ? begin + TREE_WIDTH : tree->slotCount;
  Leaf* own = &tree->leaf[leaf];
  int link = firstLink(tree, sequence, leaf);
  Frame frame = transformIdentity();
  if (sequence->slotBegin[link] == begin) {
    memcpy(tree->axis[link], sequence->axis[link], sizeof tree->axis[link]);
  }
  for (int slot = begin; slot < end; slot++) {
    for (; link < sequence->slotLink[slot]; link++) {
      stepFrame(tree, sequence, link, &frame);
    }
    const int particle = sequence->slotParticle[slot];
    if (particle != CT_NULL) {
      double x[3];
      sequenceLocal(sequence, particle, x);
      transformPoint(&frame, x, x);
      own->x[slot - begin] = x[0];
      own->y[slot - begin] = x[1];
      own->z[slot - begin] = x[2];
    }
  }
  for (const int next = firstLink(tree, sequence, leaf + 1); link < next; link++) {
    const Frame step = sequenceStep(sequence, link);
    frame = transformCompose(&frame, &step);
  }
  tree->shortcut[leaf] = frame;
  tree->bound[leaf] = boundOfLeaf(own);
  tree->hasSum[leaf] = false;
  tree->isFresh[leaf] = true;
}

/* Children before the first changed one are where they were. */
static void refreshNode(Tree* tree, int level, int item, int firstChanged) {
  int count;
  const int first = treeChildren(tree, level, item, &count);
  Members* members = treeMembers(tree, item);
  for (int child = firstChanged; child < first + count; child++) {
    if (child == first) {
      tree->pose[child] = transformIdentity();
    } else if (child > firstChanged) {
      tree->pose[child] = transformCompose(&tree->pose[child - 1], &tree->shortcut[child - 1]);
    }
    const Bound* own = &tree->bound[child];
    double centre[3] = {own->x, own->y, own->z};
    transformPoint(&tree->pose[child], centre, centre);
    members->block.x[child - first] = (float)centre[0];
    members->block.y[child - first] = (float)centre[1];
    members->block.z[child - first] = (float)centre[2];
    members->block.r[child - first] = own->r;
    members->centres[child - first] = own->centres;
  }
  const int last = first + count - 1;
  tree->shortcut[item] = transformCompose(&tree->pose[last], &tree->shortcut[last]);
  tree->bound[item] = boundOfMembers(&members->block, members->centres);
  tree->hasSum[item] = false;
  tree->isFresh[item] = true;
}
