/* Trials of side chains in large scenes begin with the parents of the nodes over leaves, whose bounds lag behind side
 * chains that have turned: what sticks out of them is found all the same. */
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

static ctChainTree* makeTree(void) {
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
  addRod(&scene, 0, FIRST - 47, -1);
  addRod(&scene, 1, FIRST + 2, 1);
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

/* Asks for what lags, which changes no state. */
static void catchUp(ctChainTree* tree) {
  double centroid[3];
  CHECK_SUCCESS(ctGetCentroid(tree, 0, centroid));
  CHECK(tree->staleTree.laggingCount == 0);
}

static void testFirstNodes(int mostFirstNodes) {
  ctChainTree* tree = makeTree();
  tree->traversal.mostFirstNodes = mostFirstNodes;
  CHECK(tree->traversal.parents != NULL && tree->staleTree.levelSize[1] == 3);
  for (int turn = 0; turn < 2; turn++) {
    const int rod = turn; /* that sticks out */
    CHECK(!clashes(tree, 1 - rod, pi));
    CHECK(!clashes(tree, rod, pi));
    CHECK_SUCCESS(ctCommit(tree, NULL));
    CHECK(tree->staleTree.laggingCount == 1 && tree->staleTree.outside > 1);
    CHECK(clashes(tree, 1 - rod, pi));
    CHECK(!clashes(tree, 1 - rod, 0.5 * pi));
    catchUp(tree); /* parents are those before */
    CHECK(clashes(tree, 1 - rod, pi));
    CHECK(!clashes(tree, rod, pi));
    CHECK_SUCCESS(ctCommit(tree, NULL));
    CHECK(!clashes(tree, 1 - rod, pi));
    catchUp(tree);
  }
  ctDestroy(tree);
}

int main(void) {
  testFirstNodes(MOST_FIRST_NODES);
  testFirstNodes(1);
  return checkResult();
}
