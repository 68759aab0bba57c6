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

/* nm: displacements may lengthen the arm by this before it is measured again. */
#define MOST_LENGTHENING 10.0

void ctMergedAccept(ctChainTree* scene) {
  Merged* merged = &scene->merged;
  const Trial* trial = scene->trial;
  if (!trial->isFree) {
    merged->accumulatedError = INFINITY;
  } else if (trial->isSkipTested) {
    merged->accumulatedError += trial->distanceError;
  }
  merged->total += trial->displacement;
  for (int i = 0; i < trial->displacementCount; i++) {
    const double* shift = trial->displacements[i].shift;
    merged->lengthening += sqrt(dot(shift, shift));
  }
  if (merged->lengthening > MOST_LENGTHENING) {
    merged->arm = -1;
  }
}

/* ---- How far particles reach ---- */

/* Where the origin particle of a link is in its frame; the world has none, but an origin. */
static void originInLink(const Sequence* s, int link, double x[3]) {
  if (link > 0) {
    sequenceLocal(s, link, s->joint[link].origin, x);
  } else {
    x[0] = x[1] = x[2] = 0;
  }
}

/* Bounds how far the origin particle of a link with a torsion joint is from that of its parent, in any state. */
static double wayToParent(const Sequence* s, int link) {
  const int parent = s->parent[link];
  double from[3];
  double to[3];
  if (!s->isFlexible) {
    sequenceOffset(s, link, to);
    return sqrt(dot(to, to));
  }
  sequenceAxisEnds(s, link, from, to);
  const double length = sqrt(squaredDistance(from, to));
  double origin[3];
  originInLink(s, parent, origin);
  sequenceLocal(s, parent, s->joint[link].torsion[0], from);
  return length + sqrt(squaredDistance(from, origin));
}

/* Bounds the distance, in any state, between the origin particle of a link and some particle that is modelled. A
 * torsion keeps its axis particles where they are in the frames of both links. INFINITY: no bound is known. */
static double wayToModelled(const Sequence* s, int link) {
  double way = 0;
  for (;; link = s->parent[link]) {
    double origin[3];
    originInLink(s, link, origin);
    double least = INFINITY;
    for (int slot = s->slotBegin[link]; slot < s->slotBegin[link + 1]; slot++) {
      if (slotIsModelled(s, slot)) {
        double local[3];
        sequenceLocal(s, link, s->slotParticle[slot], local);
        least = lesser(least, sqrt(squaredDistance(local, origin)));
      }
    }
    if (least < INFINITY || s->jointType[link] != ctTorsionJoint) {
      return way + least;
    }
    way += wayToParent(s, link);
  }
}

/* How much farther a particle that is listed, but not modelled, may be from worldOrigin than all that are. */
static double measureArm(const Sequence* s) {
  double most = 0;
  for (int slot = 0; slot < s->slotCount; slot++) {
    if (s->slotParticle[slot] != CT_NULL && !slotIsModelled(s, slot)) {
      const int link = s->slotLink[slot];
      double local[3];
      double origin[3];
      sequenceLocal(s, link, s->slotParticle[slot], local);
      originInLink(s, link, origin);
      most = larger(most, wayToModelled(s, link) + sqrt(squaredDistance(local, origin)));
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
    scene->merged.lengthening = 0;
  }
  return sqrt(dot(centre, centre)) + larger((double)root->centres, 0) + scene->merged.arm + scene->merged.lengthening;
}
