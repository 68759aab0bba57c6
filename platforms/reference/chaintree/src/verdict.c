/* Trials: propose, test, changed pairs, accept, reject. */
#include <stdlib.h>

#include "definition.h"
#include "scene.h"
#include "wide.h"

/* ---- Propose ---- */

static ctStatus checkChange(ctChainTree* tree, const ctChange* change) {
  const Sequence* s = &tree->sequence;
  if (change->link < 0 || change->link >= s->userLinkCount) {
    return ctFail(tree, ctInvalidArgument, "there is no link %d; there are %d links", change->link, s->userLinkCount);
  }
  const int link = sequenceLink(s, change->link);
  if (s->jointType[link] == ctFixedJoint) {
    return ctFail(tree, ctInvalidArgument, "link %d is fixed and cannot be moved", change->link);
  }
  if (s->jointType[link] == ctTorsionJoint) {
    if (!isfinite(change->angle)) {
      return ctFail(tree, ctInvalidArgument, "the angle given for link %d is not finite", change->link);
    }
    if (s->axisPlaces[link] == axisIsNoLine) {
      return ctFail(tree, ctInvalidArgument, "link %d cannot turn: its axis particles %d and %d are at one place",
                    change->link, s->joint[link].torsion[0], s->joint[link].origin);
    }
  } else if (s->jointType[link] == ctBallJoint) {
    if (!areLengths(change->rotation)) {
      return ctFail(tree, ctInvalidArgument, "the rotation given for link %d " CT_NO_LENGTH " or rad", change->link);
    }
  } else if (!areLengths(change->rotation) || !areLengths(change->pivot) || !areLengths(change->translation)) {
    return ctFail(tree, ctInvalidArgument, "the motion given for link %d " CT_NO_LENGTH " or rad", change->link);
  }
  return ctSuccess;
}

ctStatus ctPropose(ctChainTree* tree, int count, const ctChange* changes) {
  CT_REQUIRE(tree, tree);
  /* More changes than links would name some link twice. */
  if (count < 0 || count > tree->sequence.userLinkCount) {
    return ctFail(tree, ctInvalidArgument, "a trial cannot have %d changes; there are %d links", count,
                  tree->sequence.userLinkCount);
  }
  if (count > 0) {
    CT_REQUIRE(tree, changes);
  }
  ctSceneLooseTree(tree); /* trials start from an up-to-date tree */
  for (int i = 0; i < count; i++) {
    const ctStatus status = checkChange(tree, &changes[i]);
    if (status != ctSuccess) {
      return status;
    }
  }
  if (!ctTrialReserve(tree->next, count > 0 ? count : 1)) {
    return ctFailOutOfMemory(tree);
  }
  /* Each change starts a piece, and another piece may start at its end. */
  if (!ctTraversalReserve(&tree->traversal, 2 * count + 1)) {
    return ctFailOutOfMemory(tree);
  }
  const int twice = ctTrialPropose(tree->next, &tree->sequence, &tree->traversal, changes, count);
  if (twice != CT_NULL) {
    return ctFail(tree, ctInvalidArgument, "link %d is changed twice in one trial", twice);
  }
  for (int i = 0; i < count; i++) {
    const TrialChange* change = &tree->next->changes[i];
    if (tree->sequence.jointType[change->link] == ctFreeJoint && !isJointPosition(change->after.placement.position)) {
      return ctFail(tree, ctInvalidArgument, "the motion given for link %d takes it too far away", change->userLink);
    }
  }
  if (ctTrialMayMerge(tree->next)) {
    ctTrialMerge(tree->next, ctSceneReach(tree), ctSceneTree(tree)->levelCount);
  }
  Trial* dropped = tree->trial;
  tree->trial = tree->next;
  tree->next = dropped;
  tree->next->open = false;
  tree->trialCount++;
  ctClearanceBegin(&tree->clearance);
  return ctSuccess;
}

static int applyTrial(ctChainTree* tree, bool after) {
  return ctTrialApply(tree->trial, after, &tree->sequence, ctSceneLooseTree(tree), &tree->traversal);
}

