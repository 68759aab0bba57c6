/* Descents are distinguished by a number of 32 bits. After some thousand million descents it starts again, and nothing
 * may use what a descent of the same number left long ago. Looks inside the engine. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../src/descent.h"
#include "../src/scene.h"
#include "lattice.h"

enum { TRIALS = 300 };

static bool clashesTurned(ctChainTree* tree, int link, double angle) {
  const ctChange change = {.link = link, .angle = angle};
  bool clash = false;
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  return clash;
}

static void testWrap(const char* method) {
  setenv("CHAINTREE_TRIALS", method, 1);
  ctChainTree* tree = makeLattice(ONE_CHAIN, 0.3, 0);
  ctChainTree* other = makeLattice(ONE_CHAIN, 0.3, 0);
  int clashing = 0;
  for (int trial = 0; trial < TRIALS; trial++) {
    const int link = 2 + (trial * 37) % (SITES - 2);
    const double angle = 0.3 * sin(trial);
    for (int wrap = 0; wrap < 2; wrap++) {
      /* The second has the number of the first, which turns the same link by another angle. */
      tree->traversal.descent = UINT32_MAX;
      const double turn = wrap == 0 ? -3 * angle : angle;
      const bool clash = clashesTurned(other, link, turn);
      if (clashesTurned(tree, link, turn) != clash) {
        reportFailure("by %s, link %d turned by %g is called %d\n", method, link, turn, !clash);
      }
      CHECK(tree->traversal.descent < 5);
      clashing += clash;
    }
  }
  CHECK(clashing > 0 && clashing < 2 * TRIALS);
  ctDestroy(tree);
  ctDestroy(other);
}

int main(void) {
  testWrap("tree");
  testWrap("boxes");
  testWrap("clearances");
  return checkResult();
}
