#include "clearance.h"

#include <stdlib.h>

#include "costs.h"
#include "wide.h"

void ctClearanceForget(Clearance* c) {
  c->isKept = false;
}

void ctClearanceDropTests(Clearance* c) {
  c->testedCount = 0;
  c->boundPieces = NULL;
}

/* The allowance in bounds of displacements, relative; see boundDisplacements. */
#define MOST_UNITS_SKIPPED 0.25

void ctClearanceSkip(Clearance* c, double distanceError) {
  c->skipped += distanceError;
  if (c->skipped > MOST_UNITS_SKIPPED * (double)c->unit) {
    c->isKept = false;
  }
}

void ctClearanceFree(Clearance* c) {
  ctArenaFree(&c->arena);
  free(c->tested);
  free(c->runs);
  *c = (Clearance){0};
}

/* Makes the arrays, if that is not done. False if there is no memory. */
static bool reserve(Clearance* c, const Tree* tree) {
  if (c->least != NULL) {
    return true;
  }
  c->leafCount = tree->levelSize[0];
  c->stride = (c->leafCount + COLUMNS_AT_ONCE - 1) / COLUMNS_AT_ONCE * COLUMNS_AT_ONCE;
  const size_t columns = (size_t)c->stride;
  c->least = ctArenaAllocate(&c->arena, (size_t)c->leafCount * columns, sizeof *c->least);
  c->displacements = ctArenaAllocate(&c->arena, MOST_BOUND_PAIRS * columns, sizeof *c->displacements);
  c->boundPairs = ctArenaAllocate(&c->arena, MOST_BOUND_PAIRS, sizeof *c->boundPairs);
  c->near = ctArenaAllocate(&c->arena, TREE_WIDTH * columns / COLUMNS_AT_ONCE + 1, sizeof *c->near);
  if (c->arena.failed) {
    ctArenaFree(&c->arena);
    c->least = NULL;
  }
  return c->least != NULL;
}

/* The cost of a test by clearances that finds nothing near: all rows of leaves that move, sixteen columns at a time. */
static int64_t leastCost(const Tree* tree) {
  const int64_t leaves = tree->levelSize[0];
  const int64_t least = leaves + leaves * leaves / LEAF_PAIRS_PER_UNIT;
  return least > LEAST_COST_WORTH_SAVING ? least : LEAST_COST_WORTH_SAVING;
}

void ctClearanceGiveUp(Clearance* c) {
  c->isKept = false;
  c->measuresTree = false;
  c->cost = 0;
  c->trials = 0;
  c->wait = c->patience;
  c->patience = c->patience < MOST_CLEARANCE_PATIENCE ? 2 * c->patience : c->patience;
}

/* Measures the table of the state. False if there is no memory. */
static bool keep(Clearance* c, Traversal* t, double reach) {
  c->isKept = reserve(c, t->tree);
  if (c->isKept) {
    t->tree->wide->measureClearances(c, t, reach);
    c->skipped = 0;
  }
  return c->isKept;
}

/* Makes the choice at the end of a round. */
static void choose(Clearance* c, Traversal* t, double reach) {
  const int64_t mean = c->cost / c->trials;
  c->cost = 0;
  c->trials = 0;
  if (!c->isKept) {
    c->treeCost = mean;
  } else if (c->measuresTree) {
    c->treeCost = (c->treeCost + mean) / 2; /* a few trials are not representative */
  }
  if (c->measuresTree) {
    c->measuresTree = false;
  } else if (c->isKept && 10 * mean > TENTHS_THAT_PAY * c->treeCost) {
    ctClearanceGiveUp(c);
  } else if (c->isKept) {
    c->patience = LEAST_CLEARANCE_PATIENCE;
    /* If the tree is slow, it is measured rarely, so that measuring takes the same share of the time. */
    c->measuresTree = ++c->rounds * mean >= ROUNDS_PER_MEASUREMENT * c->treeCost;
    c->rounds = c->measuresTree ? 0 : c->rounds;
  } else if (c->wait > 0) {
    c->wait--;
  } else if (mean > leastCost(t->tree) && keep(c, t, reach)) {
    c->patience = c->patience > 0 ? c->patience : LEAST_CLEARANCE_PATIENCE;
    c->rounds = 0;
  }
}

bool ctClearanceIsWanted(Clearance* c, Traversal* t, double reach, bool isAlone) {
  if (t->tree->levelCount == 1 || t->tree->levelSize[0] > MOST_LEAVES) {
    return false;
  }
  if (isAlone) {
    c->mostCost = INT64_MAX;
    return c->isKept || keep(c, t, reach);
  }
  if (c->trials >= (c->measuresTree ? TRIALS_TO_MEASURE_TREE : CLEARANCE_ROUND)) {
    choose(c, t, reach);
  }
  /* The first tests of a round may have many clearances to find. */
  c->mostCost = (TRIALS_IN_ADVANCE + c->trials) * c->treeCost - c->cost;
  return c->isKept && !c->measuresTree;
}

void ctClearanceCharge(Clearance* c, int64_t cost, bool isTest) {
  c->cost += cost;
  c->trials += isTest;
}
