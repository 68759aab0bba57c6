#include "tester.h"

#include <stdlib.h>
#include <string.h>

#include "scene.h"
#include "wide.h"

/* A test of the open trial. */
typedef struct TrialTest {
  ctChainTree* tree;
  const View* view;
  ctCounts* counts;
  bool clash;
  bool failed;
  int slotA; /* that clash */
  int slotB;
  Image image; /* of slotA */
} TrialTest;

/* ---- Pairs ---- */

/* The image of the first slot that is tested now. */
static Image imageNow(const ctChainTree* tree) {
  return tree->traversal.image != NULL ? *tree->traversal.image : (Image){{0}, {0}};
}

static void noteClash(TrialTest* test, int slotA, int slotB) {
  test->clash = true;
  test->slotA = slotA;
  test->slotB = slotB;
  test->image = imageNow(test->tree);
}

/* Allowed overlap: the pair's own limit, else the tolerance. */
static double limitAt(const ctChainTree* tree, int slotA, int slotB, double overlap) {
  const double tolerance = pairTolerance(tree, slotA, slotB);
  if (overlap <= tolerance || tree->limits.count == 0) {
    return tolerance;
  }
  int pair[2];
  particlesOf(tree, slotA, slotB, pair);
  return ctLimitsFind(&tree->limits, pair[0], pair[1], tolerance);
}

/* The clearance of two particles. If they are of two bodies, notes a clash, or a pair about which the canonical
 * distance must decide. */
static double clearanceOf(void* context, int slotA, int slotB, double squaredDistance, bool ofTwoBodies) {
  TrialTest* test = context;
  ctChainTree* tree = test->tree;
  const double tieBand = tree->traversal.tieBand;
  const double overlap = radiusSum(tree, slotA, slotB) - sqrt(squaredDistance);
  const double limit = limitAt(tree, slotA, slotB, overlap + tieBand);
  const double clearance = limit - overlap;
  if (!ofTwoBodies || clearance >= tieBand) {
    return clearance;
  }
  if (clearance < -tieBand) {
    noteClash(test, slotA, slotB);
    return clearance;
  }
  SlotPair pair = {.slotA = slotA, .slotB = slotB, .value = limit};
  const Image image = imageNow(tree);
  memcpy(pair.n, image.n, sizeof pair.n);
  test->failed = !ctSlotPairsAdd(&tree->ties, &pair);
  return test->failed ? -1 : 0;
}

/* Notes a clash of two particles of two bodies if they clash at any distance up to this. */
static bool surelyClash(void* context, int slotA, int slotB, double farthest) {
  TrialTest* test = context;
  const ctChainTree* tree = test->tree;
  const double overlap = radiusSum(tree, slotA, slotB) - farthest - tree->traversal.tieBand;
  if (!(overlap > limitAt(tree, slotA, slotB, overlap))) {
    return false;
  }
  noteClash(test, slotA, slotB);
  return true;
}

static bool testPair(void* context, int slotA, int slotB, double squaredDistance) {
  return clearanceOf(context, slotA, slotB, squaredDistance, true) >= 0;
}

/* Decides about pairs within rounding of their limits, by the canonical distance that they would have after an accepted
 * trial.
 */
static void testTies(TrialTest* test) {
  ctChainTree* tree = test->tree;
  const bool areLeavesKept = ctSceneEnterTrial(tree);
  for (int i = 0; i < tree->ties.count && !test->clash; i++) {
    const SlotPair* pair = &tree->ties.pairs[i];
    const Image image = ctImageOf(&tree->sequence.box, pair->n);
    tree->traversal.image = isImage(&image) ? &image : NULL;
    const double overlap =
        radiusSum(tree, pair->slotA, pair->slotB) - canonicalDistance(tree, pair->slotA, pair->slotB);
    if (overlap > pair->value) {
      noteClash(test, pair->slotA, pair->slotB);
    }
  }
  tree->traversal.image = NULL;
  ctSceneLeaveTrial(tree, areLeavesKept);
}

/* ---- Testers ---- */

static Outcome decided(const TrialTest* test) {
  return test->failed ? failed : test->clash ? isClash : isFree;
}

/* Costs little, and such trials rarely clash where earlier ones did. Needs no tight bounds. */
static Outcome testFewMovers(TrialTest* test) {
  Traversal* traversal = &test->tree->traversal;
  int few[2];
  if (!ctViewMovesFew(traversal, test->view, &few[0], &few[1])) {
    return undecided;
  }
  ctTraverseFew(traversal, test->view, few[0], few[1], testPair, surelyClash, test, test->counts);
  return decided(test);
}

static Outcome testRecentClashes(TrialTest* test) {
  ctChainTree* tree = test->tree;
  RecentClashes* recent = &tree->recentClashes;
  const Wide* wide = ctSceneTree(tree)->wide;
  if (!ctRecentClashesAreWanted(recent)) {
    return undecided;
  }
  int64_t cost = 0;
  const bool isOver =
      wide->testRecentClashes(recent, &tree->traversal, test->view, testPair, test, test->counts, &cost);
  ctRecentClashesCharge(recent, cost, isOver);
  return isOver ? decided(test) : undecided;
}

/* Ends a test of the whole view, from whose cost the choice of testers learns. */
static Outcome endSearch(const TrialTest* test, int64_t cost) {
  ctChainTree* tree = test->tree;
  ctClearanceCharge(&tree->clearance, cost, true);
  if (test->clash) {
    ctRecentClashesAdd(&tree->recentClashes, ctSceneTree(tree), test->slotA, test->slotB, &test->image, cost);
  }
  return decided(test);
}

