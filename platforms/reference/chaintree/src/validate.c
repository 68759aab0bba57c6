/* For tests: compares everything that is kept with what brute force gives. */
#include <stdlib.h>
#include <string.h>

#include "descent.h"
#include "scene.h"

/* The tree's content, array by array. */
typedef struct Content {
  void* data;
  size_t size;
} Content;

enum { CONTENT_COUNT = 9 };

static void listContent(const Tree* tree, const Sequence* s, Content content[CONTENT_COUNT]) {
  const size_t nodes = (size_t)tree->nodeCount;
  const Content all[CONTENT_COUNT] = {
      {tree->shortcut, nodes * sizeof(Frame)},
      {tree->pose, nodes * sizeof(Frame)},
      {tree->bound, nodes * sizeof(Bound)},
      {tree->sum, nodes * sizeof(double[3])},
      {tree->leaf, (size_t)tree->levelBegin[1] * sizeof(Leaf)},
      {tree->members, (nodes - (size_t)tree->levelBegin[1]) * sizeof(Members)},
      {tree->stem, (size_t)s->openPathCount * sizeof(Frame)},
      {s->product, (size_t)s->productBegin[s->returnFrameCount] * sizeof(Frame)},
      {s->returnFrame, (size_t)s->returnFrameCount * sizeof(Frame)},
  };
  memcpy(content, all, sizeof all);
}

/* True if the frames in the world that count as right have the bits that the tree gives. */
static bool framesHold(const ctChainTree* scene) {
  const Tree* tree = &scene->ownTree;
  const World* world = &scene->world;
  for (int level = 0; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      const int node = tree->levelBegin[level] + i;
      const Frame frame = ctTreeFrame(tree, level, node);
      /* Compares bits: 0 and -0 differ. NOLINTNEXTLINE(bugprone-suspicious-memory-comparison) */
      if (hasWorld(world, node) && memcmp(&world->frame[world->entryOf[node]], &frame, sizeof frame) != 0) {
        return false;
      }
    }
  }
  return true;
}

/* ---- Boxes ---- */

/* True if a node's box, unless it is outdated, holds all particles below it. */
static bool boxHolds(const ctChainTree* scene, int level, int node) {
  const Tree* tree = &scene->ownTree;
  const Box* box = &scene->traversal.box[node];
  int end;
  const int begin = treeSlots(tree, level, node, &end);
  const Frame frame = ctTreeFrame(tree, level, node);
  for (int slot = begin; slot < end && box->builtFrom >= tree->contentRevision[node]; slot++) {
    if (!slotIsModelled(&scene->sequence, slot)) {
      continue;
    }
    const Frame leaf = ctTreeFrame(tree, 0, coveringNode(slot));
    double x[3];
    treeLocal(tree, slot, x);
    transformPoint(&leaf, x, x);
    const double rounding = 1e-13 * sqrt(dot(x, x)); /* as in nodeHolds */
    transformPointBack(&frame, x, x);
    for (int i = 1; i < 4; i++) {
      double along = 0;
      for (int d = 0; d < 3; d++) {
        along += (x[d] - (double)box->row[d][0]) * (double)box->row[d][i];
      }
      if (fabs(along) + slotRadius(&scene->sequence, slot) > (double)box->half[i] + rounding) {
        return false;
      }
    }
  }
  return true;
}

static bool doBoxesHold(const ctChainTree* scene) {
  const Tree* tree = &scene->ownTree;
  for (int level = 0; level < treeTop(tree); level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      if (!boxHolds(scene, level, tree->levelBegin[level] + i)) {
        return false;
      }
    }
  }
  return true;
}

/* ---- Clearances ---- */

static bool isExcluded(const Exclusions* exclusions, int slotA, int slotB) {
  const int partner = exclusionPartner(exclusions, coveringNode(slotA), coveringNode(slotB));
  return partner != CT_NULL && (exclusions->mask[partner][memberIndex(slotA)] >> memberIndex(slotB) & 1) != 0;
}

