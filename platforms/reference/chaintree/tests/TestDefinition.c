/* Definitions that ctCreate refuses, each with the culprit's name, and the smallest that it accepts. */
#include "check.h"

#include <limits.h>

enum { PARTICLES = 6, LINKS = 3 };

/* Arrays of a sound scene, for a test to spoil: a fixed link, one that turns on it, one that is free. */
typedef struct Scene {
  double positions[3 * PARTICLES];
  double radii[PARTICLES];
  uint8_t roles[PARTICLES];
  int particleLinks[PARTICLES];
  int parents[LINKS];
  uint8_t joints[LINKS];
  int torsions[LINKS][4];
  int exclusions[2][2];
  ctDefinition definition;
} Scene;

static void makeSound(Scene* scene) {
  const Scene sound = {.positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 1, 0, 5, 0, 0, 6, 0, 0},
                       .radii = {0.1, 0.1, 0.1, 0, 0.1, 0.1},
                       .roles = {ctDonor, ctAcceptor, ctDonorAndAcceptor},
                       .particleLinks = {0, 0, 1, 1, 2, 2},
                       .parents = {CT_NULL, 0, CT_NULL},
                       .joints = {ctFixedJoint, ctTorsionJoint, ctFreeJoint},
                       .torsions = {{0}, {0, 1, 2, 3}, {0}},
                       .exclusions = {{0, 1}, {3, 2}}};
  *scene = sound;
  scene->definition = (ctDefinition){.particleCount = PARTICLES,
                                     .positions = scene->positions,
                                     .radii = scene->radii,
                                     .hydrogenBondRoles = scene->roles,
                                     .particleLinks = scene->particleLinks,
                                     .linkCount = LINKS,
                                     .linkParents = scene->parents,
                                     .linkJoints = scene->joints,
                                     .linkTorsions = (const int(*)[4])scene->torsions,
                                     .exclusionCount = 2,
                                     .exclusions = (const int(*)[2])scene->exclusions,
                                     .overlapTolerance = 0.04,
                                     .hydrogenBondAllowance = 0.06};
}

static void checkRefused(int line, const Scene* scene, const char* culprit) {
  ctChainTree* tree = (ctChainTree*)scene; /* anything but NULL */
  char text[256] = "";
  const ctStatus status = ctCreate(&scene->definition, &tree, text, sizeof text);
  if (status != ctInvalidArgument || tree != NULL || strstr(text, culprit) == NULL) {
    printf("line %d: status %d, \"%s\" does not name \"%s\"\n", line, (int)status, text, culprit);
    checkFailures++;
  }
  ctDestroy(tree);
}

/* One thing wrong in a sound scene. */
#define REFUSED(spoil, culprit)              \
  do {                                       \
    Scene scene;                             \
    makeSound(&scene);                       \
    spoil;                                   \
    checkRefused(__LINE__, &scene, culprit); \
  } while (0)

static void testParticles(void) {
  REFUSED(scene.positions[7] = NAN, "particle 2");
  REFUSED(scene.positions[17] = INFINITY, "particle 5");
  REFUSED(scene.positions[12] = 1.1 * CT_MOST_LENGTH, "particle 4");
  REFUSED(scene.positions[13] = -1e39, "particle 4");
  REFUSED(scene.positions[9] = -INFINITY, "particle 3");
  REFUSED(scene.radii[3] = -0.1, "particle 3");
  REFUSED(scene.radii[4] = NAN, "particle 4");
  REFUSED(scene.radii[4] = INFINITY, "particle 4");
  REFUSED(scene.radii[4] = 1.1 * CT_MOST_LENGTH, "particle 4");
  REFUSED(scene.roles[1] = 4, "particle 1");
  REFUSED(scene.particleLinks[5] = LINKS, "particle 5");
  REFUSED(scene.particleLinks[5] = -1, "particle 5");
  REFUSED(scene.definition.particleCount = -1, "-1 particles");
  REFUSED(scene.definition.particleCount = INT_MAX, "2147483647 particles");
}

static void testLinks(void) {
  REFUSED(scene.parents[2] = LINKS, "link 2");
  REFUSED(scene.parents[2] = -2, "link 2");
  REFUSED(scene.parents[2] = 2, "link 2");
  REFUSED(scene.joints[2] = 4, "link 2");
  REFUSED((scene.joints[2] = ctFixedJoint, scene.parents[2] = 0), "link 2");
  REFUSED(scene.joints[2] = ctTorsionJoint, "link 2");
  REFUSED((scene.particleLinks[4] = 1, scene.particleLinks[5] = 1), "link 2");
  REFUSED(scene.definition.linkCount = -1, "-1 links");
  REFUSED(scene.definition.linkCount = INT_MAX, "2147483647 links");
  /* 1 hangs on 2 and 2 on 1 */
  REFUSED((scene.joints[1] = ctFreeJoint, scene.parents[1] = 2, scene.parents[2] = 1), "ancestor");
}

