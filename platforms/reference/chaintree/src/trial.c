#include "trial.h"

#include <stdlib.h>
#include <string.h>

#include "volume.h"

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
static Frame linkFromLeaf(const Sequence* sequence, Traversal* t, int link, const Frame* inLeaf) {
  return transformCompose(ctTraversalLeafFrame(t, coveringNode(sequence->slotBegin[link])), inLeaf);
}

static Frame linkFrame(const Sequence* sequence, Traversal* t, int link) {
  const Frame inLeaf = ctTreeLinkInLeaf(t->tree, sequence, link);
  return linkFromLeaf(sequence, t, link, &inLeaf);
}

/* Turns a torsion about its axis in the world. The placements of its states stay undefined: nobody reads them. */
static void turnTorsion(TrialChange* change, const Sequence* s, Traversal* t, Frame* motion) {
  const double angle = change->given->angle;
  double point[3];
  double axis[3];
  const Frame* leaf = ctTraversalLeafFrame(t, coveringNode(s->slotBegin[change->link]));
  treeAxis(t->tree, s, change->link, point, axis);
  transformPoint(leaf, point, point);
  rotate(leaf, axis, axis);
  const Angle half = angleOfAny(0.5 * angle);
  const double factor = half.sine / sqrt(dot(axis, axis));
  Frame turn;
  rotationFromUnit(half.cosine, factor * axis[0], factor * axis[1], factor * axis[2], turn.m[0], 1);
  transformAbout(point, &turn);
  *motion = turn;
  change->before.angle = s->angle[change->link];
  change->after.angle = ctAngleTurned(change->before.angle, angle);
}

/* Where the particle is about which a ball joint turns, in the world. */
static void findJointCentre(const Sequence* s, Traversal* t, int link, double pivot[3]) {
  const int slot = particleSlot(s, s->joint[link].origin);
  if (slot != CT_NULL) {
    treeLocal(t->tree, slot, pivot);
    transformPoint(ctTraversalLeafFrame(t, coveringNode(slot)), pivot, pivot);
  } else {
    const Frame own = linkFrame(s, t, link);
    translationOf(&own, pivot);
  }
}

/* Turns a ball joint about its pivot. */
CT_NOINLINE void turnBall(TrialChange* change, const Sequence* s, Traversal* t, Frame* motion) {
  const double* rotation = change->given->rotation;
  double turn[4];
  double pivot[3];
  quaternionFromVector(rotation, turn);
  rotationFromQuaternion(turn, motion);
  findJointCentre(s, t, change->link, pivot);
  transformAbout(pivot, motion);
  memcpy(change->rotation, rotation, sizeof change->rotation);
  change->isTurnOfBall = true;
}

/* Finds the states of ball joints before and after the trial, which takes a walk to each: so it waits until a trial is
 * applied, since most clash. The tree must be that of the state before. If there is one walk, the update of the tree
 * starts where it ends. */
static void turnBalls(Trial* trial, const Sequence* s, Tree* tree, Traversal* t) {
  for (int i = 0; i < trial->count; i++) {
    TrialChange* change = &trial->changes[i];
    if (change->isTurnOfBall) {
      const int link = s->parent[change->link];
      const bool isKept = trial->count == 1 && s->sideBranchPart[link] == notInSideBranch;
      const Frame inLeaf = isKept ? ctTreeKnowLink(tree, s, link, change->link) : ctTreeLinkInLeaf(tree, s, link);
      const Frame parent = linkFromLeaf(s, t, link, &inLeaf);
      double rotation[3];
      rotateBack(&parent, change->rotation, rotation);
      change->before = ctSequenceGetJoint(s, change->link);
      change->after = ctJointTurned(&change->before, rotation);
      change->isTurnOfBall = false;
    }
  }
}

/* Moves a free joint. The change is given in the world; the joint's state is in the parent's frame. */
CT_NOINLINE void moveFreely(TrialChange* change, const Sequence* s, Traversal* t, Frame* motion) {
  const ctChange* given = change->given;
  double turn[4];
  quaternionFromVector(given->rotation, turn);
  rotationFromQuaternion(turn, motion);
  double pivot[3];
  subtract(given->pivot, s->worldOrigin, pivot);
  transformAbout(pivot, motion);
  for (int k = 0; k < 3; k++) {
    motion->m[k][3] += given->translation[k];
  }

  const Frame parent = linkFrame(s, t, s->parent[change->link]);
  double rotation[3];
  double shift[3];
  rotateBack(&parent, given->rotation, rotation);
  rotateBack(&parent, given->translation, shift);
  transformPointBack(&parent, pivot, pivot);
  change->after = ctJointMoved(&change->before, rotation, pivot, shift);
}

/* ---- Pieces ---- */

static void addPiece(Trial* trial, int slotBegin, int body) {
  if (trial->pieceCount > 0 && trial->pieces[trial->pieceCount - 1].slotBegin == slotBegin) {
    trial->pieceCount--; /* the last piece has no slots */
  }
  if (trial->pieceCount > 0 && trial->pieces[trial->pieceCount - 1].body == body) {
    return;
  }
  trial->pieces[trial->pieceCount++] = (Piece){slotBegin, body};
}

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

/* ---- Bodies that move as another does ---- */

/* nm: bodies merge if that changes no distance by more. Two checks of all pairs (skipped.h) are at least 25 trials
 * apart. */
