/* Terms of every kind in random scenes against an oracle: what each joint and each displaced particle changes, random
 * programs of trials, new states, and terms that many joints change. */
#include "termscene.h"

static TermScene scene;

static void drawSmallScene(uint64_t seed) {
  scene.branches = (Branches){.chance = 88172645463325252u + 7919 * seed};
  Branches* b = &scene.branches;
  for (int i = 0; i < 10; i++) {
    drawReal(b);
  }
  addMolecule(b, 24, ctFixedJoint, 0.4, 0.3);
  addMolecule(b, 18, ctFreeJoint, 0.4, 0.4);
  addMolecule(b, 5, ctFreeJoint, 0.5, 0);
  addMolecule(b, 9, ctFreeJoint, 0.5, 0.5);
}

static void drawLargeScene(uint64_t seed) {
  drawSmallScene(seed);
  addMolecule(&scene.branches, 120, seed % 2 == 0 ? ctFixedJoint : ctFreeJoint, 0.2, 0.5);
  addMolecule(&scene.branches, 100, ctFreeJoint, 0, 0.8);
}

/* ---- What each joint changes ---- */

/* A term that more joints change is not listed with each. */
enum { MOST_LISTED_JOINTS = 8 };

/* One term at a time, each joint on its own. A joint that does not change a term does not even recompute it, unless
 * many others change it: the change is exactly 0. Returns how many change it. */
static int testJointsOfTerm(uint64_t seed, int number) {
  Branches* b = &scene.branches;
  const ctTermSet* set = &scene.random.sets[0];
  int changers = 0;
  int idlers = 0; /* joints that do not change it, but compute it */
  for (int link = 0; link < b->linkCount; link++) {
    if (b->joints[link] == ctFixedJoint) {
      continue;
    }
    ctChange change = drawChange(b, link);
    change.angle = 0.3;
    CHECK_SUCCESS(ctPropose(scene.tree, 1, &change));
    long double size;
    const long double expected = changeOfOracle(&scene, &size);
    const double found = changeOfTerms(&scene);
    CHECK_NEAR(found, (double)expected, (double)(1e-9L * size));
    const bool isChanged = fabsl(expected) > 1e-10L * size;
    changers += isChanged;
    idlers += !isChanged && found != 0;
  }
  if (idlers > 0 && changers <= MOST_LISTED_JOINTS) {
    reportFailure("seed %d, term %d of kind %d: changed by %d joints, by 0 by %d\n", (int)seed, number, (int)set->kind,
                  changers, idlers);
  }
  return changers;
}

static void checkChangeable(uint64_t seed, int number, bool isChangeable) {
  if (ctTermsCountChangeable(scene.terms, 0) != isChangeable) {
    reportFailure("seed %d, term %d of kind %d: changeable: %d\n", (int)seed, number, (int)scene.random.sets[0].kind,
                  ctTermsCountChangeable(scene.terms, 0));
  }
}

/* Draws a scene of one term; false if that counts as changeable and never changes. */
static bool drawTerm(void) {
  drawTerms(&scene.branches, &scene.random, 0, 1);
  const ctTermSet* set = &scene.random.sets[0];
  return set->kind != ctPeriodicTorsionTerm || set->parameters[0] != 0;
}

/* A term is constant if no joint changes it. */
static void testJoints(uint64_t seed) {
  drawSmallScene(seed);
  for (int i = 0; i < 60; i++) {
    if (drawTerm()) {
      createTermScene(&scene);
      checkChangeable(seed, i, testJointsOfTerm(seed, i) > 0);
      destroyTermScene(&scene);
    }
  }
}

/* ---- What each displaced particle changes ---- */

static bool holds(const ctTermSet* set, int particle) {
  for (int i = 0; i < set->particlesPerTerm; i++) {
    if (set->particles[i] == particle) {
      return true;
    }
  }
  return false;
}

/* Each particle on its own changes a term that holds it, within a link too, and no other. Returns how many of these can
 * be displaced. */
static int testParticlesOfTerm(void) {
  Branches* b = &scene.branches;
  int holders = 0;
  for (int atom = 0; atom < b->atomCount; atom++) {
    if (isFixed(b, atom)) {
      continue;
    }
    const ctDisplacement displacement = {atom, {0.01, -0.02, 0.015}};
    CHECK_SUCCESS(ctProposeDisplacements(scene.tree, 1, &displacement));
    long double size;
    const long double expected = changeOfOracle(&scene, &size);
    const double found = changeOfTerms(&scene);
    CHECK_NEAR(found, (double)expected, (double)(1e-9L * size));
    holders += holds(&scene.random.sets[0], atom);
    CHECK(holds(&scene.random.sets[0], atom) || found == 0);
  }
  return holders;
}

/* A term is constant if all of its particles are fixed. Joints change the same terms as in a rigid scene, also after
 * bonds and angles have changed, on which axes depend. */
