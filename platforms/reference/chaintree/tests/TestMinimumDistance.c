/* The least distance between two sets of particles. */
#include <limits.h>

#include "beads.h"
#include "lattice.h"

static void checkLeast(ctChainTree* tree, int count1, const int* set1, int count2, const int* set2, double expected) {
  double distance = -1;
  int pair[2] = {CT_NULL, CT_NULL};
  CHECK_SUCCESS(minimumDistance(tree, count1, set1, count2, set2, &distance, pair));
  CHECK_NEAR(distance, expected, 1e-14);
  bool isFirst = false;
  bool isSecond = false;
  for (int n = 0; n < count1; n++) {
    isFirst = isFirst || set1[n] == pair[0];
  }
  for (int n = 0; n < count2; n++) {
    isSecond = isSecond || set2[n] == pair[1];
  }
  CHECK(isFirst && isSecond && pair[0] != pair[1]);
}

static void testFew(double radius) {
  ctChainTree* tree = makeLattice(LAYERS, radius, 0);
  const int corner[] = {siteIndex(0, 0, 0)};
  const int far[] = {siteIndex(8, 8, 8), siteIndex(1, 2, 2), siteIndex(0, 5, 0)};
  const int twice[] = {corner[0], far[2], corner[0]};
  checkLeast(tree, 1, corner, 3, far, 3);
  checkLeast(tree, 3, far, 1, corner, 3);
  checkLeast(tree, 3, far, 3, far, sqrt(14)); /* a particle is no pair with itself */
  checkLeast(tree, 3, twice, 1, corner, 5);
  const ctChange away = {.link = 2, .translation = {0, 0, 10}};
  CHECK_SUCCESS(ctPropose(tree, 1, &away));
  checkLeast(tree, 1, corner, 3, far, 3); /* the state, not the trial */
  CHECK_SUCCESS(ctAccept(tree, NULL));
  checkLeast(tree, 1, corner, 3, far, 5);
  ctDestroy(tree);
}

/* ---- After any earlier queries ---- */

/* Of the pairs of two sets of lattice sites whose squared distance, a whole number, is least the lowest. */
static int lowestNearest(const double* positions, int count1, const int* set1, int count2, const int* set2,
                         int pair[2]) {
  int least = INT_MAX;
  for (int i = 0; i < count1; i++) {
    for (int j = 0; j < count2; j++) {
      double squared = 0;
      for (int k = 0; k < 3; k++) {
        const double apart = positions[3 * set1[i] + k] - positions[3 * set2[j] + k];
        squared += apart * apart;
      }
      const bool isLower = set1[i] < pair[0] || (set1[i] == pair[0] && set2[j] < pair[1]);
      if (set1[i] != set2[j] && (lround(squared) < least || (lround(squared) == least && isLower))) {
        least = (int)lround(squared);
        pair[0] = set1[i];
        pair[1] = set2[j];
      }
    }
  }
  return least;
}

/* Layers move by whole steps, so that many pairs are equally near. The searches start from what was found before. */
static void testEquallyNear(double radius) {
  enum { SETS = 3, LAYER = SIDE * SIDE };
  static double positions[3 * SITES];
  static int sets[SETS][SITES];
  int counts[SETS] = {0, 0, 0};
  ctSelection* selections[SETS];
  ctChainTree* tree = makeLattice(LAYERS, radius, 0);
  unsigned random = 7;
  for (int i = 0; i < SITES; i++) {
    random = random * 1664525u + 1013904223u;
    const int set = (int)(random >> 24) % 16;
    if (set < SETS) {
      sets[set][counts[set]++] = i;
    }
  }
  for (int set = 0; set < SETS; set++) {
    selections[set] = checkedSelect(tree, counts[set], sets[set]);
  }
  for (int round = 0; round < 60; round++) {
    random = random * 1664525u + 1013904223u;
    const int step = (int)(random >> 28) - 8;
    const ctChange change = {.link = round % SIDE, .translation = {0, 0, step == 0 ? 1 : step}};
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    ctGetPositions(tree, positions);
    for (int ask = 0; ask < SETS * SETS; ask++) {
      const int one = (ask + round) % SETS;
      const int other = ask / SETS;
      double distance;
      int pair[2];
      int expected[2] = {INT_MAX, INT_MAX};
      const int squared = lowestNearest(positions, counts[one], sets[one], counts[other], sets[other], expected);
      CHECK_SUCCESS(ctGetMinimumDistance(tree, selections[one], selections[other], &distance, pair, NULL));
      CHECK_NEAR(distance, sqrt(squared), 1e-13);
      CHECK(pair[0] == expected[0] && pair[1] == expected[1]);
    }
  }
  for (int set = 0; set < SETS; set++) {
    ctFreeSelection(selections[set]);
  }
  ctDestroy(tree);
}