/* Makes the open trial the state until leaveTrial restores the former one, bit by bit. */
static bool enterTrial(ctChainTree* tree) {
  const bool areLeavesKept = ctLeavesAreOf(&tree->leaves, ctSceneTree(tree));
  applyTrial(tree, true);
  return areLeavesKept;
}

static void leaveTrial(ctChainTree* tree, bool areLeavesKept) {
  applyTrial(tree, false);
  if (areLeavesKept) {
    tree->leaves.revision = ctSceneTree(tree)->revision;
  }
}

static bool addTie(ctChainTree* tree, int slotA, int slotB, double value) {
  SlotPairs* ties = &tree->ties;
  if (ties->count == CT_MOST_COUNT ||
      !ctReserve((void**)&ties->pairs, &ties->capacity, ties->count + 1, sizeof(SlotPair))) {
    return false;
  }
  ties->pairs[ties->count++] = (SlotPair){slotA, slotB, value};
  return true;
}

/* ---- Test ---- */

typedef struct TrialTest {
  ctChainTree* tree;
  bool clash;
  bool failed;
  int slotA;
  int slotB;
} TrialTest;

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
    test->clash = true;
    test->slotA = slotA;
    test->slotB = slotB;
    return clearance;
  }
  test->failed = !addTie(tree, slotA, slotB, limit);
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
  test->clash = true;
  test->slotA = slotA;
  test->slotB = slotB;
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
  const bool areLeavesKept = enterTrial(tree);
  for (int i = 0; i < tree->ties.count && !test->clash; i++) {
    const SlotPair* pair = &tree->ties.pairs[i];
    const double overlap =
        radiusSum(tree, pair->slotA, pair->slotB) - canonicalDistance(tree, pair->slotA, pair->slotB);
    if (overlap > pair->value) {
      test->clash = true;
      test->slotA = pair->slotA;
      test->slotB = pair->slotB;
    }
  }
  leaveTrial(tree, areLeavesKept);
}

/* Searches the whole view for a clash, by clearances or by the tree; returns what that has cost. */
static int64_t search(ctChainTree* tree, const View* view, TrialTest* test, ctCounts* counts) {
  int64_t cost = GAVE_UP;
  if (ctClearanceIsWanted(&tree->clearance, &tree->traversal, view->reach)) {
    const Wide* wide = ctSceneTree(tree)->wide;
    cost = wide->testByClearance(&tree->clearance, &tree->traversal, view, clearanceOf, test, counts);
    if (cost == GAVE_UP) {
      ctClearanceGiveUp(&tree->clearance);
      tree->ties.count = 0;
    }
  }
  if (cost == GAVE_UP) {
    cost = ctTraverse(&tree->traversal, view, testPair, test, counts);
  }
  ctClearanceCharge(&tree->clearance, cost, true);
  return cost;
}

/* Tests a view: asks the recent clashes, then searches. Views in which few slots move are searched at once: that costs
 * little, and such trials rarely clash where earlier ones did. */
static void testView(ctChainTree* tree, const View* view, TrialTest* test, ctCounts* counts) {
  int few[2];
  if (ctViewMovesFew(&tree->traversal, view, &few[0], &few[1])) {
    ctTraverseFew(&tree->traversal, view, few[0], few[1], testPair, surelyClash, test, counts);
    return;
  }
  RecentClashes* recentClashes = &tree->recentClashes;
  const Wide* wide = ctSceneTree(tree)->wide;
  if (ctRecentClashesAreWanted(recentClashes)) {
    int64_t cost = 0;
    const bool isOver = wide->testRecentClashes(recentClashes, &tree->traversal, view, testPair, test, counts, &cost);
    ctRecentClashesCharge(recentClashes, cost, isOver);
    tree->ties.count = 0;
    if (isOver) {
      return;
    }
  }
  const int64_t cost = search(tree, view, test, counts);
  if (test->clash) {
    ctRecentClashesAdd(recentClashes, ctSceneTree(tree), test->slotA, test->slotB, cost);
  }
}