static void testParticles(uint64_t seed) {
  ctDisplacement displacements[MOST_DISPLACED];
  drawSmallScene(seed);
  scene.branches.isFlexible = true;
  for (int i = 0; i < 60; i++) {
    if (!drawTerm()) {
      continue;
    }
    createTermScene(&scene);
    checkChangeable(seed, i, testParticlesOfTerm() > 0);
    for (int trial = 0; trial < 20; trial++) {
      const int count = drawDisplacements(&scene.branches, 0.02, displacements);
      CHECK_SUCCESS(ctProposeDisplacements(scene.tree, count, displacements));
      long double size;
      const long double expected = changeOfOracle(&scene, &size);
      CHECK_NEAR(changeOfTerms(&scene), (double)expected, (double)(1e-9L * size));
      acceptTrial(&scene);
    }
    checkSums(&scene);
    testJointsOfTerm(seed, i);
    destroyTermScene(&scene);
  }
}

/* ---- Random programs ---- */

static int drawChanges(Branches* b, ctChange* changes) {
  static int taken[MOST_ATOMS];
  const int most = drawBelow(b, 10) == 0 ? 40 : 3;
  const int wanted = 1 + drawBelow(b, most);
  int count = 0;
  memset(taken, 0, sizeof taken);
  for (int attempt = 0; attempt < 100 && count < wanted; attempt++) {
    const int link = drawBelow(b, b->linkCount);
    if (b->joints[link] != ctFixedJoint && !taken[link]) {
      taken[link] = 1;
      changes[count++] = drawChange(b, link);
    }
  }
  return count;
}

/* Proposes changes of joints or, in a flexible scene, displacements. */
static void proposeAny(void) {
  static ctChange changes[MOST_ATOMS];
  ctDisplacement displacements[MOST_DISPLACED];
  Branches* b = &scene.branches;
  if (b->isFlexible && drawBelow(b, 2) == 0) {
    const int count = drawDisplacements(b, 0.02, displacements);
    CHECK_SUCCESS(ctProposeDisplacements(scene.tree, count, displacements));
  } else {
    CHECK_SUCCESS(ctPropose(scene.tree, drawChanges(b, changes), changes));
  }
}

static void testProgram(uint64_t seed, int trials, bool isFlexible) {
  static double positions[3 * MOST_ATOMS];
  drawLargeScene(seed);
  Branches* b = &scene.branches;
  b->isFlexible = isFlexible;
  drawTerms(b, &scene.random, 12, 30);
  createTermScene(&scene);
  checkSums(&scene);
  for (int t = 0; t < trials; t++) {
    proposeAny();
    long double size;
    const long double expected = changeOfOracle(&scene, &size);
    const double found = changeOfTerms(&scene);
    CHECK_NEAR(found, (double)expected, (double)(1e-9L * size));
    const double before = ctTermsSum(scene.terms, t % scene.random.setCount);
    if (drawBelow(b, 8) == 0) {
      ctReject(scene.tree);
      CHECK(ctTermsSum(scene.terms, t % scene.random.setCount) == before);
    } else {
      acceptTrial(&scene);
    }
    if (t % 50 == 0) {
      checkSums(&scene);
    }
    if (drawBelow(b, 200) == 0) { /* another geometry, in which constant terms have other values, too */
      ctGetPositions(scene.tree, positions);
      for (int i = 0; i < 3 * b->atomCount; i++) {
        positions[i] += 0.02 * (drawReal(b) - 0.5);
      }
      CHECK_SUCCESS(ctSetPositions(scene.tree, positions));
      refreshTerms(&scene);
      checkSums(&scene);
    }
  }
  checkSums(&scene);
  destroyTermScene(&scene);
}

/* A trial that is asked about twice, dropped in between or not, changes the same, bit by bit. */
static void testRepeats(void) {
  static ctChange changes[MOST_ATOMS];
  static double sums[MOST_SETS];
  drawLargeScene(77);
  drawTerms(&scene.branches, &scene.random, 12, 30);
  createTermScene(&scene);
  for (int s = 0; s < scene.random.setCount; s++) {
    sums[s] = ctTermsSum(scene.terms, s);
  }
  for (int t = 0; t < 100; t++) {
    const int count = drawChanges(&scene.branches, changes);
    CHECK_SUCCESS(ctPropose(scene.tree, count, changes));
    const double first = changeOfTerms(&scene);
    CHECK(changeOfTerms(&scene) == first);
    ctReject(scene.tree);
    CHECK_SUCCESS(ctPropose(scene.tree, count, changes));
    CHECK(changeOfTerms(&scene) == first);
    ctReject(scene.tree);
    for (int s = 0; s < scene.random.setCount; s++) {
      CHECK(ctTermsSum(scene.terms, s) == sums[s]);
    }
  }
  destroyTermScene(&scene);
}

int main(int argc, char** argv) {
  const int trials = argc > 1 ? atoi(argv[1]) : 3000;
  for (uint64_t seed = 0; seed < 12; seed++) {
    testJoints(seed);
    testParticles(seed);
  }
  for (uint64_t seed = 0; seed < 4; seed++) {
    testProgram(seed, trials, false);
    testProgram(seed, trials, true);
  }
  testRepeats();
  return checkResult();
}
