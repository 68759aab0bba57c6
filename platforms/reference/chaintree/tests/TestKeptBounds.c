/* Accepting a trial subtracts the same from clearances whether its test has kept the bounds of displacements or not.
 * Looks inside the engine. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../src/scene.h"
#include "lattice.h"

#include <string.h>

/* The same scene twice: in one of them no accepted trial finds bounds. */
typedef struct Twins {
  ctChainTree* keeps;
  ctChainTree* forgets;
  unsigned random;
  int acceptedByKept;
  int acceptedOfMany; /* of more pairs of runs than are kept */
} Twins;

static double draw(Twins* twins) {
  twins->random = twins->random * 1664525u + 1013904223u;
  return (double)(twins->random >> 8) / (1 << 24);
}

/* Proposes `count` turns, `apart` links apart, in both scenes. */
static void propose(Twins* twins, int count, int apart) {
  ctChange changes[SITES];
  const int link = 2 + (int)(draw(twins) * (SITES - 3 - (count - 1) * apart));
  for (int i = 0; i < count; i++) {
    changes[i] = (ctChange){.link = link + i * apart, .angle = 0.01 / (count * count) * (2 * draw(twins) - 1)};
  }
  CHECK_SUCCESS(ctPropose(twins->keeps, count, changes));
  CHECK_SUCCESS(ctPropose(twins->forgets, count, changes));
}

static bool clashes(Twins* twins) {
  bool clash[2];
  CHECK_SUCCESS(ctTestTrial(twins->keeps, &clash[0], NULL, NULL));
  CHECK_SUCCESS(ctTestTrial(twins->forgets, &clash[1], NULL, NULL));
  CHECK(clash[0] == clash[1]);
  return clash[0];
}

static void acceptTrial(Twins* twins) {
  const Clearance* kept = &twins->keeps->clearance;
  twins->acceptedByKept += kept->boundPieces != NULL;
  twins->acceptedOfMany += kept->boundPairCount > MOST_BOUND_PAIRS;
  twins->forgets->clearance.boundPieces = NULL;
  CHECK_SUCCESS(ctAccept(twins->keeps, NULL));
  CHECK_SUCCESS(ctAccept(twins->forgets, NULL));
  const Clearance* fresh = &twins->forgets->clearance;
  CHECK(kept->isKept && fresh->isKept);
  CHECK(memcmp(kept->least, fresh->least, (size_t)kept->leafCount * (size_t)kept->stride * sizeof *kept->least) == 0);
}

int main(void) {
  setenv("CHAINTREE_TRIALS", "clearances", 1);
  Twins twins = {.random = 1};
  twins.keeps = makeLattice(ONE_CHAIN, 0.49, 0);
  twins.forgets = makeLattice(ONE_CHAIN, 0.49, 0);
  int clashing = 0;
  for (int i = 0; i < 600; i++) {
    /* One turn, eight in a row, and one run for each leaf. */
    propose(&twins, i % 3 == 0 ? 1 : i % 3 == 1 ? 8 : 30, i % 3 == 2 ? TREE_WIDTH : 1);
    const bool clash = clashes(&twins);
    clashing += clash;
    if (i % 7 == 0) { /* bounds of an earlier trial, whose memory this one has */
      propose(&twins, 2, 3);
      propose(&twins, 1, 1);
    }
    if (!clash || i % 7 == 0 || i % 11 == 0) { /* also of a test that a clash has ended */
      acceptTrial(&twins);
    }
  }
  CHECK(clashing > 50);
  CHECK(twins.acceptedByKept > 100);
  CHECK(twins.acceptedOfMany > 20);
  CHECK(ctValidate(twins.keeps));
  ctDestroy(twins.keeps);
  ctDestroy(twins.forgets);
  return checkResult();
}