static void testRefused(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0.3, 0);
  ctChainTree* other = makeLattice(LAYERS, 0.3, 0);
  const int one[] = {7};
  const int outside[] = {0, SITES};
  const int below[] = {-1};
  ctSelection* selection;
  CHECK_FAILURE(tree, ctInvalidArgument, "particle 729", ctSelect(tree, 2, outside, &selection));
  CHECK(selection == NULL);
  CHECK_FAILURE(tree, ctInvalidArgument, "particle -1", ctSelect(tree, 1, below, &selection));
  ctFreeSelection(selection); /* NULL is ignored */

  double distance = -1;
  int pair[2] = {-7, -7};
  CHECK_FAILURE(tree, ctInvalidArgument, "no pair", minimumDistance(tree, 1, one, 1, one, &distance, pair));
  CHECK_FAILURE(tree, ctInvalidArgument, "no pair", minimumDistance(tree, 0, NULL, 1, one, &distance, pair));
  ctSelection* own = checkedSelect(tree, 1, one);
  ctSelection* strange = checkedSelect(other, 2, (const int[]){1, 2});
  CHECK_FAILURE(tree, ctInvalidArgument, "another scene",
                ctGetMinimumDistance(tree, own, strange, &distance, pair, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "another scene",
                ctGetMinimumDistance(tree, strange, own, &distance, pair, NULL));
  CHECK(distance == -1 && pair[0] == -7 && pair[1] == -7);
  ctDestroy(other);
  ctFreeSelection(strange); /* a selection may outlive its scene */
  ctDestroy(tree);
  ctFreeSelection(own);
}

/* Memory that a scene has freed is mostly that of the next one; a selection is not fooled. */
static void testNewSceneAtTheSameAddress(void) {
  const int first[] = {0};
  for (int round = 0; round < 20; round++) {
    const int count = 2 + round % 2;
    ctChainTree* gone = makeBeads(&(Beads){.count = 5 - count, .positions = {0, 0, 0, 1, 0, 0, 2, 0, 0}, .radii = {0}});
    ctSelection* freedFirst = checkedSelect(gone, 1, first);
    ctSelection* stale = checkedSelect(gone, 1, first);
    ctSelection* freedLast = checkedSelect(gone, 1, first);
    ctFreeSelection(freedFirst);
    ctDestroy(gone);
    ctChainTree* tree = makeBeads(&(Beads){.count = count, .positions = {0, 0, 0, 1, 0, 0, 2, 0, 0}, .radii = {0}});
    ctSelection* own = checkedSelect(tree, 1, first);
    double distance;
    int pair[2];
    CHECK_FAILURE(tree, ctInvalidArgument, "another scene",
                  ctGetMinimumDistance(tree, stale, own, &distance, pair, NULL));
    ctFreeSelection(stale);
    ctFreeSelection(own);
    ctDestroy(tree);
    ctFreeSelection(freedLast);
  }
}

/* ---- Against brute force ---- */

enum { COUNT = 3000 };

static unsigned chance = 1;

static double uniform(void) {
  chance = chance * 1664525u + 1013904223u;
  return (double)(chance >> 8) / (1 << 24);
}

