/* Excluded pairs never clash and are in no list; nor are particles of radius 0. */
#include "beads.h"

static bool countChangedPair(void* context, int particle1, int particle2, double before, double after) {
  (void)before;
  return countPair(context, particle1, particle2, after);
}

/* Three beads on top of each other, but for an eighth of their radius. */
static const Beads crowd = {.count = 3, .positions = {0, 0, 0, 0.1, 0, 0, 0.2, 0, 0}, .radii = {0.8, 0.8, 0.8}};

static void checkLists(ctChainTree* tree, int expected) {
  PairCount clashes = {0};
  PairCount neighbors = {0};
  CHECK_SUCCESS(ctForEachClash(tree, countPair, &clashes, NULL));
  CHECK_SUCCESS(ctForEachNeighborPair(tree, 1, countPair, &neighbors, NULL));
  CHECK(clashes.count == expected);
  CHECK(neighbors.count == expected);
  bool clash;
  CHECK_SUCCESS(ctHasClash(tree, &clash, NULL, NULL));
  CHECK(clash == (expected > 0));
  double energy;
  CHECK_SUCCESS(ctComputeEnergy(tree, 1, &energy, NULL, NULL));
  CHECK((energy > 0) == (expected > 0));
}

static void testExclusions(void) {
  const int pairs[][2] = {{0, 1}, {2, 1}, {1, 0}, {0, 1}, {2, 0}, {0, 2}};
  const int counts[] = {0, 1, 2, 3, 4, 5, 6};
  const int left[] = {3, 2, 1, 1, 1, 0, 0};
  for (int n = 0; n < 7; n++) {
    Beads beads = crowd;
    beads.exclusionCount = counts[n];
    beads.exclusions = pairs;
    ctChainTree* tree = makeBeads(&beads);
    checkLists(tree, left[n]);
    CHECK(clashesShifted(tree, 0, 0.01) == (n < 5));
    PairCount changed = {0};
    CHECK_SUCCESS(ctForEachChangedPair(tree, 1, countChangedPair, &changed, NULL));
    CHECK(changed.count == (n == 0 ? 2 : n < 5 ? 1 : 0));
    /* the plain distance knows no exclusions */
    const int first = 0;
    const int others[] = {1, 2};
    double distance;
    int pair[2];
    CHECK_SUCCESS(minimumDistance(tree, 1, &first, 2, others, &distance, pair));
    CHECK_NEAR(distance, 0.1, 1e-15);
    ctDestroy(tree);
  }
}

static void testRadiusZero(void) {
  Beads beads = crowd;
  beads.radii[1] = 0;
  ctChainTree* tree = makeBeads(&beads);
  checkLists(tree, 1);
  CHECK(isListed(tree, 0, 2));
  CHECK(!clashesShifted(tree, 1, 0.05));
  CHECK(clashesShifted(tree, 2, 0.05));
  const int limited[][2] = {{1, 2}, {0, 1}}; /* a limit of what never clashes is none */
  CHECK_SUCCESS(ctSetLimits(tree, 2, limited, (const double[]){5, 5}));
  CHECK(ctGetLimitCount(tree) == 0);
  const int bare = 1;
  const int other = 2;
  double distance;
  int pair[2];
  CHECK_SUCCESS(minimumDistance(tree, 1, &bare, 1, &other, &distance, pair));
  CHECK_NEAR(distance, 0.1, 1e-15);
  ctDestroy(tree);

  memset(beads.radii, 0, sizeof beads.radii);
  const int pairs[][2] = {{0, 1}};
  beads.exclusionCount = 1;
  beads.exclusions = pairs;
  tree = makeBeads(&beads);
  checkLists(tree, 0);
  CHECK(!clashesShifted(tree, 0, 0.1));
  ctDestroy(tree);
}

int main(void) {
  testExclusions();
  testRadiusZero();
  return checkResult();
}
