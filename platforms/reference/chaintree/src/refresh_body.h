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

static void refreshLeaf(Tree* tree, const Sequence* sequence, int leaf) {
  const int begin = leaf * TREE_WIDTH;
  const int end = begin + TREE_WIDTH < tree->slotCount ? begin + TREE_WIDTH : tree->slotCount;
  Leaf* own = &tree->leaf[leaf];
  Walk walk;
  walkBegin(&walk, firstLink(tree, sequence, leaf));
  if (sequence->slotBegin[walk.link] == begin) {
    memcpy(tree->axis[walk.link], sequence->axis[walk.link], sizeof tree->axis[walk.link]);
  }
  for (int slot = begin; slot < end; slot++) {
    while (walk.link < sequence->slotLink[slot]) {
      walkOn(&walk, sequence);
      rotate(&walk.frame, sequence->axis[walk.link], tree->axis[walk.link]);
    }
    const int particle = sequence->slotParticle[slot];
    if (particle != CT_NULL) {
      double x[3];
      sequenceLocal(sequence, particle, x);
      transformPoint(&walk.frame, x, x);
      own->x[slot - begin] = x[0];
      own->y[slot - begin] = x[1];
      own->z[slot - begin] = x[2];
    }
  }
  const int next = firstLink(tree, sequence, leaf + 1);
  while (walk.link < next) {
    walkOn(&walk, sequence);
  }
  if (memcmp(&tree->shortcut[leaf], &walk.frame, sizeof walk.frame) != 0) {
    tree->shortcut[leaf] = walk.frame;
    tree->shortcutTime[leaf] = tree->time;
  }
  tree->bound[leaf] = boundOfLeaf(own);
  tree->contentTime[leaf] = tree->time;
  tree->hasSum[leaf] = false;
  tree->isFresh[leaf] = true;
}

/* Children before the first changed one are what and where they were; those behind it may be. */
static void refreshNode(Tree* tree, int level, int item, int firstChanged) {
  int count;
  const int first = treeChildren(tree, level, item, &count);
  Members* members = treeMembers(tree, item);
  bool moved = false;
  for (int child = firstChanged; child < first + count; child++) {
    if (child == first) {
      tree->pose[child] = transformIdentity();
    } else if (moved) {
      tree->pose[child] = transformCompose(&tree->pose[child - 1], &tree->shortcut[child - 1]);
    }
    if (moved || tree->contentTime[child] == tree->time) {
      const Bound* own = &tree->bound[child];
      double centre[3] = {own->x, own->y, own->z};
      transformPoint(&tree->pose[child], centre, centre);
      members->block.x[child - first] = (float)centre[0];
      members->block.y[child - first] = (float)centre[1];
      members->block.z[child - first] = (float)centre[2];
      members->block.r[child - first] = own->r;
      members->centres[child - first] = own->centres;
    }
    moved = moved || tree->shortcutTime[child] == tree->time;
  }
  if (moved) {
    const int last = first + count - 1;
    tree->shortcut[item] = transformCompose(&tree->pose[last], &tree->shortcut[last]);
    tree->shortcutTime[item] = tree->time;
  }
  tree->bound[item] = boundOfMembers(&members->block, members->centres);
  tree->contentTime[item] = tree->time;
  tree->hasSum[item] = false;
  tree->isFresh[item] = true;
}
