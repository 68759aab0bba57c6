/* The ChainTree of 2002, with a volume to be chosen. Each time that binarytrees.c includes this is one contestant;
 * before, it defines
 *
 *   TREE              what its names end with
 *   NAME, IDEA        of the contestant
 *   Volume            a type
 *   VOLUME(what)      what its functions are called; `what` is
 *                       OfSphere(double radius)   a volume around a sphere at the origin
 *                       OfPair(a, b, motion)      one around a and b, b moved by a rigid motion
 *                       sOverlap(a, b, motion)    whether a and b, moved, overlap
 *   volumeOfPair      if it likes, what to take instead of OfPair
 *
 * and, if not 0,
 *
 *   SHRINK_DEPTH      of boxes, how many levels below a node they are fitted to
 *   SELVES_FIRST      1: both children of a node are tested against themselves before they are against each other,
 *                     since clashes are most likely near the joints. 0: in the order of the paper, which tests
 *                     (E, E), (E, F'), (F', F')
 *   SKIPS_RIGID       1: two nodes of one rigid piece are not compared. 0: as published, only a node is not compared
 *                     with itself if it has not changed
 *   PARTICLE_VOLUMES  1: two particles are compared as volumes before they are as particles; 2: as volumes only
 *
 * A node of level l stands for 2^l particles in a row. Its frame is that of its first particle: the origin is there,
 * and the axes turn with the particle's link. */

#define volumeOfSphere VOLUME(OfSphere)
#define volumesOverlap VOLUME(sOverlap)
#ifndef volumeOfPair
#define volumeOfPair VOLUME(OfPair)
#endif

#define OWN(name) CONTESTANT_JOIN(name, TREE)
#define Node OWN(Node)
#define SavedNode OWN(SavedNode)
#define BinaryTree OWN(BinaryTree)
#define Extents OWN(Extents)
#define treeDestroy OWN(treeDestroy)
#define widen OWN(widen)
#define shrink OWN(shrink)
#define fitVolume OWN(fitVolume)
#define composeShortcut OWN(composeShortcut)
#define build OWN(build)
#define treeMake OWN(treeMake)
#define save OWN(save)
#define relative OWN(relative)
#define turnJoints OWN(turnJoints)
#define updateLevel OWN(updateLevel)
#define change OWN(change)
#define undo OWN(undo)
#define bodyOfNode OWN(bodyOfNode)
#define particlesClash OWN(particlesClash)
#define nodesClash OWN(nodesClash)
#define nodeClashesWithItself OWN(nodeClashesWithItself)
#define treeTest OWN(treeTest)
#define treeTestAll OWN(treeTestAll)
#define treeAccept OWN(treeAccept)
#define treeReject OWN(treeReject)
#define treeCounts OWN(treeCounts)
#define treePositions OWN(treePositions)

typedef struct Node {
  Rigid shortcut; /* from the frame of the next node of the level to that of this one (section 2.1) */
  Volume volume;  /* in the frame of the node (section 2.2) */
} Node;

/* What a node was before the trial. */
typedef struct SavedNode {
  int index;
  Node node;
} SavedNode;

typedef struct BinaryTree {
  const Scene* scene;
  int levelCount;
  int levelSizes[MOST_LEVELS];
  Node* levels[MOST_LEVELS]; /* within `nodes` */
  Node* nodes;
  double (*axes)[2][3]; /* of each torsion, two points in the frame of the first particle that it turns */
  Bodies bodies;        /* of the trial */
  bool testsAll;        /* without a trial: whatever has changed */
  int savedCount;
  SavedNode* saved;
  Counts counts;
} BinaryTree;

/* ---- Making ---- */

static void treeDestroy(void* self) {
  BinaryTree* tree = self;
  if (tree != NULL) {
    free(tree->nodes);
    free(tree->axes);
    free(tree->saved);
    free(tree);
  }
}

#if SHRINK_DEPTH
/* How far a box has to reach along its axes. */
typedef struct Extents {
  const double (*axes)[3];
  double low[3];
  double high[3];
} Extents;