static Outcome testClearances(TrialTest* test) {
  ctChainTree* tree = test->tree;
  Clearance* clearance = &tree->clearance;
  const Wide* wide = ctSceneTree(tree)->wide;
  if (!ctClearanceIsWanted(clearance, &tree->traversal, test->view->reach, tree->isTesterOff[DESCENT])) {
    return undecided;
  }
  ctClearanceDropTests(clearance);
  clearance->testedTrial = tree->trialCount;
  const int64_t cost = wide->testByClearance(clearance, &tree->traversal, test->view, clearanceOf, test, test->counts);
  if (cost == GAVE_UP) {
    ctClearanceGiveUp(clearance);
    return undecided;
  }
  return endSearch(test, cost);
}

static void acceptClearances(ctChainTree* tree) {
  Clearance* clearance = &tree->clearance;
  if (!clearance->isKept) {
    return;
  }
  if (clearance->testedTrial != tree->trialCount) {
    ctClearanceDropTests(clearance);
  }
  const View view = ctTrialView(tree->trial, -tree->overlapTolerance);
  const Wide* wide = ctSceneTree(tree)->wide;
  ctClearanceCharge(clearance, wide->acceptClearances(clearance, &tree->traversal, &view), false);
  ctClearanceSkip(clearance, tree->trial->distanceError);
}

static void forgetClearances(ctChainTree* tree) {
  ctClearanceForget(&tree->clearance);
}

static Outcome testByDescent(TrialTest* test) {
  ctChainTree* tree = test->tree;
  ctSceneTree(tree);
  return endSearch(test, ctTraverse(&tree->traversal, test->view, testPair, test, test->counts));
}

/* Tests pairs of the view with its periodic images. `isPlaced`: as in ctTraverseImages. */
static Outcome testImages(TrialTest* test, bool isPlaced) {
  ctChainTree* tree = test->tree;
  Traversal* traversal = &tree->traversal;
  const PeriodicBox* box = &tree->sequence.box;
  int few[2];
  if (!tree->isTesterOff[FEW_MOVERS] && ctViewMovesFew(traversal, test->view, &few[0], &few[1])) {
    ctTraverseFewImages(traversal, test->view, box, few[0], few[1], testPair, test, test->counts);
  } else {
    const Tree* own = ctSceneTree(tree);
    const int64_t cost = ctTraverseImages(traversal, test->view, box, isPlaced, testPair, test, test->counts);
    if (test->clash) {
      ctRecentClashesAdd(&tree->recentClashes, own, test->slotA, test->slotB, &test->image, cost);
    }
  }
  return decided(test);
}

/* `accept` and `forget` update what a tester has stored about the state; NULL: nothing is stored. */
typedef struct Tester {
  const char* name;
  Outcome (*test)(TrialTest* test);
  void (*accept)(ctChainTree* tree); /* before the open trial becomes the state */
  void (*forget)(ctChainTree* tree); /* the state or the limits have changed otherwise */
} Tester;

static const Tester testers[TESTER_COUNT] = {
    [FEW_MOVERS] = {"fewMovers", testFewMovers, NULL, NULL},
    [RECENT_CLASHES] = {"recentClashes", testRecentClashes, NULL, NULL},
    [CLEARANCES] = {"clearances", testClearances, acceptClearances, forgetClearances},
    [DESCENT] = {"descent", testByDescent, NULL, NULL},
};

Outcome ctTestView(ctChainTree* tree, const View* view, int slots[2], ctCounts* counts) {
  TrialTest test = {.tree = tree, .view = view, .counts = counts};
  Outcome outcome = undecided;
  int last = DESCENT;
  for (int i = 0; i < TESTER_COUNT && outcome == undecided; i++) {
    tree->ties.count = 0;
    if (!tree->isTesterOff[i]) {
      outcome = testers[i].test(&test);
      last = i;
    }
  }
  if (outcome == undecided) {
    outcome = testByDescent(&test);
    last = DESCENT;
  }
  if (outcome == isFree && tree->sequence.box.isPeriodic) {
    outcome = testImages(&test, last == DESCENT);
  }
  if (outcome == isFree && tree->ties.count > 0) {
    testTies(&test);
    outcome = decided(&test);
  }
  slots[0] = test.slotA;
  slots[1] = test.slotB;
  return outcome;
}

void ctTestersAccept(ctChainTree* tree) {
  for (int i = 0; i < TESTER_COUNT; i++) {
    if (testers[i].accept != NULL) {
      testers[i].accept(tree);
    }
  }
}

void ctTestersForget(ctChainTree* tree) {
  for (int i = 0; i < TESTER_COUNT; i++) {
    if (testers[i].forget != NULL) {
      testers[i].forget(tree);
    }
  }
}

/* ---- The choice of testers ---- */

void ctChooseTesters(ctChainTree* tree) {
  const char* wanted = getenv("CHAINTREE_TRIALS");
  if (wanted == NULL) {
    return;
  }
  const bool byBoxes = strcmp(wanted, "boxes") == 0;
  const bool byTree = byBoxes || strcmp(wanted, "tree") == 0;
  const bool byClearances = strcmp(wanted, "clearances") == 0;
  tree->isTesterOff[FEW_MOVERS] = byTree || byClearances;
  tree->isTesterOff[CLEARANCES] = byTree;
  tree->isTesterOff[DESCENT] = byClearances;
  tree->traversal.alwaysBoxes = byBoxes;
}

bool ctSwitchTester(ctChainTree* tree, const char* name, bool isOn) {
  for (int i = 0; i < TESTER_COUNT; i++) {
    if (strcmp(testers[i].name, name) == 0) {
      tree->isTesterOff[i] = !isOn;
      return true;
    }
  }
  return false;
}
