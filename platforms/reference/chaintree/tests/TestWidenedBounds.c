/* A side chain that turns only widens bounds, at each level up to the first that holds it: what sticks out of those
 * before is found, whichever level a trial begins with. */
#include <string.h>

/* With how many nodes trials begin is not public. */
#include "../src/scene.h"
#include "check.h"

enum {
  ROD = 8,                                 /* particles of a side chain: a straight rod beside a torsion axis */
  NODE = TREE_WIDTH * TREE_WIDTH,          /* slots of a node over leaves */
  FIRST = NODE - ROD - 1,                  /* beads of the backbone in the first one, where the world has a slot */
  BEADS = FIRST + (NODE - ROD) + NODE / 4, /* all */
  PARTICLES = BEADS + 2 * ROD,
  LINKS = BEADS + 2
};

static const double pi = 3.141592653589793;

/* A straight backbone of small beads, with two rods: one from the first node over leaves, which points away from the
 * second, and one from the second, which points away from the first. Turned around, they meet between the nodes. */
typedef struct Scene {
  double positions[PARTICLES][3];
  double radii[PARTICLES];
  int particleLinks[PARTICLES];
  int parents[LINKS];
  uint8_t joints[LINKS];
  int torsions[LINKS][4];
} Scene;

/* Hangs rod number r on a bead. */
static void addRod(Scene* scene, int r, int bead, double direction) {
  const int link = BEADS + r;
  const int first = BEADS + r * ROD;
  scene->parents[link] = bead;
  scene->joints[link] = ctTorsionJoint;
  const int torsion[4] = {bead, bead, first, first};
  memcpy(scene->torsions[link], torsion, sizeof torsion);
  for (int k = 0; k < ROD; k++) {
    const double position[3] = {0.15, scene->positions[bead][1] + 0.5 * k * direction, 0};
    memcpy(scene->positions[first + k], position, sizeof position);
    scene->radii[first + k] = 0.1;
    scene->particleLinks[first + k] = link;
  }
}

/* The rods hang on these beads. */
static ctChainTree* makeTree(int bead0, int bead1) {
  static Scene scene;
  for (int i = 0; i < BEADS; i++) {
    scene.positions[i][1] = 0.03 * (i - FIRST) - (i < FIRST ? 4.6 : 0);
    scene.radii[i] = 0.01;
    scene.particleLinks[i] = i;
    scene.parents[i] = i > 0 ? i - 1 : CT_NULL;
    scene.joints[i] = i > 0 ? ctTorsionJoint : ctFreeJoint;
    const int torsion[4] = {i - 1, i - 1, i, i};
    memcpy(scene.torsions[i], torsion, sizeof torsion);
  }
  addRod(&scene, 0, bead0, -1);
  addRod(&scene, 1, bead1, 1);
  const ctDefinition definition = {.particleCount = PARTICLES,
                                   .positions = scene.positions[0],
                                   .radii = scene.radii,
                                   .particleLinks = scene.particleLinks,
                                   .linkCount = LINKS,
                                   .linkParents = scene.parents,
                                   .linkJoints = scene.joints,
                                   .linkTorsions = (const int(*)[4])scene.torsions};
  ctChainTree* tree;
  CHECK_SUCCESS(ctCreate(&definition, &tree, NULL, 0));
  return tree;
}

/* Tests a turn of a rod. */
static bool clashes(ctChainTree* tree, int rod, double angle) {
  const ctChange change = {.link = BEADS + rod, .angle = angle};
  bool clash;
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  return clash;
}

/* Makes loose bounds tight, which changes no state. */
static void catchUp(ctChainTree* tree) {
  double centroid[3];
  CHECK_SUCCESS(ctGetCentroid(tree, 0, centroid));
  CHECK(tree->ownTree.looseCount == 0);
}

