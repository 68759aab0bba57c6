/* Trials that displace particles within their links. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "definition.h"
#include "scene.h"

static bool reserve(Trial* trial, int count) {
  if (!ctTrialReserve(trial, count)) { /* each particle may begin a piece, and another may begin behind it */
    return false;
  }
  if (count <= trial->displacementCapacity) {
    return true;
  }
  int capacity[3];
  for (int i = 0; i < 3; i++) {
    capacity[i] = trial->displacementCapacity;
  }
  if (!ctReserve((void**)&trial->displacements, &capacity[0], count, sizeof(TrialDisplacement)) ||
      !ctReserve((void**)&trial->displaced, &capacity[1], count, sizeof(int)) ||
      !ctReserve((void**)&trial->inLeaf, &capacity[2], count, sizeof(Frame))) {
    return false;
  }
  trial->displacementCapacity = count;
  return true;
}

/* ---- Propose ---- */

static ctStatus checkDisplacement(ctChainTree* tree, const ctDisplacement* given) {
  const Sequence* s = &tree->sequence;
  if (!isIndex(given->particle, s->particleCount)) {
    return ctFail(tree, ctInvalidArgument, "there is no particle %d; there are %d particles", given->particle,
                  s->particleCount);
  }
  if (particleLink(s, given->particle) == 0) {
    return ctFail(tree, ctInvalidArgument, "particle %d is fixed and cannot be displaced", given->particle);
  }
  if (!areLengths(given->shift)) {
    return ctFail(tree, ctInvalidArgument, "the displacement given for particle %d " CT_NO_LENGTH, given->particle);
  }
  const double* reference = s->reference + 3 * (size_t)given->particle;
  const double length = sqrt(dot(given->shift, given->shift));
  for (int k = 0; k < 3; k++) {
    if (fabs(reference[k]) + length > CT_MOST_LENGTH) { /* whichever way its link is turned */
      return ctFail(tree, ctInvalidArgument, "the displacement given for particle %d takes it too far away",
                    given->particle);
    }
  }
  return ctSuccess;
}

static int comparePlaces(const void* a, const void* b) {
  const TrialDisplacement* x = a;
  const TrialDisplacement* y = b;
  return x->place != y->place ? (x->place > y->place) - (x->place < y->place)
                              : (x->particle > y->particle) - (x->particle < y->particle);
}

/* Sorts displacements by place; returns a particle that is displaced twice, or CT_NULL. */
static int sortDisplacements(Trial* trial) {
  TrialDisplacement* all = trial->displacements;
  qsort(all, (size_t)trial->displacementCount, sizeof *all, comparePlaces);
  for (int i = 1; i < trial->displacementCount; i++) {
    if (all[i].particle == all[i - 1].particle) {
      return all[i].particle;
    }
  }
  return CT_NULL;
}

/* The body that moves by this shift: an earlier one, or a new one. */
static int bodyOfShift(Trial* trial, const double shift[3]) {
  for (int body = 1; body < trial->motionCount; body++) {
    double known[3];
    translationOf(&trial->motions[body], known);
    if (memcmp(known, shift, sizeof known) == 0) {
      return body;
    }
  }
  trial->motions[trial->motionCount] = transformIdentity();
  setTranslation(&trial->motions[trial->motionCount], shift);
  return trial->motionCount++;
}

/* Cuts the sequence into displaced slots and what is between them. */
static void cutSlots(Trial* trial, const Sequence* s) {
  trial->motionCount = 1;
  trial->pieceCount = 0;
  addPiece(trial, 0, 0);
  for (int i = 0; i < trial->displacementCount; i++) {
    const int slot = trial->displacements[i].place;
    if (slot >= 0) {
      addPiece(trial, slot, bodyOfShift(trial, trial->displacements[i].shift));
      if (slot + 1 < s->slotCount) {
        addPiece(trial, slot + 1, 0);
      }
    }
  }
}