/* Makes extents hold what is below a node, or at least the boxes some levels below it (section 6.1). What a box shows
 * to lie within them is not looked at; `motion` is from the frame of the node to that of the axes. */
static void widen(const BinaryTree* tree, int level, int index, int depth, const Rigid* motion, Extents* extents) {
  const Obb* box = &tree->levels[level][index].volume;
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
  Obb* box = &tree->levels[level][index].volume;
  const Obb loose = *box;
  Extents extents = {loose.axes, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  const Rigid here = rigidIdentity();
  widen(tree, level, index, SHRINK_DEPTH, &here, &extents);
  obbSetExtents(box, extents.low, extents.high);
}
#endif

/* From the volumes below; a node may have a single child. */
static void fitVolume(BinaryTree* tree, int level, int index) {
  const Node* children = &tree->levels[level - 1][2 * index];
  Volume* volume = &tree->levels[level][index].volume;
  if (2 * index + 1 == tree->levelSizes[level - 1]) {
    *volume = children[0].volume;
    return;
  }
  *volume = volumeOfPair(&children[0].volume, &children[1].volume, &children[0].shortcut);
#if SHRINK_DEPTH
  shrink(tree, level, index);
#endif
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
    leaf->volume = volumeOfSphere(scene->spheres[i].radius);
    leaf->shortcut = rigidIdentity();
    if (i + 1 < scene->particleCount) {
      subtract(scene->spheres[i + 1].x, scene->spheres[i].x, leaf->shortcut.t);
    }
  }
  for (int level = 1; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSizes[level]; i++) {
      composeShortcut(tree, level, i);
      fitVolume(tree, level, i);
    }
  }
  for (int t = 0; t < scene->torsionCount; t++) {
    const Torsion* torsion = &scene->torsions[t];
    for (int end = 0; end < 2; end++) {
      subtract(scene->spheres[torsion->axis[end]].x, scene->spheres[torsion->first].x, tree->axes[t][end]);
    }
  }
}