/* True if no pair of particles has less clearance than the table has for their leaves. O(N^2). */
static bool clearancesHold(ctChainTree* scene) {
  const Clearance* c = &scene->clearance;
  const Sequence* s = &scene->sequence;
  for (int i = 0; i < s->slotCount && c->isKept; i++) {
    if (!slotIsModelled(s, i)) {
      continue;
    }
    const int a = coveringNode(i);
    for (int j = (a + 1) * TREE_WIDTH; j < s->slotCount; j++) {
      const int b = coveringNode(j);
      const uint16_t least = c->least[(size_t)a * (size_t)c->stride + (size_t)b];
      if (least == 0) {
        j = (b + 1) * TREE_WIDTH - 1;
        continue;
      }
      if (!slotIsModelled(s, j) || isExcluded(&scene->exclusions, i, j)) {
        continue;
      }
      int pair[2];
      particlesOf(scene, i, j, pair);
      const double limit = ctLimitsFind(&scene->limits, pair[0], pair[1], pairTolerance(scene, i, j));
      if (limit - radiusSum(scene, i, j) + canonicalDistance(scene, i, j) + c->skipped < (double)c->unit * least) {
        return false;
      }
    }
  }
  return true;
}

/* ---- Leaves ---- */

static bool areNear(size_t count, const double* a, const double* b, double most) {
  for (size_t i = 0; i < count; i++) {
    if (!(fabs(a[i] - b[i]) <= most)) {
      return false;
    }
  }
  return true;
}

/* True if kept boxes differ by no more than this, and by the rounding of a box. Empty boxes are infinite. */
static bool areNearBoxes(size_t count, const float* a, const float* b, double most) {
  for (size_t i = 0; i < count; i++) {
    if (a[i] != b[i] && !(fabs((double)a[i] - (double)b[i]) <= most + 4e-7 * fabs((double)a[i]))) {
      return false;
    }
  }
  return true;
}

/* True if kept positions and boxes have the bits that the tree gives, or are within their bound of error. False without
 * memory. */
static bool leavesHold(ctChainTree* scene) {
  Leaves* kept = &scene->leaves;
  const Tree* tree = ctSceneTree(scene);
  Leaves made = {0};
  bool same = true;
  if (kept->state != NULL) {
    same = ctLeavesReserve(&made, tree, &scene->sequence) && (kept->boxes == NULL || ctLeavesReservePairs(&made, tree));
    if (same) {
      const size_t boxes = (size_t)(treeSuperRoot(tree) - tree->levelBegin[1]) + 1;
      ctLeavesUpdate(kept, &scene->world, &scene->sequence);
      ctLeavesUpdate(&made, &scene->world, &scene->sequence);
      const size_t leaves = (size_t)tree->levelSize[0];
      same = kept->positionError > 0
                 ? areNear(leaves * 3 * TREE_WIDTH, kept->state->x, made.state->x, kept->positionError) &&
                       (kept->boxes == NULL || areNearBoxes(boxes * 6 * TREE_WIDTH, kept->boxes->low[0],
                                                            made.boxes->low[0], kept->positionError))
                 : memcmp(kept->state, made.state, leaves * sizeof(ctLeafPositions)) == 0 &&
                       (kept->boxes == NULL || memcmp(kept->boxes, made.boxes, boxes * sizeof(AxisBoxes)) == 0);
    }
  }
  ctLeavesFree(&made);
  return same;
}

bool ctValidate(ctChainTree* tree) {
  if (tree == NULL) {
    return false;
  }
  Content content[CONTENT_COUNT];
  void* kept[CONTENT_COUNT] = {0};
  Tree* made = ctSceneTree(tree);
  ctTreeCompleteSums(made, &tree->sequence);
  const bool boxesHold = doBoxesHold(tree); /* before ctTreeRefresh makes all boxes outdated */
  listContent(made, &tree->sequence, content);
  bool same = true;
  for (int i = 0; i < CONTENT_COUNT && same; i++) {
    kept[i] = malloc(content[i].size + 1);
    same = kept[i] != NULL;
    if (same) {
      memcpy(kept[i], content[i].data, content[i].size);
    }
  }
  if (same) {
    for (int i = 0; i < CONTENT_COUNT; i++) {
      memset(content[i].data, 0, content[i].size);
    }
    ctPathsMultiply(&tree->sequence);
    ctTreeRefresh(made, &tree->sequence);
    ctTreeCompleteSums(made, &tree->sequence);
    for (int i = 0; i < CONTENT_COUNT; i++) {
      same = same && memcmp(kept[i], content[i].data, content[i].size) == 0;
      memcpy(content[i].data, kept[i], content[i].size);
    }
  }
  for (int i = 0; i < CONTENT_COUNT; i++) {
    free(kept[i]);
  }
  return same && ctTreeBoundsHold(made, &tree->sequence) && boxesHold && framesHold(tree) && clearancesHold(tree) &&
         leavesHold(tree);
}
