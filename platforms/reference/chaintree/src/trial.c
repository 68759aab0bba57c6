/* Trials: propose, test, accept, reject. */
#include <stdlib.h>
#include <string.h>

#include "definition.h"
#include "scene.h"

bool ctTrialReserve(Trial* trial, int count) {
  if (count <= trial->capacity) {
    return true;
  }
  /* Each array keeps its contents if a later one cannot grow, so the old capacity stays right. */
  int capacity[9];
  for (int i = 0; i < 9; i++) {
    capacity[i] = trial->capacity;
  }
  if (!ctReserve((void**)&trial->changes, &capacity[0], count, sizeof(TrialChange)) ||
      !ctReserve((void**)&trial->pieces, &capacity[1], count, sizeof(Piece[3])) ||
      !ctReserve((void**)&trial->motions, &capacity[2], count, sizeof(Frame[2])) ||
      !ctReserve((void**)&trial->links, &capacity[3], count, sizeof(int)) ||
      !ctReserve((void**)&trial->bodyOf, &capacity[4], count, sizeof(int[2])) ||
      !ctReserve((void**)&trial->scratch, &capacity[5], count, sizeof(int)) ||
      !ctReserve((void**)&trial->worldMotions, &capacity[6], count, sizeof(ctTransform[2])) ||
      !ctReserve((void**)&trial->userLinks, &capacity[7], count, sizeof(int)) ||
      !ctReserve((void**)&trial->apart, &capacity[8], count, sizeof(Piece[3]))) {
    return false;
  }
  trial->capacity = count;
  trial->motions[0] = transformIdentity();
  return true;
}

void ctTrialFree(Trial* trial) {
  free(trial->changes);
  free(trial->displacements);
  free(trial->displaced);
  free(trial->inLeaf);
  free(trial->pieces);
  free(trial->motions);
  free(trial->links);
  free(trial->bodyOf);
  free(trial->scratch);
  free(trial->worldMotions);
  free(trial->userLinks);
  free(trial->apart);
  *trial = (Trial){0};
}

/* ---- Motions ---- */

/* The frame of a link in the world, if that in its leaf is known. */
static Frame linkFromLeaf(const Sequence* sequence, World* w, int link, const Frame* inLeaf) {
  return transformCompose(ctWorldLeafFrame(w, coveringNode(sequence->slotBegin[link])), inLeaf);
}

static Frame linkFrame(const Sequence* sequence, World* w, int link) {
  const Frame inLeaf = ctTreeLinkInLeaf(w->tree, sequence, link);
  return linkFromLeaf(sequence, w, link, &inLeaf);
}

/* Turns a torsion about its axis in the world. Where its state is an angle, the placements of its states stay
 * undefined: nobody reads them. */
static void turnTorsion(TrialChange* change, const Sequence* s, World* w, Frame* motion) {
  const double angle = change->given->angle;
  double point[3];
  double axis[3];
  const Frame* leaf = ctWorldLeafFrame(w, coveringNode(s->slotBegin[change->link]));
  treeAxis(w->tree, s, change->link, point, axis);
  transformPoint(leaf, point, point);
  rotate(leaf, axis, axis);
  const Angle half = angleOfAny(0.5 * angle);
  const double factor = half.sine / sqrt(dot(axis, axis));
  Frame turn;
  rotationFromUnit(half.cosine, factor * axis[0], factor * axis[1], factor * axis[2], turn.m[0], 1);
  transformAbout(point, &turn);
  *motion = turn;
  if (s->isFlexible) {
    change->isPending = true;
    change->angle = angle;
  } else {
    change->before.angle = s->angle[change->link];
    change->after.angle = ctAngleTurned(change->before.angle, angle);
  }
}

/* Where the particle is about which a ball joint turns, in the world. */
static void findJointCentre(const Sequence* s, World* w, int link, double pivot[3]) {
  const int particle = s->joint[link].origin;
  const int slot = particleSlot(s, particle);
  if (slot != CT_NULL) {
    treeLocal(w->tree, slot, pivot);
    transformPoint(ctWorldLeafFrame(w, coveringNode(slot)), pivot, pivot);
  } else if (s->isFlexible) {
    const int holder = particleLink(s, particle);
    const Frame own = linkFrame(s, w, holder);
    sequenceLocal(s, holder, particle, pivot);
    transformPoint(&own, pivot, pivot);
  } else {
    const Frame own = linkFrame(s, w, link);
    translationOf(&own, pivot);
  }
}