static void* treeMake(const Scene* scene) {
  BinaryTree* tree = calloc(1, sizeof *tree);
  if (tree == NULL) {
    return NULL;
  }
  tree->scene = scene;
  int nodes = 0;
  for (int size = scene->particleCount;; size = (size + 1) / 2) {
    tree->levelSizes[tree->levelCount++] = size;
    nodes += size;
    if (size <= 1) {
      break;
    }
  }
  tree->nodes = calloc((size_t)nodes, sizeof(Node));
  tree->axes = calloc((size_t)scene->torsionCount + 1, sizeof *tree->axes);
  tree->saved = calloc((size_t)tree->levelCount * 4 * MOST_TURNS, sizeof(SavedNode));
  if (tree->nodes == NULL || tree->axes == NULL || tree->saved == NULL) {
    treeDestroy(tree);
    return NULL;
  }
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
    tree->counts.updates++;
    composeShortcut(tree, level, index);
    const int nodeFirst = index << level;
    const int nodeLast = nodeFirst + (1 << level);
    bool holdsChange = false;
    for (int s = 1; s < tree->bodies.segmentCount; s++) {
      const int cut = tree->bodies.segments[s].first;
      holdsChange = holdsChange || (cut > nodeFirst && cut < nodeLast);
    }
    if (holdsChange) {
      fitVolume(tree, level, index);
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

/* Backwards, since a joint may have been saved twice. */
static void undo(BinaryTree* tree) {
  for (int i = tree->savedCount - 1; i >= 0; i--) {
    tree->nodes[tree->saved[i].index] = tree->saved[i].node;
  }
}

/* ---- Testing (section 2.3) ---- */

/* The body that a node lies in, or SEVERAL_BODIES. */
static int bodyOfNode(const BinaryTree* tree, int level, int index) {
  if (tree->testsAll) {
    return SEVERAL_BODIES;
  }
  const Segment* segment = tree->bodies.segments;
  while (segment->last <= index << level) {
    segment++;
  }
  const int last = (index + 1) << level;
  return last <= segment->last || segment->last == tree->scene->particleCount ? segment->body : SEVERAL_BODIES;
}

static bool particlesClash(BinaryTree* tree, int i, int j, const Rigid* motion) {
#if PARTICLE_VOLUMES
  tree->counts.volumeTests++;
  if (!volumesOverlap(&tree->levels[0][i].volume, &tree->levels[0][j].volume, motion)) {
    return false;
  }
#endif
#if PARTICLE_VOLUMES == 2
  return !sceneExcludes(tree->scene, i, j);
#else
  const Sphere* spheres = tree->scene->spheres;
  const double sum = spheres[i].radius + spheres[j].radius;
  tree->counts.particleTests++;
  return dot(motion->t, motion->t) < sum * sum && !sceneExcludes(tree->scene, i, j);
#endif
}

/* Whether particles below node a clash with some below node b, behind it; `motion` is from the frame of b to that of
 * a. */
static bool nodesClash(BinaryTree* tree, int level, int a, int b, const Rigid* motion) {
  if (level == 0) {
    return particlesClash(tree, a, b, motion);
  }
#if SKIPS_RIGID
  const int body = bodyOfNode(tree, level, a);
  if (body != SEVERAL_BODIES && body == bodyOfNode(tree, level, b)) {
    return false;
  }
#endif
  tree->counts.volumeTests++;
  if (!volumesOverlap(&tree->levels[level][a].volume, &tree->levels[level][b].volume, motion)) {
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
#if SELVES_FIRST
  return nodeClashesWithItself(tree, level - 1, first) || nodeClashesWithItself(tree, level - 1, first + 1) ||
         nodesClash(tree, level - 1, first, first + 1, motion);
#else
  return nodeClashesWithItself(tree, level - 1, first) || nodesClash(tree, level - 1, first, first + 1, motion) ||
         nodeClashesWithItself(tree, level - 1, first + 1);
#endif
}

/* ---- The contestant ---- */

static int treeTest(void* self, int count, const Turn* turns) {
  BinaryTree* tree = self;
  bodiesCut(tree->scene, count, turns, &tree->bodies);
  change(tree);
  return nodeClashesWithItself(tree, tree->levelCount - 1, 0);
}

static int treeTestAll(void* self) {
  BinaryTree* tree = self;
  tree->testsAll = true;
  const bool clash = nodeClashesWithItself(tree, tree->levelCount - 1, 0);
  tree->testsAll = false;
  return clash;
}

static bool treeAccept(void* self) {
  (void)self;
  return true;
}

static void treeReject(void* self) {
  undo(self);
}

static Counts treeCounts(const void* self) {
  return ((const BinaryTree*)self)->counts;
}

/* From particle to particle, by the shortcuts of level 0. */
static void treePositions(void* self, double* coordinates) {
  const BinaryTree* tree = self;
  Rigid frame = rigidIdentity();
  for (int i = 0; i < tree->scene->particleCount; i++) {
    memcpy(coordinates + 3 * i, frame.t, sizeof frame.t);
    frame = rigidCompose(&frame, &tree->levels[0][i].shortcut);
  }
}

const Contestant CONTESTANT(OWN(contestant)) = {.name = NAME,
                                                .idea = IDEA,
                                                .make = treeMake,
                                                .destroy = treeDestroy,
                                                .test = treeTest,
                                                .accept = treeAccept,
                                                .reject = treeReject,
                                                .testAll = treeTestAll,
                                                .counts = treeCounts,
                                                .positions = treePositions};

#undef TREE
#undef NAME
#undef IDEA
#undef Volume
#undef VOLUME
#undef volumeOfSphere
#undef volumeOfPair
#undef volumesOverlap
#undef SHRINK_DEPTH
#undef SELVES_FIRST
#undef SKIPS_RIGID
#undef PARTICLE_VOLUMES
