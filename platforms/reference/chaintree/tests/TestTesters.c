/* Testers can be switched off by name. Whichever are on, verdicts and trajectories are the same, and only the work
 * differs. Looks inside the engine. */
#include "../src/scene.h"
#include "lattice.h"

static const char* const names[TESTER_COUNT] = {"fewMovers", "recentClashes", "clearances", "descent"};

static double draw(unsigned* random) {
  *random = *random * 1664525u + 1013904223u;
  return (double)(*random >> 8) / (1 << 24);
}

/* Turns of a chain's end, small turns anywhere, and large ones: another tester decides about each kind. */
static ctChange drawChange(int trial, unsigned* random) {
  const int phase = trial / 1000 % 3;
  const int firstLink = phase == 0 ? SITES - TREE_WIDTH : 2;
  const double most = phase == 1 ? 1e-4 : 2;
  const int link = firstLink + (int)(draw(random) * (SITES - 1 - firstLink));
  return (ctChange){.link = link, .angle = most * (2 * draw(random) - 1)};
}

static bool clashes(ctChainTree* scene, const ctChange* change, ctCounts* counts) {
  bool clash = false;
  CHECK_SUCCESS(ctPropose(scene, 1, change));
  CHECK_SUCCESS(ctTestTrial(scene, &clash, NULL, counts));
  return clash;
}

static int64_t testsOf(const ctCounts* counts) {
  return counts->volumeTests + counts->particleTests;
}

/* Compares a scene without these testers (bits) with one that has all. */
static void compare(unsigned switchedOff) {
  static double expected[3 * SITES];
  static double positions[3 * SITES];
  ctChainTree* all = makeLattice(ONE_CHAIN, 0.49, 0);
  ctChainTree* some = makeLattice(ONE_CHAIN, 0.49, 0);
  for (int i = 0; i < TESTER_COUNT; i++) {
    CHECK(ctSwitchTester(some, names[i], (switchedOff >> i & 1) == 0));
  }
  unsigned random = 1;
  int clashing = 0;
  ctCounts countsOfAll = {0};
  ctCounts countsOfSome = {0};
  for (int trial = 0; trial < 6000; trial++) {
    const ctChange change = drawChange(trial, &random);
    const bool clash = clashes(all, &change, &countsOfAll);
    CHECK(clashes(some, &change, &countsOfSome) == clash);
    clashing += clash;
    if (!clash || trial % 50 == 0) { /* a trial that clashes may be accepted, too */
      CHECK_SUCCESS(ctAccept(all, NULL));
      CHECK_SUCCESS(ctAccept(some, NULL));
    }
  }
  CHECK(clashing > 1000 && clashing < 5000);
  ctGetPositions(all, expected);
  ctGetPositions(some, positions);
  CHECK(memcmp(positions, expected, sizeof positions) == 0);
  CHECK((testsOf(&countsOfSome) == testsOf(&countsOfAll)) == (switchedOff == 0));
  CHECK(ctValidate(some));
  ctDestroy(all);
  ctDestroy(some);
}

int main(void) {
  for (unsigned switchedOff = 0; switchedOff < 1u << TESTER_COUNT; switchedOff++) {
    compare(switchedOff);
  }
  ctChainTree* scene = makeLattice(ONE_CHAIN, 0.49, 0);
  CHECK(!ctSwitchTester(scene, "witnesses", false));
  ctDestroy(scene);
  return checkResult();
}