#define MERGE_TOLERANCE 2e-11

/* Each body is compared with the static one and at most 16 earlier ones: windows close within this many changes. */
enum { MOST_COMPARED = 16 };

/* Bounds what a distance may differ by if it is computed by way of different products of transforms, relative to the
 * coordinate bound: DOUBLE_MARGIN for a tree of this many levels. */
static double productMargin(int levelCount) {
  return DOUBLE_MARGIN * (TREE_WIDTH + (TREE_WIDTH - 1) * levelCount) /
         (TREE_WIDTH + (TREE_WIDTH - 1) * TREE_MAX_LEVELS);
}

static bool mayBeOne(const Frame* a, const Frame* b) {
  return fabs(a->m[0][3] - b->m[0][3]) <= MERGE_TOLERANCE && fabs(a->m[1][3] - b->m[1][3]) <= MERGE_TOLERANCE &&
         fabs(a->m[2][3] - b->m[2][3]) <= MERGE_TOLERANCE;
}

/* Bounds how far apart two motions take what is no farther than `reach` from worldOrigin. */
static double motionsApart(const Frame* a, const Frame* b, double reach) {
  double turned = 0;
  double shifted = 0;
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      turned += (a->m[i][j] - b->m[i][j]) * (a->m[i][j] - b->m[i][j]);
    }
    shifted += (a->m[i][3] - b->m[i][3]) * (a->m[i][3] - b->m[i][3]);
  }
  return sqrt(turned) * reach + sqrt(shifted);
}

/* The motions that motion i is compared with: 0, and those from this one on. */
static int firstCompared(int i) {
  return i > MOST_COMPARED ? i - MOST_COMPARED : 1;
}

bool ctTrialMayMerge(const Trial* trial) {
  for (int i = 1; i < trial->motionCount && trial->count > 1; i++) {
    if (mayBeOne(&trial->motions[i], &trial->motions[0])) {
      return true;
    }
    for (int j = firstCompared(i); j < i; j++) {
      if (mayBeOne(&trial->motions[i], &trial->motions[j])) {
        return true;
      }
    }
  }
  return false;
}

/* The lowest motion that takes everything where motion i does, up to MERGE_TOLERANCE; i if there is none. `bodyOf`: of
 * lower motions. */
static int sameMotion(const Trial* trial, const int* bodyOf, int i, double reach, double* apart) {
  for (int j = 0; j < i; j = j == 0 ? firstCompared(i) : j + 1) {
    if (bodyOf[j] == j && mayBeOne(&trial->motions[i], &trial->motions[j])) {
      *apart = motionsApart(&trial->motions[i], &trial->motions[j], reach);
      if (*apart <= MERGE_TOLERANCE) {
        return j;
      }
    }
  }
  return i;
}

static double largestTranslation(const Trial* trial) {
  double farthest = 0;
  for (int i = 1; i < trial->motionCount; i++) {
    double shift[3];
    translationOf(&trial->motions[i], shift);
    farthest = larger(farthest, sqrt(dot(shift, shift)));
  }
  return farthest;
}

void ctTrialMerge(Trial* trial, double reach, int levelCount) {
  int* bodyOf = trial->bodyOf;
  double displacement = 0;
  bool areMerged = false;
  bodyOf[0] = 0;
  for (int i = 1; i < trial->motionCount; i++) {
    double apart = 0;
    bodyOf[i] = sameMotion(trial, bodyOf, i, reach, &apart);
    areMerged = areMerged || bodyOf[i] != i;
    displacement = bodyOf[i] != i ? larger(displacement, apart) : displacement;
  }
  /* Either particle of a pair may be displaced. The canonical distances before and after the trial differ from those by
   * its motions by a margin each. */
  const double distanceError = 2 * displacement + 2 * productMargin(levelCount) * (reach + largestTranslation(trial));
  if (!areMerged || !(distanceError <= MERGE_TOLERANCE)) {
    return;
  }
  trial->displacement = displacement;
  trial->distanceError = distanceError;
  trial->apartCount = trial->pieceCount;
  memcpy(trial->apart, trial->pieces, (size_t)trial->pieceCount * sizeof *trial->pieces);
  trial->pieceCount = 0;
  for (int p = 0; p < trial->apartCount; p++) {
    addPiece(trial, trial->apart[p].slotBegin, bodyOf[trial->apart[p].body]);
  }
}

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

int ctTrialPropose(Trial* trial, const Sequence* s, Traversal* t, const ctChange* given, int count) {
  trial->count = count;
  for (int i = 0; i < count; i++) {
    TrialChange* change = &trial->changes[i];
    change->link = sequenceLink(s, given[i].link);
    change->userLink = given[i].link;
    change->isTurnOfBall = false;
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
      turnTorsion(change, s, t, motion);
    } else if (s->jointType[change->link] == ctBallJoint) {
      turnBall(change, s, t, motion);
    } else {
      change->before = ctSequenceGetJoint(s, change->link);
      moveFreely(change, s, t, motion);
    }
  }
  if (count == 1) {
    cutAround(trial, s);
  } else {
    cutPieces(trial, s);
  }
  trial->displacement = 0;
  trial->distanceError = 0;
  trial->isFree = false;
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

int ctTrialApply(Trial* trial, bool after, Sequence* s, Tree* tree, Traversal* t) {
  if (after) {
    turnBalls(trial, s, tree, t);
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
