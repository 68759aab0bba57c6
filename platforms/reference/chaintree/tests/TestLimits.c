/* Limits of single pairs: what trials may overlap where the state already does. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "beads.h"

/* Beads of radius 0.5: 0 and 1 overlap by 0.1, 1 and 2 by 0.2; the tolerance is 0.05. */
static const Beads three = {
    .count = 3, .positions = {0, 0, 0, 0.9, 0, 0, 1.7, 0, 0}, .radii = {0.5, 0.5, 0.5}, .tolerance = 0.05};

static void checkLimits(ctChainTree* tree, int count, const int (*pairs)[2], const double* values) {
  CHECK(ctGetLimitCount(tree) == count);
  int got[4][2];
  double limits[4];
  ctGetLimits(tree, 4, got, limits);
  for (int n = 0; n < count; n++) {
    CHECK(got[n][0] == pairs[n][0] && got[n][1] == pairs[n][1]);
    CHECK_NEAR(limits[n], values[n], 1e-15);
  }
}

/* A trial is refused beyond the pair's limit, which is its tolerance if it has none of its own. */
static void testVerdict(void) {
  ctChainTree* tree = makeBeads(&three);
  CHECK(clashesShifted(tree, 0, -0.01));
  CHECK(!clashesShifted(tree, 0, -0.0501));
  const int pairs[][2] = {{1, 0}};
  const double limit = 0.12;
  CHECK_SUCCESS(ctSetLimits(tree, 1, pairs, &limit));
  CHECK(!clashesShifted(tree, 0, -0.01));
  CHECK(!clashesShifted(tree, 0, 0.0199));
  CHECK(clashesShifted(tree, 0, 0.0201));
  CHECK(clashesShifted(tree, 2, 0.01)); /* 1-2 has no limit of its own */
  /* clashes and energy go by the tolerance all the same */
  PairCount clashes = {0};
  double energy;
  CHECK_SUCCESS(ctForEachClash(tree, countPair, &clashes, NULL));
  CHECK(clashes.count == 2);
  CHECK_SUCCESS(ctComputeEnergy(tree, 2, &energy, NULL, NULL));
  CHECK_NEAR(energy, 0.05 * 0.05 + 0.15 * 0.15, 1e-14);
  ctDestroy(tree);
}

static void testSetting(void) {
  ctChainTree* tree = makeBeads(&three);
  const int pairs[][2] = {{2, 0}, {1, 2}, {1, 0}};
  const double limits[] = {0.3, 0.05, 0.2}; /* the second is not above the tolerance */
  CHECK_SUCCESS(ctSetLimits(tree, 3, pairs, limits));
  checkLimits(tree, 2, (const int[][2]){{0, 1}, {0, 2}}, (const double[]){0.2, 0.3});
  int first[1][2];
  double value;
  ctGetLimits(tree, 1, first, &value);
  CHECK(first[0][0] == 0 && first[0][1] == 1 && value == 0.2);
  /* they outlive trials and new positions */
  shift(tree, 2, 5);
  ctReject(tree);
  CHECK_SUCCESS(ctSetPositions(tree, three.positions));
  checkLimits(tree, 2, (const int[][2]){{0, 1}, {0, 2}}, (const double[]){0.2, 0.3});
  /* the next call replaces all; a failed one none */
  const int outside[][2] = {{0, 1}, {0, 3}};
  CHECK_FAILURE(tree, ctInvalidArgument, "limit 1", ctSetLimits(tree, 2, outside, limits));
  const int same[][2] = {{1, 1}};
  CHECK_FAILURE(tree, ctInvalidArgument, "limit 0", ctSetLimits(tree, 1, same, limits));
  const double nan = NAN;
  CHECK_FAILURE(tree, ctInvalidArgument, "limit 0", ctSetLimits(tree, 1, pairs, &nan));
  checkLimits(tree, 2, (const int[][2]){{0, 1}, {0, 2}}, (const double[]){0.2, 0.3});
  CHECK_SUCCESS(ctSetLimits(tree, 1, pairs, limits));
  checkLimits(tree, 1, (const int[][2]){{0, 2}}, (const double[]){0.3});
  CHECK_SUCCESS(ctSetLimits(tree, 0, NULL, NULL));
  CHECK(ctGetLimitCount(tree) == 0);
  ctDestroy(tree);
}

static void testRaising(void) {
  ctChainTree* tree = makeBeads(&three);
  const int both[][2] = {{0, 1}, {1, 2}};
  const int pair[][2] = {{0, 1}};
  const double generous = 0.3;
  int raised = -1;
  CHECK_SUCCESS(ctSetLimits(tree, 1, pair, &generous));
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  CHECK(raised == 1);
  checkLimits(tree, 2, both, (const double[]){0.3, 0.2 + CT_SIGMA});
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  CHECK(raised == 0);
  /* a limit goes up, never down */
  shift(tree, 2, 0.1);
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  CHECK(raised == 0);
  shift(tree, 2, -0.15);
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  CHECK(raised == 1);
  checkLimits(tree, 2, both, (const double[]){0.3, 0.25 + CT_SIGMA});
  ctDestroy(tree);
}

/* Rounding cannot refuse the state that limits were taken from: however it is reached again. */
static void testSameStateAgain(void) {
  ctChainTree* tree = makeBeads(&three);
  int raised;
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  CHECK(raised == 2);
  CHECK(!clashesShifted(tree, 1, 0));
  for (int n = 1; n <= 100; n++) {
    const ctChange change = {
        .link = 1, .rotation = {0, 2 * PI * n, 0}, .pivot = {0.1 * n, n, -3}, .translation = {0, 0, 0}};
    bool clash = true;
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    CHECK(!clash);
  }
  CHECK(clashesShifted(tree, 1, 3e-9));
  CHECK(clashesShifted(tree, 1, -3e-9));
  ctDestroy(tree);
}

/* New limits count in the very next trial, also for pairs that were far from their old ones. */
static void testLowering(void) {
  enum { COUNT = 40, LAST = 14 }; /* the last of its leaf: the world has a slot, too */
  Beads row = {.count = COUNT};
  int pairs[COUNT - 1][2];
  double limits[COUNT - 1];
  for (int i = 0; i < COUNT; i++) {
    row.positions[3 * i] = i;
    row.radii[i] = 0.55;
  }
  for (int i = 0; i < COUNT - 1; i++) {
    /* that of LAST comes last */
    const int first = i == COUNT - 2 ? LAST : i < LAST ? i : i + 1;
    const int pair[2] = {first, first + 1};
    memcpy(pairs[i], pair, sizeof pair);
    limits[i] = 0.2;
  }
  ctChainTree* tree = makeBeads(&row);
  CHECK_SUCCESS(ctSetLimits(tree, COUNT - 1, pairs, limits));
  for (int n = 0; n < 10; n++) {
    CHECK(!clashesShifted(tree, LAST + 1, n % 2 == 0 ? 1e-4 : -1e-4));
    CHECK_SUCCESS(ctAccept(tree, NULL));
  }
  CHECK_SUCCESS(ctSetLimits(tree, COUNT - 2, pairs, limits));
  CHECK(clashesShifted(tree, LAST + 1, 1e-4));
  ctDestroy(tree);
}

int main(void) {
  testVerdict();
  testSetting();
  testRaising();
  testSameStateAgain();
  testLowering();
  setenv("CHAINTREE_TRIALS", "clearances", 1);
  testLowering();
  return checkResult();
}