/* Turns a ball joint about its pivot. */
CT_NOINLINE void turnBall(TrialChange* change, const Sequence* s, World* w, Frame* motion) {
  const double* rotation = change->given->rotation;
  double turn[4];
  double pivot[3];
  quaternionFromVector(rotation, turn);
  rotationFromQuaternion(turn, motion);
  findJointCentre(s, w, change->link, pivot);
  transformAbout(pivot, motion);
  memcpy(change->rotation, rotation, sizeof change->rotation);
  change->isPending = true;
}

/* Finds the states of joints before and after the trial that are not known yet. A ball joint takes a walk: so this
 * waits until a trial is applied, since most clash. The tree must be that of the state before. If there is one walk,
 * the update of the tree starts where it ends. */
static void findStates(Trial* trial, const Sequence* s, Tree* tree, World* w) {
  for (int i = 0; i < trial->count; i++) {
    TrialChange* change = &trial->changes[i];
    if (!change->isPending) {
      continue;
    }
    change->isPending = false;
    change->before = ctSequenceGetJoint(s, change->link);
    if (s->jointType[change->link] == ctTorsionJoint) {
      change->after = ctTorsionTurned(s, change->link, change->angle);
      continue;
    }
    const int link = s->parent[change->link];
    const bool isKept = trial->count == 1 && s->sideBranchPart[link] == notInSideBranch;
    const Frame inLeaf = isKept ? ctTreeKnowLink(tree, s, link, change->link) : ctTreeLinkInLeaf(tree, s, link);
    const Frame parent = linkFromLeaf(s, w, link, &inLeaf);
    double rotation[3];
    rotateBack(&parent, change->rotation, rotation);
    change->after = s->isFlexible ? ctBallTurned(s, change->link, rotation) : ctJointTurned(&change->before, rotation);
  }
}

/* Moves a free joint. The change is given in the world; the joint's state is in the parent's frame. */
CT_NOINLINE void moveFreely(TrialChange* change, const Sequence* s, World* w, Frame* motion) {
  const ctChange* given = change->given;
  double turn[4];
  quaternionFromVector(given->rotation, turn);
  rotationFromQuaternion(turn, motion);
  double pivot[3];
  double wrapped[3];
  ctSequenceLinkShift(s, change->link, wrapped);
  subtract(given->pivot, s->worldOrigin, pivot);
  add(pivot, wrapped);
  transformAbout(pivot, motion);
  for (int k = 0; k < 3; k++) {
    motion->m[k][3] += given->translation[k];
  }

  const Frame parent = linkFrame(s, w, s->parent[change->link]);
  double rotation[3];
  double shift[3];
  rotateBack(&parent, given->rotation, rotation);
  rotateBack(&parent, given->translation, shift);
  transformPointBack(&parent, pivot, pivot);
  change->after = ctJointMoved(&change->before, rotation, pivot, shift);
  if (isWrapped(s, change->link)) {
    ctJointWrap(s, &change->after, wrapped);
    for (int k = 0; k < 3; k++) {
      motion->m[k][3] += wrapped[k];
    }
  }
}

/* ---- Pieces ---- */

/* Cuts the sequence into pieces, and composes motions with those around them. The intervals of the changes are nested
 * or disjoint: a stack holds the open ones. */
CT_NOINLINE void cutPieces(Trial* trial, const Sequence* s) {
  int* open = trial->scratch;
  int* bodyOf = trial->bodyOf;
  int depth = 0;
  trial->pieceCount = 0;
  trial->motionCount = trial->count + 1;
  addPiece(trial, 0, 0);
  for (int i = 0; i <= trial->count; i++) {
    const int next = i < trial->count ? trial->changes[i].link : s->linkCount;
    while (depth > 0 && sequenceEnd(s, open[depth - 1]) <= next) {
      const int end = sequenceEnd(s, open[--depth]);
      if (end < s->linkCount) {
        addPiece(trial, s->slotBegin[end], depth > 0 ? bodyOf[depth - 1] : 0);
      }
    }
    if (i < trial->count) {
      const TrialChange* change = &trial->changes[i];
      const int around = depth > 0 ? bodyOf[depth - 1] : 0;
      if (around != 0) {
        trial->motions[i + 1] = transformCompose(&trial->motions[around], &trial->motions[i + 1]);
      }
      bodyOf[depth] = i + 1; /* the motion that goes with the open interval */
      open[depth++] = change->link;
      addPiece(trial, s->slotBegin[change->link], i + 1);
    }
  }
}

/* The same for one change: what stands before its interval, the interval, and what stands behind it. */
static void cutAround(Trial* trial, const Sequence* s) {
  const int link = trial->changes[0].link;
  const int end = sequenceEnd(s, link);
  trial->motionCount = 2;
  trial->pieces[0] = (Piece){0, 0};
  trial->pieceCount = s->slotBegin[link] > 0;
  trial->pieces[trial->pieceCount++] = (Piece){s->slotBegin[link], 1};
  if (end < s->linkCount) {
    trial->pieces[trial->pieceCount++] = (Piece){s->slotBegin[end], 0};
  }
}