static void testFirstNodes(int mostFirstNodes, int mostUnaskedNodes, bool soonBoxed) {
  ctChainTree* tree = makeTree(FIRST - 47, FIRST + 2);
  if (soonBoxed) { /* boxes of leaves, but only of nodes that are near */
    tree->traversal.testsPerLeaf = 0;
    tree->traversal.mostBoxedNodes = 0;
  }
  tree->traversal.mostFirstNodes = mostFirstNodes;
  tree->traversal.mostUnaskedNodes = mostUnaskedNodes;
  CHECK(tree->ownTree.levelSize[1] == 3);
  for (int turn = 0; turn < 2; turn++) {
    const int rod = turn; /* that sticks out */
    CHECK(!clashes(tree, 1 - rod, pi));
    CHECK(!clashes(tree, rod, pi));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    CHECK(tree->ownTree.looseCount > 0);
    CHECK(clashes(tree, 1 - rod, pi));
    CHECK(!clashes(tree, 1 - rod, 0.5 * pi));
    catchUp(tree);
    CHECK(clashes(tree, 1 - rod, pi));
    CHECK(!clashes(tree, rod, pi));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    CHECK(!clashes(tree, 1 - rod, pi));
    catchUp(tree);
  }
  CHECK((tree->traversal.testsToBoxes == 0) == soonBoxed);
  ctDestroy(tree);
}

/* True if the member of a node in the world holds all particles below it. */
static bool holdsInWorld(const ctChainTree* tree, const Block* world, int level, int node, int k) {
  const Tree* t = &tree->ownTree;
  int childCount;
  const int child = treeChildren(t, level, node, &childCount) + k;
  int end;
  for (int slot = treeSlots(t, level - 1, child, &end); slot < end; slot++) {
    const Frame leaf = ctTreeFrame(t, 0, slot / TREE_WIDTH);
    const double centre[3] = {world->x[k], world->y[k], world->z[k]};
    double x[3];
    treeLocal(t, slot, x);
    transformPoint(&leaf, x, x);
    const double sum = sqrt(squaredDistance(x, centre)) + slotRadius(&tree->sequence, slot);
    if (slotIsModelled(&tree->sequence, slot) && sum > (double)world->r[k] + 1e-4) {
      return false;
    }
  }
  return true;
}

/* True if members in the world that count as up to date hold what is below them. */
static bool worldHolds(const ctChainTree* tree) {
  const Tree* t = &tree->ownTree;
  const World* world = &tree->world;
  for (int level = 1; level < t->levelCount; level++) {
    for (int i = 0; i < t->levelSize[level]; i++) {
      const int node = t->levelBegin[level] + i;
      const Revision since = world->builtFrom[node];
      int count;
      treeChildren(t, level, node, &count);
      for (int k = 0; k < count && !movedSince(&t->changes, since) && t->contentRevision[node] <= since; k++) {
        if (!holdsInWorld(tree, &world->members[world->entryOf[node]], level, node, k)) {
          return false;
        }
      }
    }
  }
  return true;
}

/* Bounds are widened and made tight again, in any order. Stored bounds must always contain the turned side branches. */
static void testWorld(void) {
  ctChainTree* tree = makeTree(FIRST - 47, FIRST - 46); /* in one leaf, so that each has room to turn */
  uint32_t state = 1;
  for (int step = 0; step < 5000; step++) {
    state = state * 1664525u + 1013904223u;
    const unsigned drawn = state >> 16;
    clashes(tree, (int)(drawn % 2), 0.0001 * (drawn % 62832));
    if (drawn / 2 % 2 > 0) {
      CHECK_SUCCESS(ctAccept(tree, NULL));
    }
    if (drawn / 8 % 2 == 0) {
      catchUp(tree);
    }
    CHECK(worldHolds(tree));
  }
  ctDestroy(tree);
}

int main(void) {
  testWorld();
  testFirstNodes(MOST_FIRST_NODES, MOST_UNASKED_NODES, false);
  testFirstNodes(MOST_FIRST_NODES, 1, false);
  testFirstNodes(1, MOST_UNASKED_NODES, false);
  testFirstNodes(1, MOST_UNASKED_NODES, true);
  return checkResult();
}
