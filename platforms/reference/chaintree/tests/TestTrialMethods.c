/* The engine chooses between tree and clearances by the cost of trials. It changes its choice and returns to it, and
 * verdicts do not depend on it. Looks inside the engine. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../src/scene.h"
#include "lattice.h"

typedef struct Comparison {
  ctChainTree* byCost;
  ctChainTree* byTree;
  unsigned random;
  int testsByClearance;
  int changesOfMind;
} Comparison;

static double draw(Comparison* comparison) {
  comparison->random = comparison->random * 1664525u + 1013904223u;
  return (double)(comparison->random >> 8) / (1 << 24);
}

enum { WINDOW = 8 };

/* Trials of turns by up to `most`, `inARow` in each half of the chain; trials without a clash are accepted. */
static void follow(Comparison* comparison, int trials, double most, int inARow) {
  for (int i = 0; i < trials; i++) {
    const int link = 2 + (int)(draw(comparison) * (SITES / 2 - 1 - inARow));
    ctChange changes[2 * WINDOW];
    for (int k = 0; k < 2 * inARow; k++) {
      const int first = k < inARow ? link : link + SITES / 2 - 2;
      changes[k] = (ctChange){.link = first + k % inARow, .angle = most * (2 * draw(comparison) - 1)};
    }
    const bool before = comparison->byCost->clearance.isKept;
    bool clash[2];
    ctCounts counts = {0};
    CHECK_SUCCESS(ctPropose(comparison->byCost, 2 * inARow, changes));
    CHECK_SUCCESS(ctPropose(comparison->byTree, 2 * inARow, changes));
    CHECK_SUCCESS(ctTestTrial(comparison->byCost, &clash[0], NULL, i % 2 == 0 ? &counts : NULL));
    CHECK_SUCCESS(ctTestTrial(comparison->byTree, &clash[1], NULL, NULL));
    CHECK(clash[0] == clash[1]);
    if (!clash[0]) {
      CHECK_SUCCESS(ctAccept(comparison->byCost, NULL));
      CHECK_SUCCESS(ctAccept(comparison->byTree, NULL));
    }
    comparison->testsByClearance += comparison->byCost->clearance.isKept;
    comparison->changesOfMind += comparison->byCost->clearance.isKept != before;
  }
  CHECK(ctValidate(comparison->byCost));
}

static void startAnew(Comparison* comparison) {
  static double positions[3 * SITES];
  ctChainTree* fresh = makeLattice(ONE_CHAIN, 0.49, 0);
  ctGetPositions(fresh, positions);
  ctDestroy(fresh);
  CHECK_SUCCESS(ctSetPositions(comparison->byCost, positions));
  CHECK_SUCCESS(ctSetPositions(comparison->byTree, positions));
}

int main(void) {
  Comparison comparison = {.random = 1};
  comparison.byCost = makeLattice(ONE_CHAIN, 0.49, 0);
  setenv("CHAINTREE_TRIALS", "tree", 1);
  comparison.byTree = makeLattice(ONE_CHAIN, 0.49, 0);
  int patience = 0;
  for (int phase = 0; phase < 5; phase++) {
    /* Small steps in a dense globule: after some patience by clearances. */
    startAnew(&comparison);
    comparison.testsByClearance = 0;
    follow(&comparison, 8000, 1e-4, 1);
    CHECK(comparison.testsByClearance > 500);
    /* Large ones, which soon undo it. */
    comparison.testsByClearance = 0;
    follow(&comparison, 4000, 2, 1);
    CHECK(comparison.testsByClearance < 2000);
    patience = comparison.byCost->clearance.patience > patience ? comparison.byCost->clearance.patience : patience;
  }
  CHECK(comparison.changesOfMind >= 10);
  CHECK(patience > 4);
  /* However often they have not paid, they are tried again one day. */
  for (int i = 0; i < 40; i++) {
    ctClearanceGiveUp(&comparison.byCost->clearance);
  }
  CHECK(comparison.byCost->clearance.patience > patience && comparison.byCost->clearance.patience < 100000);
  ctDestroy(comparison.byCost);
  /* Many pieces in a leaf. */
  setenv("CHAINTREE_TRIALS", "clearances", 1);
  comparison.byCost = makeLattice(ONE_CHAIN, 0.49, 0);
  comparison.testsByClearance = 0;
  startAnew(&comparison);
  for (int i = 0; i < 40; i++) {
    follow(&comparison, 50, i % 2 == 0 ? 1e-4 : 0.01, WINDOW);
  }
  CHECK(comparison.testsByClearance == 2000);
  ctDestroy(comparison.byCost);
  ctDestroy(comparison.byTree);
  return checkResult();
}