/* A random walk of links, some of whose particles are not modelled, beside fixed particles. */
static ctChainTree* makeWalk(double* positions) {
  static double radii[COUNT];
  static int particleLinks[COUNT];
  static int parents[COUNT];
  static uint8_t joints[COUNT];
  static int torsions[COUNT][4];
  for (int i = 0; i < COUNT; i++) {
    const bool isFixed = i % 3 == 0;
    for (int k = 0; k < 3; k++) {
      const double from = isFixed ? 30 : i > 3 ? positions[3 * (i - (i % 3 == 1 ? 2 : 1)) + k] : 0;
      positions[3 * i + k] = from + (isFixed ? 20 : 1) * (uniform() - 0.5);
    }
    radii[i] = i % 5 == 0 || (i > 1000 && i < 1200) ? 0 : 0.1;
    particleLinks[i] = i;
    joints[i] = isFixed ? ctFixedJoint : i > 3 ? ctTorsionJoint : ctFreeJoint;
    parents[i] = joints[i] == ctTorsionJoint ? i - (i % 3 == 1 ? 2 : 1) : CT_NULL;
    const int torsion[] = {parents[i], parents[i], i, i};
    memcpy(torsions[i], torsion, sizeof torsion);
  }
  const ctDefinition definition = {.particleCount = COUNT,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = COUNT,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions};
  return checkedCreate(&definition);
}

static double bruteForce(const double* positions, int count1, const int* set1, int count2, const int* set2) {
  double least = INFINITY;
  for (int i = 0; i < count1; i++) {
    for (int j = 0; j < count2; j++) {
      const double* a = positions + 3 * set1[i];
      const double* b = positions + 3 * set2[j];
      const double distance =
          sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
      least = set1[i] != set2[j] && distance < least ? distance : least;
    }
  }
  return least;
}

static void testWalk(void) {
  static double positions[3 * COUNT];
  static int sets[2][COUNT];
  ctChainTree* tree = makeWalk(positions);
  for (int round = 0; round < 60; round++) {
    /* Moving and fixed particles, parts of each, or all; few or many. */
    int counts[2] = {0, 0};
    const double share = round % 4 == 0 ? 0.005 : 1;
    for (int i = 0; i < COUNT; i++) {
      for (int s = 0; s < 2; s++) {
        const bool fits = round % 3 == 0 || (i % 3 == 0) == (s == round % 2);
        if (fits && uniform() < share) {
          sets[s][counts[s]++] = i;
        }
      }
    }
    const int link = 5 + 3 * (int)(uniform() * (COUNT / 3 - 3));
    const ctChange change = {.link = link, .angle = uniform() - 0.5};
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    ctGetPositions(tree, positions);
    ctSelection* first = checkedSelect(tree, counts[0], sets[0]);
    ctSelection* second = checkedSelect(tree, counts[1], sets[1]);
    ctCounts cost = {0};
    double distance;
    int pair[2];
    CHECK_SUCCESS(ctGetMinimumDistance(tree, first, second, &distance, pair, &cost));
    const double expected = bruteForce(positions, counts[0], sets[0], counts[1], sets[1]);
    CHECK_NEAR(distance, expected, 1e-11);
    CHECK_NEAR(bruteForce(positions, 1, &pair[0], 1, &pair[1]), expected, 1e-11);
    CHECK(cost.volumeTests > 0 && cost.particleTests > 0 && cost.nodesUpdated == 0);
    if (round % 3 != 0 && round % 4 != 0) { /* large sets, apart from each other */
      CHECK(cost.volumeTests + cost.particleTests < counts[0] * counts[1] / 40);
    }
    ctFreeSelection(first);
    ctFreeSelection(second);
  }
  ctDestroy(tree);
}

int main(void) {
  testFew(0.4);
  testFew(0); /* particles that are not modelled count too */
  testEquallyNear(0.4);
  testEquallyNear(0);
  testRefused();
  testNewSceneAtTheSameAddress();
  testWalk();
  return checkResult();
}
