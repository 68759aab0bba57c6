#include "merged.h"

#include "scene.h"
#include "volume.h"

/* ---- Merging ---- */

/* nm: bodies merge if that changes no distance by more. Two checks of all pairs (merged.h) are at least 25 trials
 * apart. */
#define MERGE_TOLERANCE 2e-11

/* Each body is compared with the static one and at most 16 earlier ones: windows close within this many changes. */
enum { MOST_COMPARED = 16 };

/* Most difference of a distance that is computed by different products of transforms, relative to the coordinate bound:
 * DOUBLE_MARGIN for a tree of this many levels. */
static double productMargin(int levelCount) {
  return DOUBLE_MARGIN * (TREE_WIDTH + (TREE_WIDTH - 1) * levelCount) /
         (TREE_WIDTH + (TREE_WIDTH - 1) * TREE_MAX_LEVELS);
}

static bool mayBeOne(const Frame* a, const Frame* b) {
  return fabs(a->m[0][3] - b->m[0][3]) <= MERGE_TOLERANCE && fabs(a->m[1][3] - b->m[1][3]) <= MERGE_TOLERANCE &&
         fabs(a->m[2][3] - b->m[2][3]) <= MERGE_TOLERANCE;
}

/* Most distance between the images of a point under two motions; the point is within `reach` of worldOrigin. */
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

bool ctMayMerge(const Trial* trial) {
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

double ctTrialRounding(const Trial* trial, double reach, int levelCount) {
  return 2 * productMargin(levelCount) * (reach + largestTranslation(trial));
}

void ctMergeBodies(Trial* trial, double reach, int levelCount) {
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
  const double distanceError = 2 * displacement + ctTrialRounding(trial, reach, levelCount);
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

/* ---- The check of skipped pairs ---- */

void ctMergedForget(ctChainTree* scene) {
  scene->merged.accumulatedError = INFINITY;
  scene->merged.wait = 0;
  scene->merged.patience = 1;
  scene->merged.arm = -1;
}

/* True if the trial that is accepted leaves no pair farther beyond its limit than MOST_ERROR. */
static bool isLittle(const ctChainTree* scene) {
  return scene->merged.accumulatedError + scene->trial->distanceError <= MOST_ERROR;
}

bool ctPrepareSkip(ctChainTree* scene, ctCounts* counts) {
  Merged* merged = &scene->merged;
  if (isLittle(scene)) {
    return true;
  }
  if (merged->wait > 0) {
    merged->wait--;
    return false;
  }
  merged->accumulatedError = ctSceneExcess(scene, MOST_ERROR, counts);
  if (isLittle(scene)) {
    merged->patience = 1;
    return true;
  }
  merged->wait = merged->patience;
  merged->patience = merged->patience < MOST_CHECK_PATIENCE ? 2 * merged->patience : merged->patience;
  return false;
}

void ctMergedAccept(ctChainTree* scene) {
  Merged* merged = &scene->merged;
  const Trial* trial = scene->trial;
  if (!trial->isFree) {
    merged->accumulatedError = INFINITY;
  } else if (trial->isSkipTested) {
    merged->accumulatedError += trial->distanceError;
  }
  merged->total += trial->displacement;
}

/* ---- How far particles reach ---- */

/* Bounds the distance, in any state, between the origin of a link and some particle that is modelled. A torsion keeps
 * the origin of its link where it is in the frame of the parent. INFINITY: no bound is known. */
static double wayToModelled(const Sequence* s, int link) {
  double way = 0;
  for (;; link = s->parent[link]) {
    double least = INFINITY;
    for (int slot = s->slotBegin[link]; slot < s->slotBegin[link + 1]; slot++) {
      if (slotIsModelled(s, slot)) {
        double local[3];
        sequenceLocal(s, link, s->slotParticle[slot], local);
        least = lesser(least, sqrt(dot(local, local)));
      }
    }
    if (least < INFINITY || s->jointType[link] != ctTorsionJoint) {
      return way + least;
    }
    double offset[3];
    sequenceOffset(s, link, offset);
    way += sqrt(dot(offset, offset));
  }
}

/* How much farther a particle that is listed, but not modelled, may be from worldOrigin than all that are. */
static double measureArm(const Sequence* s) {
  double most = 0;
  for (int slot = 0; slot < s->slotCount; slot++) {
    if (s->slotParticle[slot] != CT_NULL && !slotIsModelled(s, slot)) {
      const int link = s->slotLink[slot];
      double local[3];
      sequenceLocal(s, link, s->slotParticle[slot], local);
      most = larger(most, wayToModelled(s, link) + sqrt(dot(local, local)));
    }
  }
  return most;
}

double ctSceneReach(ctChainTree* scene) {
  const Tree* tree = ctSceneTree(scene);
  const Bound* root = &tree->bound[treeRoot(tree)];
  const double centre[3] = {root->x, root->y, root->z};
  if (scene->merged.arm < 0) {
    scene->merged.arm = measureArm(&scene->sequence);
  }
  return sqrt(dot(centre, centre)) + larger((double)root->centres, 0) + scene->merged.arm;
}
