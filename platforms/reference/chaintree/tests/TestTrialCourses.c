/* By what trials are tested, tree or clearances, follows what they cost: the choice is made and taken back, and nobody
 * can tell from the verdicts. Looks inside the engine. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../src/scene.h"
#include "lattice.h"

typedef struct Course {
  ctChainTree* byCost;
  ctChainTree* byTree;
  unsigned random;
  int testsByClearance;
  int changesOfMind;
} Course;

static double draw(Course* course) {
  course->random = course->random * 1664525u + 1013904223u;
  return (double)(course->random >> 8) / (1 << 24);
}

enum { WINDOW = 8 };

/* Trials of turns by up to `most`, so many in a row in each half of the chain; those that do not clash are committed.
 */
static void follow(Course* course, int trials, double most, int inARow) {
  for (int i = 0; i < trials; i++) {
    const int link = 2 + (int)(draw(course) * (SITES / 2 - 1 - inARow));
    ctChange changes[2 * WINDOW];
    for (int k = 0; k < 2 * inARow; k++) {
      const int first = k < inARow ? link : link + SITES / 2 - 2;
      changes[k] = (ctChange){.link = first + k % inARow, .angle = most * (2 * draw(course) - 1)};
    }
    const bool before = course->byCost->clearance.isKept;
    bool clash[2];
    ctCounts counts = {0};
    CHECK_SUCCESS(ctPropose(course->byCost, 2 * inARow, changes));
    CHECK_SUCCESS(ctPropose(course->byTree, 2 * inARow, changes));
    CHECK_SUCCESS(ctTestTrial(course->byCost, &clash[0], NULL, i % 2 == 0 ? &counts : NULL));
    CHECK_SUCCESS(ctTestTrial(course->byTree, &clash[1], NULL, NULL));
    CHECK(clash[0] == clash[1]);
    if (!clash[0]) {
      CHECK_SUCCESS(ctCommit(course->byCost, NULL));
      CHECK_SUCCESS(ctCommit(course->byTree, NULL));
    }
    course->testsByClearance += course->byCost->clearance.isKept;
    course->changesOfMind += course->byCost->clearance.isKept != before;
  }
  CHECK(ctValidate(course->byCost));
}

static void startAnew(Course* course) {
  static double positions[3 * SITES];
  ctChainTree* fresh = makeLattice(ONE_CHAIN, 0.49, 0);
  ctGetPositions(fresh, positions);
  ctDestroy(fresh);
  CHECK_SUCCESS(ctSetPositions(course->byCost, positions));
  CHECK_SUCCESS(ctSetPositions(course->byTree, positions));
}

int main(void) {
  Course course = {.random = 1};
  course.byCost = makeLattice(ONE_CHAIN, 0.49, 0);
  setenv("CHAINTREE_TRIALS", "tree", 1);
  course.byTree = makeLattice(ONE_CHAIN, 0.49, 0);
  int patience = 0;
  for (int phase = 0; phase < 5; phase++) {
    /* Small steps in a dense globule: after some patience by clearances. */
    startAnew(&course);
    course.testsByClearance = 0;
    follow(&course, 8000, 1e-4, 1);
    CHECK(course.testsByClearance > 500);
    /* Large ones, which soon undo it. */
    course.testsByClearance = 0;
    follow(&course, 4000, 2, 1);
    CHECK(course.testsByClearance < 2000);
    patience = course.byCost->clearance.patience > patience ? course.byCost->clearance.patience : patience;
  }
  CHECK(course.changesOfMind >= 10);
  CHECK(patience > 4);
  /* However often they have not paid, they are asked again one day. */
  for (int i = 0; i < 40; i++) {
    ctClearanceGiveUp(&course.byCost->clearance);
  }
  CHECK(course.byCost->clearance.patience > patience && course.byCost->clearance.patience < 100000);
  ctDestroy(course.byCost);
  /* Many pieces in a leaf. */
  setenv("CHAINTREE_TRIALS", "clearances", 1);
  course.byCost = makeLattice(ONE_CHAIN, 0.49, 0);
  course.testsByClearance = 0;
  startAnew(&course);
  for (int i = 0; i < 40; i++) {
    follow(&course, 50, i % 2 == 0 ? 1e-4 : 0.01, WINDOW);
  }
  CHECK(course.testsByClearance == 2000);
  ctDestroy(course.byCost);
  ctDestroy(course.byTree);
  return checkResult();
}
