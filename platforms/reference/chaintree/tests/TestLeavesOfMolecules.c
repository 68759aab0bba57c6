/* A molecule of half a leaf or more shares no leaf with others, so that no leaf reaches from one molecule to another.
 */
#include "check.h"

enum { CHAINS = 40, MOST_PARTICLES = CHAINS * 48, OWNS_LEAVES = CT_LEAF_WIDTH / 2 };

/* Chains of 1 to 48 beads, beside a wall of fixed beads or without. */
typedef struct Scene {
  int particleCount;
  int linkCount;
  int chainOf[MOST_PARTICLES]; /* -1: in the wall */
  int sizeOf[CHAINS];
} Scene;

static ctChainTree* makeScene(Scene* scene, int wall) {
  static double positions[3 * MOST_PARTICLES];
  static double radii[MOST_PARTICLES];
  static int links[MOST_PARTICLES];
  static int parents[MOST_PARTICLES];
  static uint8_t joints[MOST_PARTICLES];
  static int torsions[MOST_PARTICLES][4];
  memset(scene, 0, sizeof *scene);
  for (int chain = wall > 0 ? -1 : 0; chain < CHAINS; chain++) {
    const int size = chain < 0 ? wall : 1 + chain * 29 % 48;
    for (int i = 0; i < size; i++) {
      const int particle = scene->particleCount++;
      const int link = chain < 0 && i > 0 ? 0 : scene->linkCount++;
      positions[3 * particle] = i;
      positions[3 * particle + 1] = chain;
      positions[3 * particle + 2] = chain * chain % 7;
      radii[particle] = i % 5 == 4 ? 0 : 0.1; /* some without a slot */
      scene->chainOf[particle] = chain;
      links[particle] = link;
      parents[link] = chain >= 0 && i > 0 ? link - 1 : CT_NULL;
      joints[link] = chain < 0 ? ctFixedJoint : i == 0 ? ctFreeJoint : ctBallJoint;
      torsions[link][1] = particle - (i > 0);
    }
    if (chain >= 0) {
      scene->sizeOf[chain] = size;
    }
  }
  const ctDefinition definition = {.particleCount = scene->particleCount,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = scene->linkCount,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = torsions};
  return checkedCreate(&definition);
}

static void testScene(int wall) {
  Scene scene;
  ctChainTree* tree = makeScene(&scene, wall);
  const int leaves = ctGetLeafCount(tree);
  int* particles = malloc((size_t)leaves * CT_LEAF_WIDTH * sizeof(int));
  ctGetLeafParticles(tree, particles);
  int seen = 0;
  for (int leaf = 0; leaf < leaves; leaf++) {
    const int* own = particles + leaf * CT_LEAF_WIDTH;
    for (int i = 0; i < CT_LEAF_WIDTH; i++) {
      seen += own[i] != CT_NULL;
      for (int j = 0; j < i && own[i] != CT_NULL; j++) {
        const int a = own[j] == CT_NULL ? -1 : scene.chainOf[own[j]];
        const int b = scene.chainOf[own[i]];
        const bool mayShare = (a < 0 || scene.sizeOf[a] < OWNS_LEAVES) && (b < 0 || scene.sizeOf[b] < OWNS_LEAVES);
        CHECK(own[j] == CT_NULL || a == b || mayShare);
      }
    }
  }
  int modelled = 0;
  for (int chain = 0; chain < CHAINS; chain++) {
    modelled += scene.sizeOf[chain] - scene.sizeOf[chain] / 5;
  }
  CHECK(seen == modelled + wall - wall / 5);
  CHECK(ctValidate(tree));
  free(particles);
  ctDestroy(tree);
}

/* Accepted trials place only leaves that they move: positions and boxes of the others hold, up to rounding. */
static void testPositionsFollow(void) {
  Scene scene;
  ctChainTree* tree = makeScene(&scene, 0);
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* positions;
  for (int trial = 0; trial < 400; trial++) {
    ctChange change = {.link = trial * 37 % scene.linkCount};
    for (int d = 0; d < 3; d++) {
      change.rotation[d] = 0.5 * sin(7 * trial + d);
    }
    CHECK(ctPropose(tree, 1, &change) == ctSuccess);
    CHECK(ctGetChangedLeafPairs(tree, 1, &count, &pairs, &positions, NULL) == ctSuccess);
    if (trial % 3 > 0) {
      CHECK(ctAccept(tree, NULL) == ctSuccess);
      CHECK(ctValidate(tree));
    }
  }
  ctDestroy(tree);
}

int main(void) {
  testPositionsFollow();
  testScene(0);
  testScene(1);
  testScene(37);
  return checkResult();
}