static void testTorsions(void) {
  REFUSED(scene.definition.linkTorsions = NULL, "link 1");
  REFUSED(scene.torsions[1][0] = PARTICLES, "particle 6");
  REFUSED(scene.torsions[1][3] = -1, "particle -1");
  REFUSED(scene.torsions[1][1] = 4, "particles 4 and 2");
  REFUSED(scene.torsions[1][2] = 0, "particles 1 and 0");
  REFUSED((scene.torsions[1][1] = 2, scene.torsions[1][2] = 3), "particles 2 and 3");
}

static void testBallJoints(void) {
  REFUSED((scene.joints[1] = ctBallJoint, scene.definition.linkTorsions = NULL), "link 1");
  REFUSED((scene.joints[1] = ctBallJoint, scene.torsions[1][1] = PARTICLES), "particle 6");
  REFUSED((scene.joints[1] = ctBallJoint, scene.torsions[1][1] = 4), "particle 4");
  REFUSED((scene.joints[2] = ctBallJoint), "no parent");
}

static void testPairs(void) {
  REFUSED(scene.exclusions[1][0] = PARTICLES, "exclusion 1");
  REFUSED(scene.exclusions[1][1] = -1, "exclusion 1");
  REFUSED(scene.exclusions[1][1] = 3, "exclusion 1");
  REFUSED(scene.definition.exclusionCount = -1, "-1 exclusions");
  REFUSED(scene.definition.exclusionCount = INT_MAX, "2147483647 exclusions");
  REFUSED(scene.definition.overlapTolerance = -0.01, "tolerance is -0.01");
  REFUSED(scene.definition.overlapTolerance = NAN, "tolerance");
  REFUSED(scene.definition.overlapTolerance = 1.1 * CT_MOST_LENGTH, "tolerance");
  REFUSED(scene.definition.overlapTolerance = INFINITY, "tolerance");
  REFUSED(scene.definition.hydrogenBondAllowance = -0.01, "allowance is -0.01");
  REFUSED(scene.definition.hydrogenBondAllowance = INFINITY, "allowance");
}

static void testErrorText(void) {
  Scene scene;
  makeSound(&scene);
  scene.radii[0] = -1;
  ctChainTree* tree;
  char text[12] = "           ";
  CHECK(ctCreate(&scene.definition, &tree, NULL, 0) == ctInvalidArgument && tree == NULL);
  CHECK(ctCreate(&scene.definition, &tree, text, 0) == ctInvalidArgument && text[0] == ' ');
  CHECK(ctCreate(&scene.definition, &tree, text, 9) == ctInvalidArgument);
  CHECK(strcmp(text, "particle") == 0 && text[9] == ' '); /* cut to its size */
}

static void testSound(void) {
  Scene scene;
  makeSound(&scene);
  ctChainTree* tree = checkedCreate(&scene.definition);
  CHECK(ctGetErrorText(tree)[0] == '\0');
  CHECK(ctValidate(tree));
  CHECK(!ctHasTrial(tree));
  /* the caller's arrays may be freed or changed */
  makeSound(&scene);
  memset(scene.positions, 0, sizeof scene.positions);
  double positions[3 * PARTICLES];
  ctGetPositions(tree, positions);
  CHECK(positions[15] == 6);
  ctDestroy(tree);
}

/* Nothing at all is a scene too. */
static void testEmpty(void) {
  ctDefinition nothing = {.particleCount = 0};
  ctChainTree* tree = checkedCreate(&nothing);
  bool clash = true;
  double energy = 1;
  PairCount pairs = {0};
  CHECK_SUCCESS(ctHasClash(tree, &clash, NULL, NULL));
  CHECK(!clash);
  CHECK_SUCCESS(ctForEachNeighborPair(tree, 1, countPair, &pairs, NULL));
  CHECK(pairs.count == 0);
  CHECK_SUCCESS(ctComputeEnergy(tree, 1, &energy, NULL, NULL));
  CHECK(energy == 0);
  CHECK_SUCCESS(ctPropose(tree, 0, NULL));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  CHECK(!clash);
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK_SUCCESS(ctSetPositions(tree, NULL));
  CHECK(ctValidate(tree));
  ctDestroy(tree);
  ctDestroy(NULL);
}

int main(void) {
  testParticles();
  testLinks();
  testTorsions();
  testBallJoints();
  testPairs();
  testErrorText();
  testSound();
  testEmpty();
  return checkResult();
}
