/* Sums of positions over the nodes of a tree. */
#include <string.h>

#include "tree.h"

/* The particles without a slot of a link that begins at this one; returns how many. */
static int slotlessAt(const Sequence* sequence, int slot, const int** slotless) {
  const int link = sequence->slotLink[slot];
  if (sequence->slotlessCount == 0 || sequence->slotBegin[link] != slot) {
    return 0;
  }
  const int begin = sequenceSlotless(sequence, link);
  *slotless = sequence->slotlessParticle + begin;
  return sequenceSlotless(sequence, link + 1) - begin;
}

void ctTreeCountParticles(Tree* tree, const Sequence* sequence) {
  const int* slotless;
  for (int slot = 0; slot < sequence->slotCount; slot++) {
    tree->particles[coveringNode(slot)] +=
        (sequence->slotParticle[slot] != CT_NULL) + slotlessAt(sequence, slot, &slotless);
  }
  for (int level = 1; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level - 1]; i++) {
      const int child = tree->levelBegin[level - 1] + i;
      tree->particles[treeParent(tree, level - 1, child)] += tree->particles[child];
    }
  }
}

/* Adds the positions of the particles of slots [slotBegin, slotEnd) of a leaf, and of particles without a slot of links
 * that begin there, to sum, in the leaf's frame; returns how many. */
static int sumSlots(const Tree* tree, const Sequence* sequence, int leaf, int slotBegin, int slotEnd, double sum[3]) {
  int particles = 0;
  Walk walk;
  treeWalk(&walk, sequence, leaf);
  for (int slot = slotBegin; slot < slotEnd; slot++) {
    double x[3];
    if (sequence->slotParticle[slot] != CT_NULL) {
      treeLocal(tree, slot, x);
      add(sum, x);
      particles++;
    }
    const int* slotless;
    const int slotlessCount = slotlessAt(sequence, slot, &slotless);
    if (slotlessCount > 0) {
      walkTo(&walk, sequence, sequence->slotLink[slot]);
      const Frame frame = frameOfColumns(&walk.frame);
      for (int i = 0; i < slotlessCount; i++) {
        sequenceLocal(sequence, walk.link, slotless[i], x);
        transformPoint(&frame, x, x);
        add(sum, x);
      }
      particles += slotlessCount;
    }
  }
  return particles;
}

static int sumNode(Tree* tree, const Sequence* sequence, int level, int node, int slotBegin, int slotEnd,
                   double sum[3]);

/* Adds the sum over these slots of a node's children, in the node's frame. */
static int sumChildren(Tree* tree, const Sequence* sequence, int level, int node, int slotBegin, int slotEnd,
                       double sum[3]) {
  int particles = 0;
  int count;
  const int first = treeChildren(tree, level, node, &count);
  for (int child = first; child < first + count; child++) {
    double own[3] = {0, 0, 0};
    const int inChild = sumNode(tree, sequence, level - 1, child, slotBegin, slotEnd, own);
    if (inChild > 0) {
      rotate(&tree->pose[child], own, own);
      for (int k = 0; k < 3; k++) {
        sum[k] += own[k] + inChild * tree->pose[child].m[k][3];
      }
      particles += inChild;
    }
  }
  return particles;
}

/* Slots [slotBegin, slotEnd) of a node: adds their particles' positions to sum, in the node's frame; returns how many.
 */
static int sumNode(Tree* tree, const Sequence* sequence, int level, int node, int slotBegin, int slotEnd,
                   double sum[3]) {
  int end;
  const int begin = treeSlots(tree, level, node, &end);
  if (slotEnd <= begin || end <= slotBegin) {
    return 0;
  }
  const bool whole = slotBegin <= begin && end <= slotEnd;
  double own[3] = {0, 0, 0};
  int particles = tree->particles[node];
  if (!whole || !tree->hasSum[node]) {
    const int from = begin > slotBegin ? begin : slotBegin;
    const int to = end < slotEnd ? end : slotEnd;
    particles = level == 0 ? sumSlots(tree, sequence, node, from, to, own)
                           : sumChildren(tree, sequence, level, node, from, to, own);
  }
  if (whole && !tree->hasSum[node]) {
    memcpy(tree->sum[node], own, sizeof own);
    tree->hasSum[node] = true;
  }
  add(sum, whole ? tree->sum[node] : own);
  return particles;
}

int ctTreeSum(Tree* tree, const Sequence* sequence, int linkBegin, int linkEnd, double sum[3]) {
  sum[0] = sum[1] = sum[2] = 0;
  return sumNode(tree, sequence, treeTop(tree), treeRoot(tree), sequence->slotBegin[linkBegin],
                 sequence->slotBegin[linkEnd], sum);
}

void ctTreeCompleteSums(Tree* tree, const Sequence* sequence) {
  double all[3];
  ctTreeSum(tree, sequence, 0, sequence->linkCount, all);
}
