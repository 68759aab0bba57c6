/* A chain of a million links: verdicts that turn at a known angle, positions, counts that stay small. */
#include "chain.h"

enum { LINKS = 1000000, LAST = LINKS - 1 };

#define RADIUS 0.3

/* A straight arm along x whose hands, the particles 2 l at (l, 0, 0), are modelled. Link l > 0 turns about an axis
 * along z through the hand before its own; the other particle of its axis, 2 l + 1, is not modelled. */
static ctChainTree* makeLongArm(void) {
  const Chain chain = allocateChain(2 * LINKS, LINKS, ctFixedJoint);
  for (int l = 0; l < LINKS; l++) {
    const size_t hand = 2 * (size_t)l;
    const int torsion[4] = {2 * l - 2, 2 * l - 2, 2 * l + 1, 2 * l + 1};
    memcpy(chain.torsions[l], torsion, sizeof torsion);
    chain.positions[3 * hand] = l;
    chain.positions[3 * (hand + 1)] = l - 1;
    chain.positions[3 * (hand + 1) + 2] = 1;
    chain.radii[hand] = RADIUS;
    chain.particleLinks[hand] = chain.particleLinks[hand + 1] = l;
  }
  return createChain(&chain);
}

static bool clashesTurned(ctChainTree* arm, int link, double angle, int pair[2], ctCounts* counts) {
  const ctChange change = {.link = link, .angle = angle};
  bool clash = false;
  CHECK_SUCCESS(ctPropose(arm, 1, &change));
  CHECK_SUCCESS(ctTestTrial(arm, &clash, pair, counts));
  return clash;
}

/* Bent by an angle, the hands on either side of a joint are 2 cos(angle / 2) apart, and all others farther. */
static double angleOf(double distance) {
  return 2 * acos(0.5 * distance);
}

static void testHairpin(ctChainTree* arm, int link) {
  const double sigma = 2 * CT_SIGMA;
  for (int sign = -1; sign <= 1; sign += 2) {
    ctCounts counts = {0};
    int pair[2] = {CT_NULL, CT_NULL};
    CHECK(!clashesTurned(arm, link, sign * angleOf(2 * RADIUS + sigma), NULL, &counts));
    CHECK(counts.volumeTests + counts.particleTests < 20000);
    CHECK(clashesTurned(arm, link, sign * angleOf(2 * RADIUS - sigma), pair, NULL));
    CHECK(pair[0] == 2 * (link - 2) && pair[1] == 2 * link);
    CHECK(clashesTurned(arm, link, sign * PI, NULL, NULL)); /* all on top of each other */
  }
  ctReject(arm);
}

/* Bends of 30 degrees here and there; the positions against sums in long double. */
static void testBent(ctChainTree* arm) {
  enum { BENDS = 12, STEP = LINKS / BENDS };
  static double positions[6 * LINKS];
  for (int bend = 0; bend < BENDS; bend++) {
    ctCounts counts = {0};
    CHECK(!clashesTurned(arm, STEP / 2 + bend * STEP, PI / 6 * (bend % 3 == 0 ? 1 : -0.5), NULL, NULL));
    CHECK_SUCCESS(ctAccept(arm, &counts));
    CHECK(counts.nodesUpdated < 50);
  }
  ctGetPositions(arm, positions);
  long double x = 0;
  long double y = 0;
  long double direction = 0;
  for (int l = 1; l < LINKS; l++) {
    if (l % STEP == STEP / 2) {
      direction += (long double)(PI / 6 * (l / STEP % 3 == 0 ? 1 : -0.5));
    }
    x += cosl(direction);
    y += sinl(direction);
    /* 1e-12 of the size is what double keeps along log N products. */
    CHECK_NEAR(positions[6 * l], (double)x, 1e-12 * LINKS);
    CHECK_NEAR(positions[6 * l + 1], (double)y, 1e-12 * LINKS);
    CHECK(positions[6 * l + 2] == 0);
  }
}

int main(void) {
  static const int links[] = {2, 3, 15, 16, 17, 255, 256, 257, 4096, 65536, 65537, 131072, 500001, 999998, LAST};
  ctChainTree* arm = makeLongArm();
  PairCount pairs = {0};
  bool clash = true;
  CHECK_SUCCESS(ctHasClash(arm, &clash, NULL, NULL));
  CHECK(!clash);
  CHECK_SUCCESS(ctForEachNeighborPair(arm, 2, countPair, &pairs, NULL));
  CHECK(pairs.count == LINKS - 1 + LINKS - 2);
  for (size_t i = 0; i < sizeof links / sizeof links[0]; i++) {
    testHairpin(arm, links[i]);
  }
  testBent(arm);
  for (size_t i = 0; i < sizeof links / sizeof links[0]; i++) {
    testHairpin(arm, links[i]);
  }
  ctDestroy(arm);
  return checkResult();
}
