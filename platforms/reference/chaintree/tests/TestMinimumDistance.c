/* The least distance between two sets of particles. */
#include "lattice.h"

static void checkLeast(ctChainTree* tree, int count1, const int* set1, int count2, const int* set2, double expected) {
  double distance = -1;
  int pair[2] = {CT_NULL, CT_NULL};
  CHECK_SUCCESS(ctGetMinimumDistance(tree, count1, set1, count2, set2, &distance, pair));
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

int main(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0, 0); /* particles that are not modelled count too */
  const int corner[] = {siteIndex(0, 0, 0)};
  const int far[] = {siteIndex(8, 8, 8), siteIndex(1, 2, 2), siteIndex(0, 5, 0)};
  checkLeast(tree, 1, corner, 3, far, 3);
  checkLeast(tree, 3, far, 1, corner, 3);
  checkLeast(tree, 3, far, 3, far, sqrt(14)); /* a particle is no pair with itself */
  const ctChange away = {.link = 2, .translation = {0, 0, 10}};
  CHECK_SUCCESS(ctPropose(tree, 1, &away));
  checkLeast(tree, 1, corner, 3, far, 3); /* the state, not the trial */
  CHECK_SUCCESS(ctCommit(tree, NULL));
  checkLeast(tree, 1, corner, 3, far, 5);

  double distance;
  int pair[2];
  const int outside[] = {0, SITES};
  const int below[] = {-1};
  CHECK_FAILURE(tree, ctInvalidArgument, "particle 729",
                ctGetMinimumDistance(tree, 2, outside, 1, corner, &distance, pair));
  CHECK_FAILURE(tree, ctInvalidArgument, "particle -1",
                ctGetMinimumDistance(tree, 1, corner, 1, below, &distance, pair));
  CHECK_FAILURE(tree, ctInvalidArgument, "no pair", ctGetMinimumDistance(tree, 1, corner, 1, corner, &distance, pair));
  CHECK_FAILURE(tree, ctInvalidArgument, "no pair", ctGetMinimumDistance(tree, 0, NULL, 3, far, &distance, pair));
  ctDestroy(tree);
  return checkResult();
}
