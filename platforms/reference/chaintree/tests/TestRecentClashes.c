/* Pairs that clashed in past trials are tested first where that pays, and no longer where it does not; the verdict is
 * the same. Looks inside the engine. */
#include "../src/scene.h"
#include "lattice.h"

static double random01(void) {
  static unsigned state = 1;
  state = state * 1664525u + 1013904223u;
  return (double)(state >> 8) / (1 << 24);
}

/* True if a turn clashes; adds the cost of the test, and rejects the trial. */
static bool clashes(ctChainTree* scene, int link, double angle, ctCounts* counts) {
  const ctChange change = {.link = link, .angle = angle};
  bool clash = false;
  CHECK_SUCCESS(ctPropose(scene, 1, &change));
  CHECK_SUCCESS(ctTestTrial(scene, &clash, NULL, counts));
  ctReject(scene);
  return clash;
}

int main(void) {
  /* With thicker particles, what clashes in one turn would clash in enough others that recent clashes paid. */
  ctChainTree* scene = makeLattice(ONE_CHAIN, 0.3, 0);
  int link = 2;
  while (link < SITES - 2 && !clashes(scene, link, 0.1, NULL)) {
    link++;
  }
  /* What clashed once clashes again, and nothing else is tested. */
  for (int i = 0; i < 1000; i++) {
    ctCounts again = {0};
    CHECK(clashes(scene, link, 0.1, &again));
    CHECK(again.volumeTests == 0 && again.particleTests == 1);
  }
  /* A recent clash is only a hint. */
  CHECK(!clashes(scene, link, 1e-6, NULL));
  /* Each clash is elsewhere: soon recent clashes are tested only in a round now and then. */
  int asked = 0;
  for (int i = 0; i < 10000; i++) {
    clashes(scene, 2 + (int)(random01() * (SITES - 3)), 6 * random01() - 3, NULL);
    asked += scene->recentClashes.wait == 0;
  }
  CHECK(asked < 2000);
  CHECK(asked > 100);
  /* Once they pay again, they are tested again. */
  for (int i = 0; i < 10000; i++) {
    CHECK(clashes(scene, link, 0.1, NULL));
  }
  ctCounts again = {0};
  CHECK(clashes(scene, link, 0.1, &again));
  CHECK(again.volumeTests == 0);
  ctDestroy(scene);
  return checkResult();
}
