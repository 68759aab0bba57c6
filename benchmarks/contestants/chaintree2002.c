/* The ChainTree of 2002: as published, and with what makes it better.
 *
 * A node of level l stands for 2^l particles in a row. Its frame is that of its first particle: the origin is there,
 * and the axes turn with the particle's link. */
#include <string.h>

#include "bodies.h"
#include "obb.h"

enum { MOST_LEVELS = 32, SEVERAL_BODIES = -1 };

/* In what trees differ. */
typedef struct Variant {
  Obb (*fit)(const Obb* a, const Obb* b, const Rigid* motion); /* a box around two, b moved */
  int shrinkDepth;                                             /* boxes are fitted to those some levels below; 0: not */
  bool
      selvesFirst; /* both children of a node are tested against themselves before they are against each other, since */
                   /* clashes are most likely near the joints; else in the order of the paper's section 2.3 */
  bool skipsRigid; /* two nodes of one rigid piece are not compared; else, as published, only a node with itself */
} Variant;

typedef struct Node {
  Rigid shortcut; /* from the frame of the next node of the level to that of this one (section 2.1) */
  Obb box;        /* in the frame of the node (section 2.2) */
} Node;

/* What a node was before the trial. */
typedef struct SavedNode {
  int index;
  Node node;
} SavedNode;

typedef struct BinaryTree {
  const Scene* scene;
  const Variant* variant;
  int levelCount;
  int levelSizes[MOST_LEVELS];
  Node* levels[MOST_LEVELS]; /* within `nodes` */
  Node* nodes;
  double (*axes)[2][3]; /* of each torsion, two points in the frame of the first particle that it turns */
  Bodies bodies;        /* of the trial */
  int savedCount;
  SavedNode* saved;
  Counts counts;
} BinaryTree;

static void sortJoints(int* joints, int count) {
  for (int i = 1; i < count; i++) {
    const int joint = joints[i];
    int k = i;
    for (; k > 0 && joints[k - 1] > joint; k--) {
      joints[k] = joints[k - 1];
    }
    joints[k] = joint;
  }
}

/* ---- Making ---- */

static void treeDestroy(void* self) {
  BinaryTree* tree = self;
  free(tree->nodes);
  free(tree->axes);
  free(tree->saved);
  free(tree);
}

/* How far a box has to reach along its axes. */
typedef struct Extents {
  const double (*axes)[3];
  double low[3];
  double high[3];
} Extents;

/* Makes extents hold what is below a node, or at least the boxes some levels below it (section 6.1). What a box shows
 * to lie within them is not looked at; `motion` is from the frame of the node to that of the axes. */
static void widen(const BinaryTree* tree, int level, int index, int depth, const Rigid* motion, Extents* extents) {
  const Obb* box = &tree->levels[level][index].box;
  double low[3];
  double high[3];
  bool within = true;
  for (int k = 0; k < 3; k++) {
    double u[3];
    rigidRotateBack(motion, extents->axes[k], u);
    const double at = dot(extents->axes[k], motion->t) + dot(u, box->centre);
    const double reach = level == 0 ? box->half[0] : obbReach(box, u);
    low[k] = at - reach;
    high[k] = at + reach;
    within = within && low[k] >= extents->low[k] && high[k] <= extents->high[k];
  }
  if (within) {
    return;
  }
  if (level == 0 || depth == 0) {
    for (int k = 0; k < 3; k++) {
      extents->low[k] = fmin(extents->low[k], low[k]);
      extents->high[k] = fmax(extents->high[k], high[k]);
    }
    return;
  }
  widen(tree, level - 1, 2 * index, depth - 1, motion, extents);
  if (2 * index + 1 < tree->levelSizes[level - 1]) {
    const Rigid next = rigidCompose(motion, &tree->levels[level - 1][2 * index].shortcut);
    widen(tree, level - 1, 2 * index + 1, depth - 1, &next, extents);
  }
}

