#include "trial.h"

#include <stdlib.h>
#include <string.h>

bool ctTrialReserve(Trial* trial, int count) {
  if (count <= trial->capacity) {
    return true;
  }
  /* Each array keeps its contents if a later one cannot grow, so the old capacity stays right. */
  int capacity[8];
  for (int i = 0; i < 8; i++) {
    capacity[i] = trial->capacity;
  }
  if (!ctReserve((void**)&trial->changes, &capacity[0], count, sizeof(TrialChange)) ||
      !ctReserve((void**)&trial->pieces, &capacity[1], count, sizeof(Piece[3])) ||
      !ctReserve((void**)&trial->motions, &capacity[2], count, sizeof(Frame[2])) ||
      !ctReserve((void**)&trial->links, &capacity[3], count, sizeof(int)) ||
      !ctReserve((void**)&trial->motionOf, &capacity[4], count, sizeof(int)) ||
      !ctReserve((void**)&trial->scratch, &capacity[5], count, sizeof(int)) ||
      !ctReserve((void**)&trial->worldMotions, &capacity[6], count, sizeof(ctTransform[2])) ||
      !ctReserve((void**)&trial->userLinks, &capacity[7], count, sizeof(int))) {
    return false;
  }
  trial->capacity = count;
  return true;
}

void ctTrialFree(Trial* trial) {
  free(trial->changes);
  free(trial->pieces);
  free(trial->motions);
  free(trial->links);
  free(trial->motionOf);
  free(trial->scratch);
  free(trial->worldMotions);
  free(trial->userLinks);
  *trial = (Trial){0};
}

/* ---- Motions ---- */

static Frame linkFrame(const Sequence* sequence, const Tree* tree, int link) {
  const Frame leaf = ctTreeFrame(tree, 0, sequence->slotBegin[link] / TREE_WIDTH);
  const Frame inLeaf = ctTreeLinkInLeaf(sequence, link);
  return transformCompose(&leaf, &inLeaf);
}

/* Turns a torsion about its axis in the world. */
static void turnTorsion(TrialChange* change, const Sequence* s, Traversal* t, double angle) {
  static const double still[3] = {0, 0, 0};
  double point[3];
  double direction[3];
  const Frame* leaf = ctTraversalLeafFrame(t, s->slotBegin[change->link] / TREE_WIDTH);
  ctTreeAxis(t->tree, s, change->link, point, direction);
  transformPoint(leaf, point, point);
  rotate(leaf, direction, direction);
  const double factor = rodriguesFactor(direction, angle);
  for (int k = 0; k < 3; k++) {
    direction[k] *= factor;
  }
  rotationFromRodrigues(direction[0], direction[1], direction[2], change->motion.m[0], 1);
  transformAbout(point, still, &change->motion);
  change->after.angle = ctAngleTurned(change->before.angle, angle);
}

/* Where the particle is about which a ball joint turns, in the world. */
static void findPivot(const Sequence* s, Traversal* t, int link, double pivot[3]) {
  const int slot = particleSlot(s, s->joint[link].origin);
  if (slot != CT_NULL) {
    treeLocal(t->tree, slot, pivot);
    transformPoint(ctTraversalLeafFrame(t, slot / TREE_WIDTH), pivot, pivot);
  } else {
    const Frame own = linkFrame(s, t->tree, link);
    translationOf(&own, pivot);
  }
}

/* Turns a ball joint about its pivot. */
static void turnBall(TrialChange* change, const Sequence* s, Traversal* t, const double rotation[3]) {
  static const double still[3] = {0, 0, 0};
  double turn[4];
  double pivot[3];
  quaternionFromVector(rotation, turn);
  rotationFromQuaternion(turn, &change->motion);
  findPivot(s, t, change->link, pivot);
  transformAbout(pivot, still, &change->motion);
  memcpy(change->rotation, rotation, sizeof change->rotation);
  change->isTurnOfBall = true;
}

/* Finds the states of ball joints after the trial, which takes a walk to each. So that is left until someone asks: most
 * trials clash. The tree must be that of the state before. */
static void turnBalls(Trial* trial, const Sequence* s, const Tree* tree) {
  for (int i = 0; i < trial->count; i++) {
    TrialChange* change = &trial->changes[i];
    if (change->isTurnOfBall) {
      const Frame parent = linkFrame(s, tree, s->parent[change->link]);
      double rotation[3];
      rotateBack(&parent, change->rotation, rotation);
      change->after = ctJointTurned(&change->before, rotation);
      change->isTurnOfBall = false;
    }
  }
}