/* ---- Changes ---- */

static int compareChanges(const void* a, const void* b) {
  const int x = ((const TrialChange*)a)->link;
  const int y = ((const TrialChange*)b)->link;
  return (x > y) - (x < y);
}

/* Sorts the changes by link; returns the caller's link that is changed twice, or CT_NULL. */
CT_NOINLINE int sortChanges(Trial* trial) {
  bool isAscending = true;
  for (int i = 1; i < trial->count && isAscending; i++) {
    isAscending = trial->changes[i - 1].link <= trial->changes[i].link;
  }
  if (!isAscending) {
    qsort(trial->changes, (size_t)trial->count, sizeof(TrialChange), compareChanges);
  }
  for (int i = 0; i < trial->count; i++) {
    trial->links[i] = trial->changes[i].link;
    if (i > 0 && trial->links[i] == trial->links[i - 1]) {
      return trial->changes[i].userLink;
    }
  }
  return CT_NULL;
}

/* Computes joint states, motions and pieces of the caller's `given` changes, for which there is room, from the state.
 * Returns the caller's link that is changed twice, or CT_NULL. */
static int describeTrial(Trial* trial, const Sequence* s, World* w, const ctChange* given, int count) {
  trial->count = count;
  trial->displacementCount = 0;
  for (int i = 0; i < count; i++) {
    TrialChange* change = &trial->changes[i];
    change->link = sequenceLink(s, given[i].link);
    change->userLink = given[i].link;
    change->isPending = false;
    change->given = &given[i];
    trial->links[i] = change->link;
  }
  const int twice = count > 1 ? sortChanges(trial) : CT_NULL;
  if (twice != CT_NULL) {
    return twice;
  }
  for (int i = 0; i < count; i++) {
    TrialChange* change = &trial->changes[i];
    Frame* motion = &trial->motions[i + 1]; /* of the link in the world, if this were the only change */
    if (s->jointType[change->link] == ctTorsionJoint) {
      turnTorsion(change, s, w, motion);
    } else if (s->jointType[change->link] == ctBallJoint) {
      turnBall(change, s, w, motion);
    } else {
      change->before = ctSequenceGetJoint(s, change->link);
      moveFreely(change, s, w, motion);
    }
  }
  if (count == 1) {
    cutAround(trial, s);
  } else {
    cutPieces(trial, s);
  }
  resetTrial(trial);
  return CT_NULL;
}

/* ---- Views of a trial ---- */

View ctTrialView(const Trial* trial, double reach) {
  return (View){trial->pieces, trial->pieceCount, trial->motions, trial->motionCount, reach, trial->motions, false};
}

/* The motion of a frame, which is from worldOrigin, for absolute positions: x -> R (x - o) + t + o. */
static ctTransform worldMotion(const Frame* motion, const double origin[3]) {
  ctTransform world;
  double turned[3];
  rotate(motion, origin, turned);
  for (int i = 0; i < 3; i++) {
    memcpy(world.rotation + 3 * i, motion->m[i], 3 * sizeof(double));
    world.translation[i] = motion->m[i][3] + (origin[i] - turned[i]);
  }
  return world;
}

