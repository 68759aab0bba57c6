/* A descent keeps world coordinates of some leaves and of some nodes that move, and recomputes replaced ones. A scene
 * that can keep hardly any gives the same results and the same counts. Looks inside the engine. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../src/descent.h"
#include "../src/scene.h"
#include "lattice.h"

enum { TRIALS = 400, ENTRIES = 2 };

typedef struct Answers {
  bool clash;
  double changed; /* distances before and after, of all pairs, with weights */
  int changedCount;
  double nearest;
  int nearestPair[2];
  int touched;
  ctCounts counts;
} Answers;

static bool addChanged(void* context, int particle1, int particle2, double before, double after) {
  Answers* answers = context;
  answers->changed += (particle1 + 2 * particle2) * before - particle2 * after;
  answers->changedCount++;
  return true;
}

static bool countTouched(void* context, int particle, double overlap) {
  (void)particle;
  (void)overlap;
  ++*(int*)context;
  return true;
}

static ctSelection* selectHalf(ctChainTree* tree, int begin) {
  int particles[SITES / 2];
  for (int i = 0; i < SITES / 2; i++) {
    particles[i] = begin + i;
  }
  ctSelection* selection;
  CHECK_SUCCESS(ctSelect(tree, SITES / 2, particles, &selection));
  return selection;
}

static Answers ask(ctChainTree* tree, ctSelection* halves[2], int trial) {
  const int first = 2 + trial * 37 % (SITES - 3);
  const ctChange changes[3] = {{.link = first, .angle = (trial % 3 == 0 ? 1e-3 : 0.3) * sin(trial)},
                               {.link = (first + 5) % (SITES - 2) + 2, .angle = -0.01 * cos(trial)},
                               {.link = (first + 300) % (SITES - 2) + 2, .angle = 0.02}};
  const double middle[3] = {4, 4, 4};
  Answers answers = {0};
  CHECK_SUCCESS(ctPropose(tree, trial % 5 == 0 ? 3 : trial % 2 == 0 ? 2 : 1, changes));
  CHECK_SUCCESS(ctTestTrial(tree, &answers.clash, NULL, &answers.counts));
  if (trial % 4 == 0) {
    CHECK_SUCCESS(ctForEachChangedPair(tree, 1.3, addChanged, &answers, &answers.counts));
  }
  if (answers.clash) {
    ctReject(tree);
  } else {
    CHECK_SUCCESS(ctAccept(tree, &answers.counts));
  }
  if (trial % 10 == 0) {
    CHECK_SUCCESS(
        ctGetMinimumDistance(tree, halves[0], halves[1], &answers.nearest, answers.nearestPair, &answers.counts));
    CHECK_SUCCESS(ctForEachClashWith(tree, middle, 2.5, countTouched, &answers.touched, &answers.counts));
  }
  return answers;
}

/* A trial of the last beads alone, right after whatever was accepted before. */
static Answers askTip(ctChainTree* tree, int trial) {
  const ctChange tip = {.link = SITES - 10 - trial % 12, .angle = 2 * sin(3 * trial)};
  Answers answers = {0};
  CHECK_SUCCESS(ctPropose(tree, 1, &tip));
  CHECK_SUCCESS(ctTestTrial(tree, &answers.clash, NULL, &answers.counts));
  ctReject(tree);
  return answers;
}

static void testMethod(const char* method) {
  setenv("CHAINTREE_TRIALS", method, 1);
  ctChainTree* trees[2];
  ctSelection* halves[2][2];
  for (int i = 0; i < 2; i++) {
    trees[i] = makeLattice(ONE_CHAIN, 0.45, 0);
    halves[i][0] = selectHalf(trees[i], 0);
    halves[i][1] = selectHalf(trees[i], SITES / 2);
  }
  CHECK(trees[0]->world.leafEntryCount * TREE_WIDTH >= SITES &&
        trees[0]->traversal.movedCapacity >= SITES / TREE_WIDTH);
  trees[1]->world.leafEntryCount = ENTRIES;
  trees[1]->traversal.movedCapacity = ENTRIES;
  trees[1]->traversal.movedBoxesCapacity = BOXES_PER_VISIT;
  int clashing = 0;
  int tipsClashing = 0;
  for (int trial = 0; trial < TRIALS; trial++) {
    trees[1]->traversal.firstNodesFrom = NO_REVISION;
    const Answers tips[2] = {askTip(trees[0], trial), askTip(trees[1], trial)};
    CHECK(tips[0].clash == tips[1].clash);
    CHECK(tips[0].counts.particleTests == tips[1].counts.particleTests);
    tipsClashing += tips[0].clash;
    const Answers a = ask(trees[0], halves[0], trial);
    const Answers b = ask(trees[1], halves[1], trial);
    CHECK(a.clash == b.clash && a.changedCount == b.changedCount && a.touched == b.touched);
    CHECK(a.changed == b.changed && a.nearest == b.nearest);
    CHECK(a.nearestPair[0] == b.nearestPair[0] && a.nearestPair[1] == b.nearestPair[1]);
    CHECK(a.counts.volumeTests == b.counts.volumeTests && a.counts.particleTests == b.counts.particleTests);
    clashing += a.clash;
  }
  CHECK(clashing > TRIALS / 20 && clashing < TRIALS - TRIALS / 20);
  CHECK(tipsClashing > TRIALS / 20 && tipsClashing < TRIALS - TRIALS / 20);
  CHECK(ctValidate(trees[0]) && ctValidate(trees[1]));
  for (int i = 0; i < 2; i++) {
    ctFreeSelection(halves[i][0]);
    ctFreeSelection(halves[i][1]);
    ctDestroy(trees[i]);
  }
}

int main(void) {
  testMethod("");
  testMethod("tree");
  testMethod("boxes");
  testMethod("clearances");
  return checkResult();
}