/* Moves a free joint. The change is given in the world; the joint's state is in the parent's frame. */
static void moveFreely(TrialChange* change, const Sequence* s, const Tree* tree, const ctChange* given) {
  double turn[4];
  quaternionFromVector(given->rotation, turn);
  rotationFromQuaternion(turn, &change->motion);
  double pivot[3];
  subtract(given->pivot, s->worldOrigin, pivot);
  transformAbout(pivot, given->translation, &change->motion);

  const Frame parent = linkFrame(s, tree, s->parent[change->link]);
  double rotation[3];
  double shift[3];
  rotateBack(&parent, given->rotation, rotation);
  rotateBack(&parent, given->translation, shift);
  transformPointBack(&parent, pivot, pivot);
  change->after = ctJointMoved(&change->before, rotation, pivot, shift);
}

/* ---- Pieces ---- */

static void addPiece(Trial* trial, int slotBegin, int motion) {
  if (trial->pieceCount > 0 && trial->pieces[trial->pieceCount - 1].slotBegin == slotBegin) {
    trial->pieceCount--; /* the last piece has no slots */
  }
  if (trial->pieceCount > 0 && trial->pieces[trial->pieceCount - 1].body == motion) {
    return;
  }
  trial->pieces[trial->pieceCount++] = (Piece){slotBegin, motion};
}

/* Cuts the sequence into pieces. The intervals of the changes are nested or disjoint: goes along the sequence with a
 * stack of the open ones. */
static void cutPieces(Trial* trial, const Sequence* s) {
  int* open = trial->scratch;
  int* motionOf = trial->motionOf;
  int depth = 0;
  trial->pieceCount = 0;
  trial->motions[0] = transformIdentity();
  trial->motionCount = trial->count + 1;
  addPiece(trial, 0, 0);
  for (int i = 0; i <= trial->count; i++) {
    const int next = i < trial->count ? trial->changes[i].link : s->linkCount;
    while (depth > 0 && sequenceEnd(s, open[depth - 1]) <= next) {
      const int end = sequenceEnd(s, open[--depth]);
      if (end < s->linkCount) {
        addPiece(trial, s->slotBegin[end], depth > 0 ? motionOf[depth - 1] : 0);
      }
    }
    if (i < trial->count) {
      const TrialChange* change = &trial->changes[i];
      const int around = depth > 0 ? motionOf[depth - 1] : 0;
      trial->motions[i + 1] = around == 0 ? change->motion : transformCompose(&trial->motions[around], &change->motion);
      motionOf[depth] = i + 1; /* the motion that goes with the open interval */
      open[depth++] = change->link;
      addPiece(trial, s->slotBegin[change->link], i + 1);
    }
  }
}

static int compareChanges(const void* a, const void* b) {
  const int x = ((const TrialChange*)a)->link;
  const int y = ((const TrialChange*)b)->link;
  return (x > y) - (x < y);
}

int ctTrialOpen(Trial* trial, const Sequence* s, Traversal* t, const ctChange* given, int count) {
  trial->count = count;
  for (int i = 0; i < count; i++) {
    TrialChange* change = &trial->changes[i];
    change->link = sequenceLink(s, given[i].link);
    change->userLink = given[i].link;
    change->before = ctSequenceGetJoint(s, change->link);
    change->isTurnOfBall = false;
    if (s->jointType[change->link] == ctTorsionJoint) {
      turnTorsion(change, s, t, given[i].angle);
    } else if (s->jointType[change->link] == ctBallJoint) {
      turnBall(change, s, t, given[i].rotation);
    } else {
      moveFreely(change, s, t->tree, &given[i]);
    }
  }
  if (count > 1) {
    qsort(trial->changes, (size_t)count, sizeof(TrialChange), compareChanges);
  }
  for (int i = 0; i < count; i++) {
    trial->links[i] = trial->changes[i].link;
    if (i > 0 && trial->links[i] == trial->links[i - 1]) {
      return trial->links[i];
    }
  }
  cutPieces(trial, s);
  trial->isShown = false;
  trial->open = true;
  return CT_NULL;
}

View ctTrialView(const Trial* trial, bool moved, bool surfaces, double reach) {
  return (View){trial->pieces, trial->pieceCount, moved ? trial->motions : NULL, trial->motionCount, surfaces, reach};
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

int ctTrialApply(Trial* trial, bool after, Sequence* s, Tree* tree) {
  if (after) {
    turnBalls(trial, s, tree);
  }
  for (int i = 0; i < trial->count; i++) {
    const TrialChange* change = &trial->changes[i];
    ctSequenceSetJoint(s, change->link, after ? &change->after : &change->before);
  }
  const int products = ctSequenceUpdate(s, trial->links, trial->count, trial->scratch);
  return products + ctTreeUpdate(tree, s, trial->links, trial->count);
}