void ctTrialShow(Trial* trial, const Sequence* s) {
  if (trial->isShown) {
    return;
  }
  trial->worldMotions[0] = (ctTransform){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  for (int i = 1; i < trial->motionCount; i++) {
    trial->worldMotions[i] = worldMotion(&trial->motions[i], s->worldOrigin);
  }
  for (int i = 0; i < trial->count; i++) {
    trial->userLinks[i] = trial->changes[i].userLink;
  }
  trial->isShown = true;
}

/* ---- Propose ---- */

/* True if the axis particles of a torsion are apart, in a flexible scene. */
CT_NOINLINE bool hasAxisNow(const ctChainTree* tree, int link) {
  double point[3];
  double axis[3];
  treeAxis(&tree->ownTree, &tree->sequence, link, point, axis);
  return dot(axis, axis) > 0;
}

/* True if a torsion has an axis about which it can turn. */
static bool canTurn(const ctChainTree* tree, int link) {
  const Sequence* s = &tree->sequence;
  return s->isFlexible ? hasAxisNow(tree, link) : s->axisPlaces[link] != axisIsNoLine;
}

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
    if (!canTurn(tree, link)) {
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
  const int twice = describeTrial(tree->next, &tree->sequence, &tree->world, changes, count);
  if (twice != CT_NULL) {
    return ctFail(tree, ctInvalidArgument, "link %d is changed twice in one trial", twice);
  }
  for (int i = 0; i < count; i++) {
    const TrialChange* change = &tree->next->changes[i];
    if (tree->sequence.jointType[change->link] == ctFreeJoint && !isJointPosition(change->after.placement.position)) {
      return ctFail(tree, ctInvalidArgument, "the motion given for link %d takes it too far away", change->userLink);
    }
  }
  if (ctMayMerge(tree->next)) {
    ctMergeBodies(tree->next, ctSceneReach(tree), ctSceneTree(tree)->levelCount);
  }
  ctTrialOpen(tree);
  return ctSuccess;
}

void ctTrialOpen(ctChainTree* scene) {
  Trial* dropped = scene->trial;
  scene->trial = scene->next;
  scene->next = dropped;
  scene->next->open = false;
  scene->trialCount++;
}

/* ---- Apply ---- */

/* Sets the joints to their states after or before the trial, and updates sequence and tree; returns how many nodes were
 * recomputed. After that, applying the state before restores every bit, since everything is a function of the state. */
static int applyTrial(ctChainTree* scene, bool after) {
  Trial* trial = scene->trial;
  Sequence* s = &scene->sequence;
  Tree* tree = ctSceneLooseTree(scene);
  if (trial->displacementCount > 0) {
    return ctDisplacementsApply(scene, after);
  }
  if (after) {
    findStates(trial, s, tree, &scene->world);
  }
  for (int i = 0; i < trial->count; i++) {
    const TrialChange* change = &trial->changes[i];
    ctSequenceSetJoint(s, change->link, after ? &change->after : &change->before);
  }
  const int products = ctSequenceUpdate(s, trial->links, trial->count, trial->scratch);
  const int nodes = ctTreeUpdate(tree, s, trial->links, trial->count);
  tree->knownLink = CT_NULL;
  return products + nodes;
}

bool ctSceneEnterTrial(ctChainTree* tree) {
  const bool areLeavesKept = ctLeavesAreOf(&tree->leaves, ctSceneTree(tree));
  applyTrial(tree, true);
  return areLeavesKept;
}

void ctSceneLeaveTrial(ctChainTree* tree, bool areLeavesKept) {
  applyTrial(tree, false);
  if (areLeavesKept) {
    tree->leaves.builtFrom = ctSceneTree(tree)->changes.now;
  }
}

/* ---- Test ---- */

ctStatus ctTestTrial(ctChainTree* tree, bool* clash, int pair[2], ctCounts* counts) {
  CT_REQUIRE(tree, clash);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  const double reach = -tree->overlapTolerance;
  View view = ctTrialView(tree->trial, reach);
  const bool mayBeSkipped = tree->trial->distanceError > 0;
  const bool skips = mayBeSkipped && ctPrepareSkip(tree, counts);
  if (mayBeSkipped && !skips) {
    view.pieces = tree->trial->apart;
    view.pieceCount = tree->trial->apartCount;
  }
  tree->trial->isFree = false;
  int slots[2];
  const Outcome outcome = ctTestView(tree, &view, slots, counts);
  if (outcome == failed) {
    return ctFailOutOfMemory(tree);
  }
  *clash = outcome == isClash;
  tree->trial->isFree = !*clash;
  tree->trial->isSkipTested = skips;
  if (*clash && pair != NULL) {
    particlesOf(tree, slots[0], slots[1], pair);
  }
  return ctSuccess;
}

/* ---- Accept and reject ---- */

/* True if positions of leaves need an update only where this trial moves something: the rest is another molecule, or
 * lies behind a closed window, and moves by rounding alone. */
static bool movesFewLeaves(ctChainTree* tree, const Trial* trial) {
  const bool endsStatic =
      trial->displacementCount == 0 && trial->pieceCount > 1 && trial->pieces[trial->pieceCount - 1].body == 0;
  const bool otherMoleculesStay = endsStatic && tree->sequence.branchCount > 1 && tree->leaves.boxes != NULL;
  return (trial->distanceError > 0 || otherMoleculesStay) && ctLeavesAreOf(&tree->leaves, ctSceneTree(tree));
}

ctStatus ctAccept(ctChainTree* tree, ctCounts* counts) {
  CT_REQUIRE(tree, tree);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  ctTestersAccept(tree);
  const Trial* trial = tree->trial;
  const bool leavesFollow = movesFewLeaves(tree, trial);
  ctMergedAccept(tree);
  const int updated = applyTrial(tree, true);
  if (leavesFollow) {
    ctLeavesFollow(&tree->leaves, ctSceneWorld(tree), &tree->sequence, trial);
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
  return tree != NULL ? tree->merged.total : 0;
}
