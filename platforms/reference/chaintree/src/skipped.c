#include "skipped.h"

#include "scene.h"

void ctSkippedForget(ctChainTree* scene) {
  scene->skipped.accumulatedError = INFINITY;
  scene->skipped.wait = 0;
  scene->skipped.patience = 1;
  scene->skipped.arm = -1;
}

/* True if the trial that is accepted leaves no pair farther beyond its limit than MOST_ERROR. */
static bool isLittle(const ctChainTree* scene) {
  return scene->skipped.accumulatedError + scene->trial->distanceError <= MOST_ERROR;
}

bool ctPrepareSkip(ctChainTree* scene, ctCounts* counts) {
  Skipped* skipped = &scene->skipped;
  if (isLittle(scene)) {
    return true;
  }
  if (skipped->wait > 0) {
    skipped->wait--;
    return false;
  }
  skipped->accumulatedError = ctSceneExcess(scene, MOST_ERROR, counts);
  if (isLittle(scene)) {
    skipped->patience = 1;
    return true;
  }
  skipped->wait = skipped->patience;
  skipped->patience = skipped->patience < MOST_CHECK_PATIENCE ? 2 * skipped->patience : skipped->patience;
  return false;
}

void ctSkippedAccept(ctChainTree* scene) {
  Skipped* skipped = &scene->skipped;
  const Trial* trial = scene->trial;
  if (!trial->isFree) {
    skipped->accumulatedError = INFINITY;
  } else if (trial->isSkipTested) {
    skipped->accumulatedError += trial->distanceError;
  }
  skipped->total += trial->displacement;
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
  if (scene->skipped.arm < 0) {
    scene->skipped.arm = measureArm(&scene->sequence);
  }
  return sqrt(dot(centre, centre)) + larger((double)root->centres, 0) + scene->skipped.arm;
}