ctStatus ctProposeDisplacements(ctChainTree* tree, int count, const ctDisplacement* displacements) {
  CT_REQUIRE(tree, tree);
  const Sequence* s = &tree->sequence;
  if (!s->isFlexible) {
    return ctFail(tree, ctInvalidArgument, "particles can be displaced only in a scene that is flexible");
  }
  if (count < 1 || count > s->particleCount) {
    return ctFail(tree, ctInvalidArgument, "a trial cannot displace %d particles; there are %d particles", count,
                  s->particleCount);
  }
  CT_REQUIRE(tree, displacements);
  ctSceneLooseTree(tree); /* trials start from an up-to-date tree */
  for (int i = 0; i < count; i++) {
    const ctStatus status = checkDisplacement(tree, &displacements[i]);
    if (status != ctSuccess) {
      return status;
    }
  }
  Trial* trial = tree->next;
  if (!reserve(trial, count) || !ctTraversalReserve(&tree->traversal, 2 * count + 1)) {
    return ctFailOutOfMemory(tree);
  }
  trial->count = 0;
  trial->displacementCount = count;
  for (int i = 0; i < count; i++) {
    TrialDisplacement* own = &trial->displacements[i];
    own->particle = displacements[i].particle;
    own->place = s->slotOrLink[own->particle];
    memcpy(own->shift, displacements[i].shift, sizeof own->shift);
  }
  const int twice = count > 1 ? sortDisplacements(trial) : CT_NULL;
  if (twice != CT_NULL) {
    return ctFail(tree, ctInvalidArgument, "particle %d is displaced twice in one trial", twice);
  }
  for (int i = 0; i < count; i++) {
    trial->displaced[i] = trial->displacements[i].particle;
  }
  cutSlots(trial, s);
  trial->arePending = true;
  resetTrial(trial);
  ctTrialOpen(tree);
  return ctSuccess;
}

int ctGetTrialParticles(const ctChainTree* tree, const int** particles) {
  if (tree == NULL || particles == NULL) {
    return 0;
  }
  const bool displaces = tree->trial->open && tree->trial->displacementCount > 0;
  *particles = displaces ? tree->trial->displaced : NULL;
  return displaces ? tree->trial->displacementCount : 0;
}

/* ---- Apply ---- */

/* Finds the frames of the links of displaced particles in their leaves. */
static void findFrames(Trial* trial, const Sequence* s, const Tree* tree) {
  const int* particles = trial->displaced;
  for (int i = 0; i < trial->displacementCount; i++) {
    const int link = particleLink(s, particles[i]);
    const int leaf = particleLeaf(s, particles[i]);
    const bool isKnown =
        i > 0 && particleLink(s, particles[i - 1]) == link && particleLeaf(s, particles[i - 1]) == leaf;
    trial->inLeaf[i] = isKnown ? trial->inLeaf[i - 1] : ctTreeLinkInThisLeaf(tree, s, link, leaf);
  }
}

/* Finds reference positions before and after the trial, from the state before it. */
static void findPositions(Trial* trial, const Sequence* s, World* world) {
  for (int i = 0; i < trial->displacementCount; i++) {
    TrialDisplacement* own = &trial->displacements[i];
    double shift[3];
    rotateBack(ctWorldLeafFrame(world, particleLeaf(s, own->particle)), own->shift, shift);
    rotateBack(&trial->inLeaf[i], shift, shift);
    memcpy(own->before, s->reference + 3 * (size_t)own->particle, sizeof own->before);
    for (int k = 0; k < 3; k++) {
      own->after[k] = own->before[k] + shift[k];
    }
  }
}

int ctDisplacementsApply(ctChainTree* scene, bool after) {
  Trial* trial = scene->trial;
  Sequence* s = &scene->sequence;
  findFrames(trial, s, &scene->ownTree);
  if (trial->arePending) {
    findPositions(trial, s, &scene->world);
    trial->arePending = false;
  }
  for (int i = 0; i < trial->displacementCount; i++) {
    const TrialDisplacement* own = &trial->displacements[i];
    memcpy(s->reference + 3 * (size_t)own->particle, after ? own->after : own->before, sizeof own->after);
  }
  return ctTreeDisplace(&scene->ownTree, s, trial->displaced, trial->inLeaf, trial->displacementCount);
}