ctStatus ctTestTrial(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts) {
  CT_REQUIRE(tree, clash);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  const double reach = -tree->overlapTolerance;
  View view = ctTrialView(tree->trial, true, true, reach);
  const bool mayBeSkipped = tree->trial->distanceError > 0;
  const bool skips = mayBeSkipped && ctPrepareSkip(tree, counts);
  if (mayBeSkipped && !skips) {
    view.pieces = tree->trial->apart;
    view.pieceCount = tree->trial->apartCount;
  }
  TrialTest test = {tree, false, false, CT_NULL, CT_NULL};
  tree->trial->isFree = false;
  tree->ties.count = 0;
  testView(tree, &view, &test, counts);
  if (test.failed) {
    return ctFailOutOfMemory(tree);
  }
  if (!test.clash && tree->ties.count > 0) {
    testTies(&test);
  }
  tree->trial->isFree = !test.clash;
  tree->trial->isSkipTested = skips;
  *clash = test.clash;
  if (test.clash && pair != NULL) {
    particlesOf(tree, test.slotA, test.slotB, pair);
  }
  return ctSuccess;
}

/* ---- Changed pairs ---- */

typedef struct Collection {
  ctChainTree* tree;
  bool failed;
} Collection;

static bool collect(void* context, int slotA, int slotB, double squaredDistance) {
  (void)squaredDistance;
  Collection* collection = context;
  ctChainTree* tree = collection->tree;
  collection->failed = !addTie(tree, slotA < slotB ? slotA : slotB, slotA < slotB ? slotB : slotA, 0);
  return !collection->failed;
}

static int compareSlotPairs(const void* a, const void* b) {
  const SlotPair* x = a;
  const SlotPair* y = b;
  const int first = (x->slotA > y->slotA) - (x->slotA < y->slotA);
  return first != 0 ? first : (x->slotB > y->slotB) - (x->slotB < y->slotB);
}

static void dropRepeats(SlotPairs* list) {
  if (list->count == 0) {
    return;
  }
  qsort(list->pairs, (size_t)list->count, sizeof(SlotPair), compareSlotPairs);
  int kept = 1;
  for (int i = 1; i < list->count; i++) {
    if (compareSlotPairs(&list->pairs[kept - 1], &list->pairs[i]) != 0) {
      list->pairs[kept++] = list->pairs[i];
    }
  }
  list->count = kept;
}

ctStatus ctForEachChangedPair(ctChainTree* tree, double cutoff, ctChangedPairFunction* function, void* context,
                              ctCounts* counts) {
  CT_REQUIRE(tree, function);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (!(cutoff > 0) || !isfinite(cutoff)) {
    return ctFail(tree, ctInvalidArgument, "the cutoff is %g nm; it must be finite and positive", cutoff);
  }
  /* Collects candidates before and in the trial, then computes both canonical distances of each. */
  Collection collection = {tree, false};
  ctSceneTree(tree);
  tree->ties.count = 0;
  for (int moved = 0; moved < 2 && !collection.failed; moved++) {
    const View view = ctTrialView(tree->trial, moved == 1, false, cutoff);
    int few[2];
    if (ctViewMovesFew(&tree->traversal, &view, &few[0], &few[1])) {
      ctTraverseFew(&tree->traversal, &view, few[0], few[1], collect, NULL, &collection, counts);
    } else {
      ctTraverse(&tree->traversal, &view, collect, &collection, counts);
    }
  }
  if (collection.failed) {
    return ctFailOutOfMemory(tree);
  }
  SlotPairs* pairs = &tree->ties;
  dropRepeats(pairs);
  for (int i = 0; i < pairs->count; i++) {
    pairs->pairs[i].value = canonicalDistance(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB);
  }
  const bool areLeavesKept = enterTrial(tree);
  bool continues = true;
  for (int i = 0; i < pairs->count && continues; i++) {
    const double before = pairs->pairs[i].value;
    const double after = canonicalDistance(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB);
    if (before <= cutoff || after <= cutoff) {
      int pair[2];
      particlesOf(tree, pairs->pairs[i].slotA, pairs->pairs[i].slotB, pair);
      continues = function(context, pair[0], pair[1], before, after);
    }
  }
  leaveTrial(tree, areLeavesKept);
  return ctSuccess;
}