static void shrink(BinaryTree* tree, int level, int index) {
  Obb* box = &tree->levels[level][index].box;
  const Obb loose = *box;
  Extents extents = {loose.axes, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  const Rigid here = rigidIdentity();
  widen(tree, level, index, tree->variant->shrinkDepth, &here, &extents);
  obbSetExtents(box, extents.low, extents.high);
}

/* From the boxes below; a node may have a single child. */
static void fitBox(BinaryTree* tree, int level, int index) {
  const Node* children = &tree->levels[level - 1][2 * index];
  Obb* box = &tree->levels[level][index].box;
  if (2 * index + 1 == tree->levelSizes[level - 1]) {
    *box = children[0].box;
    return;
  }
  *box = tree->variant->fit(&children[0].box, &children[1].box, &children[0].shortcut);
  if (tree->variant->shrinkDepth > 0) {
    shrink(tree, level, index);
  }
}

/* The last node of a level has no next one, and no shortcut. */
static void composeShortcut(BinaryTree* tree, int level, int index) {
  const Node* children = &tree->levels[level - 1][2 * index];
  if (index + 1 < tree->levelSizes[level]) {
    tree->levels[level][index].shortcut = rigidCompose(&children[0].shortcut, &children[1].shortcut);
  }
}

static void build(BinaryTree* tree) {
  const Scene* scene = tree->scene;
  for (int i = 0; i < scene->particleCount; i++) {
    Node* leaf = &tree->levels[0][i];
    leaf->box = obbOfSphere(scene->spheres[i].radius);
    leaf->shortcut = rigidIdentity();
    if (i + 1 < scene->particleCount) {
      subtract(scene->spheres[i + 1].x, scene->spheres[i].x, leaf->shortcut.t);
    }
  }
  for (int level = 1; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSizes[level]; i++) {
      composeShortcut(tree, level, i);
      fitBox(tree, level, i);
    }
  }
  for (int t = 0; t < scene->torsionCount; t++) {
    const Torsion* torsion = &scene->torsions[t];
    for (int end = 0; end < 2; end++) {
      subtract(scene->spheres[torsion->axis[end]].x, scene->spheres[torsion->first].x, tree->axes[t][end]);
    }
  }
}

static void* treeMake(const Scene* scene, const Variant* variant) {
  BinaryTree* tree = allocate(1, sizeof *tree);
  tree->scene = scene;
  tree->variant = variant;
  int nodes = 0;
  for (int size = scene->particleCount;; size = (size + 1) / 2) {
    tree->levelSizes[tree->levelCount++] = size;
    nodes += size;
    if (size <= 1) {
      break;
    }
  }
  tree->nodes = allocate(nodes, sizeof(Node));
  tree->axes = allocate(scene->torsionCount, sizeof *tree->axes);
  tree->saved = allocate(tree->levelCount * 4 * MOST_TURNS, sizeof(SavedNode));
  Node* level = tree->nodes;
  for (int l = 0; l < tree->levelCount; l++) {
    tree->levels[l] = level;
    level += tree->levelSizes[l];
  }
  build(tree);
  return tree;
}

/* ---- Changing, level by level (sections 2.1 and 2.2) ---- */

static void save(BinaryTree* tree, const Node* node) {
  tree->saved[tree->savedCount++] = (SavedNode){(int)(node - tree->nodes), *node};
}

/* From the frame of particle `last` to that of `first`, before it, by shortcuts. */
static Rigid relative(const BinaryTree* tree, int first, int last) {
  Rigid transform = rigidIdentity();
  while (first < last) {
    int level = 0;
    while (first % (2 << level) == 0 && first + (2 << level) <= last) {
      level++;
    }
    transform = rigidCompose(&transform, &tree->levels[level][first >> level].shortcut);
    first += 1 << level;
  }
  return transform;
}

