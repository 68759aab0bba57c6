/* Positions in long double are what geometry says. */
#include <math.h>
#include <string.h>

#include "branches.h"
#include "chains.h"
#include "ourtree.h"
#include "reference.h"

/* Of what long double rounds. */
#define TINY 1e-17L

typedef long double Place[3];

static void checkPlace(const Place place, long double x, long double y, long double z) {
  CHECK(fabsl(place[0] - x) < TINY && fabsl(place[1] - y) < TINY && fabsl(place[2] - z) < TINY);
}

static long double distance(const Place a, const Place b) {
  return sqrtl((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* Stairs in a plane, a step along x, then along y, and so on; each sphere a link. */
static Scene* makeStairs(int count) {
  SceneSource source;
  char error[128] = "";
  if (!sceneSourceInit(&source, count, count - 2, 0)) {
    exit(1);
  }
  for (int i = 0; i < count; i++) {
    source.spheres[i] = (Sphere){{(i + 1) / 2, i / 2, 0}, 0.1};
    source.particleLinks[i] = i == 0 ? 0 : i == count - 1 ? count - 3 : i - 1;
  }
  for (int link = 0; link < count - 2; link++) {
    source.links[link] = (SourceLink){.parent = link - 1, .axis = {link, link + 1}};
  }
  Scene* scene = sceneMake(&source, error, sizeof error);
  sceneSourceFree(&source);
  if (scene == NULL) {
    printf("sceneMake: %s\n", error);
    exit(1);
  }
  return scene;
}

/* The first torsion is about the y axis through (1, 0, 0), the second about the way along x behind it. */
static void testTwoTurns(void) {
  Scene* scene = makeStairs(5);
  Reference* reference = referenceMake(scene);
  Place places[5];
  CHECK(scene->torsionCount == 2);
  referenceTurn(reference, &(Turn){0, 0.3});
  referenceTurn(reference, &(Turn){1, -1.1});
  referenceTurn(reference, &(Turn){0, 0.5});
  referencePositions(reference, places);
  const long double a = (long double)0.3 + 0.5;
  const long double b = -1.1;
  checkPlace(places[1], 1, 0, 0);
  checkPlace(places[2], 1, 1, 0);
  checkPlace(places[3], 1 + cosl(a), 1, -sinl(a));
  checkPlace(places[4], 1 + cosl(a) + sinl(b) * sinl(a), 1 + cosl(b), -sinl(a) + sinl(b) * cosl(a));
  referenceFree(reference);
  sceneFree(scene);
}

/* Many turns are one by their sum, and none in the end. */
static void testManyTurns(void) {
  enum { TURNS = 1000 };
  Scene* scene = makeStairs(4);
  Reference* reference = referenceMake(scene);
  Place places[4];
  for (int i = 0; i < TURNS; i++) {
    referenceTurn(reference, &(Turn){0, 2.3});
  }
  referencePositions(reference, places);
  const long double sum = TURNS * (long double)2.3;
  CHECK(fabsl(places[3][0] - 1 - cosl(sum)) < 1e-15L && fabsl(places[3][2] + sinl(sum)) < 1e-15L);
  for (int i = 0; i < TURNS; i++) {
    referenceTurn(reference, &(Turn){0, -2.3});
  }
  referencePositions(reference, places);
  CHECK(fabsl(places[3][0] - 2) < 1e-15L && fabsl(places[3][2]) < 1e-15L);
  const double zero = 0;
  referenceSetAngles(reference, &zero);
  referencePositions(reference, places);
  checkPlace(places[3], 2, 1, 0);
  referenceFree(reference);
  sceneFree(scene);
}

/* Where all torsions are alike, so are all parts: the chain is a helix. Of three steps at right angles, the first and
 * the last point are 3 + 2 cos(turn) apart, squared. */
static void testHelix(void) {
  enum { COUNT = 400 };
  static const int spans[] = {1, 2, 3, 10, 77};
  Scene* scene = makeStairs(COUNT);
  Reference* reference = referenceMake(scene);
  double angles[COUNT];
  Place places[COUNT];
  for (int t = 0; t < scene->torsionCount; t++) {
    angles[t] = 2.5;
  }
  referenceSetAngles(reference, angles);
  referencePositions(reference, places);
  for (int s = 0; s < 5; s++) {
    const long double expected = distance(places[0], places[spans[s]]);
    for (int i = 0; i + spans[s] < COUNT; i++) {
      CHECK(fabsl(distance(places[i], places[i + spans[s]]) - expected) < 1e-15L); /* of a length of 300 */
    }
  }
  CHECK(fabsl(distance(places[0], places[3]) - sqrtl(3 + 2 * cosl(2.5L))) < TINY);
  referenceFree(reference);
  sceneFree(scene);
}

/* The engine, which shares no code with it, has the same positions up to rounding; on branches, too. */
static void testAgreementWithEngine(void) {
  for (uint64_t seed = 1; seed <= 5; seed++) {
    Random random = {seed};
    Scene* scene = makeBranches(40, 5, seed);
    Reference* reference = referenceMake(scene);
    ctChainTree* tree = ourTreeOf(scene, 0, 0, NULL);
    Place places[MOST_BRANCH_PARTICLES];
    double positions[3 * MOST_BRANCH_PARTICLES];
    for (int i = 0; i < 500; i++) {
      const Turn turn = {randomInt(&random, scene->torsionCount), PI * (2 * randomReal(&random) - 1)};
      const ctChange change = {.link = scene->torsions[turn.torsion].link, .angle = turn.angle};
      referenceTurn(reference, &turn);
      CHECK_SUCCESS(ctPropose(tree, 1, &change));
      CHECK_SUCCESS(ctAccept(tree, NULL));
    }
    referencePositions(reference, places);
    ctGetPositions(tree, positions);
    for (int i = 0; i < 3 * scene->particleCount; i++) {
      CHECK_NEAR(positions[i], (double)places[i / 3][i % 3], 1e-12);
    }
    ctDestroy(tree);
    referenceFree(reference);
    sceneFree(scene);
  }
}

int main(void) {
  if (!referenceIsExact()) {
    return 77;
  }
  testTwoTurns();
  testManyTurns();
  testHelix();
  testAgreementWithEngine();
  return checkResult();
}