/* ---- End ---- */

ctStatus ctGetTrialPositions(ctChainTree* tree, double* positions) {
  CT_REQUIRE(tree, tree);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (tree->sequence.particleCount > 0) {
    CT_REQUIRE(tree, positions);
  }
  const bool areLeavesKept = enterTrial(tree);
  ctReadPositions(&tree->sequence, ctSceneTree(tree), positions);
  leaveTrial(tree, areLeavesKept);
  return ctSuccess;
}

ctStatus ctGetPositionsOf(ctChainTree* tree, bool inTrial, int count, const int* particles, double* positions) {
  CT_REQUIRE(tree, tree);
  const ctStatus status = ctCheckParticles(tree, count, particles);
  if (status != ctSuccess) {
    return status;
  }
  if (count > 0) {
    CT_REQUIRE(tree, positions);
  }
  if (inTrial && !tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  bool areLeavesKept = false;
  if (inTrial) {
    areLeavesKept = enterTrial(tree);
  }
  PositionReader reader = ctPositionReader(&tree->sequence, ctSceneTree(tree));
  for (int i = 0; i < count; i++) {
    ctReadPosition(&reader, particles[i], positions + 3 * (size_t)i);
  }
  if (inTrial) {
    leaveTrial(tree, areLeavesKept);
  }
  return ctSuccess;
}

ctStatus ctFollowTrialPositions(ctChainTree* tree, bool isNewArray, double* positions) {
  CT_REQUIRE(tree, tree);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (tree->sequence.particleCount > 0) {
    CT_REQUIRE(tree, positions);
  }
  const bool areLeavesKept = enterTrial(tree);
  ctFollowPositions(tree, isNewArray, positions);
  leaveTrial(tree, areLeavesKept);
  return ctSuccess;
}

ctStatus ctAccept(ctChainTree* tree, ctCounts* counts) {
  CT_REQUIRE(tree, tree);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (tree->clearance.isKept) {
    const View view = ctTrialView(tree->trial, true, true, -tree->overlapTolerance);
    const Wide* wide = ctSceneTree(tree)->wide;
    ctClearanceCharge(&tree->clearance, wide->acceptClearances(&tree->clearance, &tree->traversal, &view), false);
  }
  const Trial* trial = tree->trial;
  const bool leavesFollow = trial->distanceError > 0 && ctLeavesAreOf(&tree->leaves, ctSceneTree(tree));
  ctSkippedAccept(tree);
  ctClearanceSkip(&tree->clearance, trial->distanceError);
  const int updated = applyTrial(tree, true);
  if (leavesFollow) {
    ctLeavesFollow(&tree->leaves, ctSceneTree(tree), &tree->sequence, trial->pieceCount, trial->pieces,
                   trial->distanceError);
  }
  tree->trial->open = false;
  tree->changeCount++;
  tree->acceptedCount++;
  if (counts != NULL) {
    addCount(&counts->nodesUpdated, updated);
  }
  return ctSuccess;
}

void ctReject(ctChainTree* tree) {
  if (tree != NULL) {
    tree->trial->open = false;
  }
}

bool ctHasTrial(const ctChainTree* tree) {
  return tree != NULL && tree->trial->open;
}

int64_t ctGetTrialCount(const ctChainTree* tree) {
  return tree != NULL ? tree->trialCount : 0;
}

int64_t ctGetAcceptedCount(const ctChainTree* tree) {
  return tree != NULL ? tree->acceptedCount : 0;
}

int64_t ctGetChangeCount(const ctChainTree* tree) {
  return tree != NULL ? tree->changeCount : 0;
}

double ctGetTotalShift(const ctChainTree* tree) {
  return tree != NULL ? tree->skipped.total : 0;
}