/* Joint i is between particles i and i + 1. */
static void turnJoints(BinaryTree* tree, const Turn* turn, int* joints, int* jointCount) {
  const Torsion* torsion = &tree->scene->torsions[turn->torsion];
  const double(*axis)[3] = (const double(*)[3])tree->axes[turn->torsion];
  Node* start = &tree->levels[0][torsion->first - 1];
  const Rigid rotation = rigidTurn(axis[0], axis[1], turn->angle);
  joints[(*jointCount)++] = torsion->first - 1;
  save(tree, start);
  start->shortcut = rigidCompose(&start->shortcut, &rotation);
  if (torsion->last == tree->scene->particleCount) {
    return;
  }
  /* What follows the interval keeps its place: the inverse of the turn, seen from the last particle that turns. */
  Node* end = &tree->levels[0][torsion->last - 1];
  const Rigid across = relative(tree, torsion->first, torsion->last - 1);
  const Rigid back = rigidTurn(axis[0], axis[1], -turn->angle);
  const Rigid fromLast = rigidInvert(&across);
  const Rigid turned = rigidCompose(&back, &across);
  const Rigid correction = rigidCompose(&fromLast, &turned);
  joints[(*jointCount)++] = torsion->last - 1;
  save(tree, end);
  end->shortcut = rigidCompose(&correction, &end->shortcut);
}

/* `joints` are the shortcuts of the level below that have changed, sorted; they become those of this one. A node whose
 * last child's shortcut has changed, and no other, holds no change. */
static int updateLevel(BinaryTree* tree, int level, int* joints, int count) {
  int updated = 0;
  for (int i = 0; i < count;) {
    const int index = joints[i] / 2;
    Node* node = &tree->levels[level][index];
    save(tree, node);
    composeShortcut(tree, level, index);
    const int nodeFirst = index << level;
    const int nodeLast = nodeFirst + (1 << level);
    bool holdsChange = false;
    for (int s = 1; s < tree->bodies.segmentCount; s++) {
      const int cut = tree->bodies.segments[s].first;
      holdsChange = holdsChange || (cut > nodeFirst && cut < nodeLast);
    }
    if (holdsChange) {
      fitBox(tree, level, index);
    }
    while (i < count && joints[i] / 2 == index) {
      i++;
    }
    joints[updated++] = index;
  }
  return updated;
}

static void change(BinaryTree* tree) {
  int joints[2 * MOST_TURNS];
  int count = 0;
  tree->savedCount = 0;
  /* Outer turns come first, so that no shortcut across an interval has changed when it is needed. */
  for (int body = 1; body < tree->bodies.bodyCount; body++) {
    turnJoints(tree, &tree->bodies.turns[body], joints, &count);
  }
  sortJoints(joints, count);
  for (int level = 1; level < tree->levelCount; level++) {
    count = updateLevel(tree, level, joints, count);
  }
}

/* ---- Testing (section 2.3) ---- */

/* The body that a node lies in, or SEVERAL_BODIES. */
static int bodyOfNode(const BinaryTree* tree, int level, int index) {
  const Segment* segment = tree->bodies.segments;
  while (segment->last <= index << level) {
    segment++;
  }
  const int last = (index + 1) << level;
  return last <= segment->last || segment->last == tree->scene->particleCount ? segment->body : SEVERAL_BODIES;
}

static bool particlesClash(BinaryTree* tree, int i, int j, const Rigid* motion) {
  const Sphere* spheres = tree->scene->spheres;
  const double sum = spheres[i].radius + spheres[j].radius;
  tree->counts.particleTests++;
  return dot(motion->t, motion->t) < sum * sum && !sceneExcludes(tree->scene, i, j);
}

/* Whether particles below node a clash with some below node b, behind it; `motion` is from the frame of b to that of
 * a. */
static bool nodesClash(BinaryTree* tree, int level, int a, int b, const Rigid* motion) {
  if (level == 0) {
    return particlesClash(tree, a, b, motion);
  }
  const int body = tree->variant->skipsRigid ? bodyOfNode(tree, level, a) : SEVERAL_BODIES;
  if (body != SEVERAL_BODIES && body == bodyOfNode(tree, level, b)) {
    return false;
  }
  tree->counts.volumeTests++;
  if (!obbsOverlap(&tree->levels[level][a].box, &tree->levels[level][b].box, motion)) {
    return false;
  }
  const Node* below = tree->levels[level - 1];
  const bool bHasTwo = 2 * b + 1 < tree->levelSizes[level - 1];
  const Rigid back = rigidInvert(&below[2 * a].shortcut);
  const Rigid fromSecond = rigidCompose(&back, motion); /* child of a */
  if (nodesClash(tree, level - 1, 2 * a + 1, 2 * b, &fromSecond) || nodesClash(tree, level - 1, 2 * a, 2 * b, motion)) {
    return true;
  }
  if (!bHasTwo) {
    return false;
  }
  const Rigid toSecond = rigidCompose(motion, &below[2 * b].shortcut); /* child of b */
  const Rigid both = rigidCompose(&fromSecond, &below[2 * b].shortcut);
  return nodesClash(tree, level - 1, 2 * a + 1, 2 * b + 1, &both) ||
         nodesClash(tree, level - 1, 2 * a, 2 * b + 1, &toSecond);
}

static bool nodeClashesWithItself(BinaryTree* tree, int level, int index) {
  if (level == 0 || bodyOfNode(tree, level, index) != SEVERAL_BODIES) {
    return false;
  }
  const int first = 2 * index;
  const Rigid* motion = &tree->levels[level - 1][first].shortcut;
  if (first + 1 == tree->levelSizes[level - 1]) {
    return nodeClashesWithItself(tree, level - 1, first);
  }
  if (tree->variant->selvesFirst) {
    return nodeClashesWithItself(tree, level - 1, first) || nodeClashesWithItself(tree, level - 1, first + 1) ||
           nodesClash(tree, level - 1, first, first + 1, motion);
  }
  return nodeClashesWithItself(tree, level - 1, first) || nodesClash(tree, level - 1, first, first + 1, motion) ||
         nodeClashesWithItself(tree, level - 1, first + 1);
}

/* ---- The contestants ---- */

static bool treeTest(void* self, int count, const Turn* turns) {
  BinaryTree* tree = self;
  bodiesCut(tree->scene, count, turns, &tree->bodies);
  change(tree);
  return nodeClashesWithItself(tree, tree->levelCount - 1, 0);
}

static void treeAccept(void* self) {
  (void)self;
}

/* Backwards, since a joint may have been saved twice. */
static void treeReject(void* self) {
  BinaryTree* tree = self;
  for (int i = tree->savedCount - 1; i >= 0; i--) {
    tree->nodes[tree->saved[i].index] = tree->saved[i].node;
  }
}

static Counts treeCounts(const void* self) {
  return ((const BinaryTree*)self)->counts;
}

static void* makePublished(const Scene* scene) {
  static const Variant published = {.fit = obbOfPair};
  return treeMake(scene, &published);
}

/* Boxes are fitted to those two levels below, along the best of three sets of axes. */
static void* makeImproved(const Scene* scene) {
  static const Variant improved = {.fit = obbByCandidates, .shrinkDepth = 2, .selvesFirst = true, .skipsRigid = true};
  return treeMake(scene, &improved);
}

#define CHAIN_TREE(itsName, itsIdea, itsMake)                                                                          \
  {                                                                                                                    \
    .name = itsName, .idea = itsIdea, .make = itsMake, .destroy = treeDestroy, .test = treeTest, .accept = treeAccept, \
    .reject = treeReject, .counts = treeCounts                                                                         \
  }

const Contestant CONTESTANT(contestantPublished) = CHAIN_TREE("published", "the ChainTree of 2002", makePublished);
const Contestant CONTESTANT(contestantImproved) = CHAIN_TREE(
    "improved", "the ChainTree of 2002 with better boxes, and without tests within a rigid piece", makeImproved);
