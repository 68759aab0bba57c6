/* The state as numbers, to be kept and set again. */
#include <stdlib.h>
#include <string.h>

#include "definition.h"
#include "scene.h"

/* The squared length of a unit quaternion differs from 1 by no more. The engine's own are within 1e-15; 1e-12 lets
 * numbers pass that were written with 13 digits. */
#define UNIT_ERROR 1e-12

enum { TORSION_SIZE = 1, QUATERNION_SIZE = 4, PLACEMENT_SIZE = 7, WRAPPED_SIZE = 10, ORIGIN_SIZE = 3 };

/* How many numbers the state of a joint has, without those of an origin. Fixed links are part of the world, whose joint
 * is fixed. */
static int placedSize(const Sequence* s, int link) {
  switch (s->jointType[link]) {
    case ctTorsionJoint:
      return s->isFlexible ? PLACEMENT_SIZE : TORSION_SIZE;
    case ctBallJoint:
      return s->isFlexible ? PLACEMENT_SIZE : QUATERNION_SIZE;
    case ctFreeJoint:
      return isWrapped(s, link) ? WRAPPED_SIZE : PLACEMENT_SIZE;
    default:
      return 0;
  }
}

static int jointSize(const Sequence* s, int link) {
  const int size = placedSize(s, link);
  return size > 0 && s->isFlexible ? size + ORIGIN_SIZE : size;
}

static size_t referenceSize(const Sequence* s) {
  return 3 * (size_t)s->particleCount + (s->isFlexible ? ORIGIN_SIZE : 0);
}

size_t ctGetStateSize(const ctChainTree* tree) {
  if (tree == NULL) {
    return 0;
  }
  const Sequence* s = &tree->sequence;
  size_t size = referenceSize(s);
  for (int u = 0; u < s->userLinkCount; u++) {
    size += (size_t)jointSize(s, sequenceLink(s, u));
  }
  return size;
}

/* ---- Joints to numbers and back ---- */

/* True if the position of a link in its parent's frame is part of the state. */
static bool hasPosition(const Sequence* s, int link) {
  return s->isFlexible || s->jointType[link] == ctFreeJoint;
}

static void writeJoint(const Sequence* s, int link, double* numbers) {
  const JointState joint = ctSequenceGetJoint(s, link);
  if (hasAngle(s, link)) {
    numbers[0] = joint.angle;
  } else {
    memcpy(numbers, joint.placement.quaternion, sizeof joint.placement.quaternion);
  }
  if (hasPosition(s, link)) {
    memcpy(numbers + QUATERNION_SIZE, joint.placement.position, sizeof joint.placement.position);
  }
  for (int k = 0; k < 3 && isWrapped(s, link); k++) {
    numbers[PLACEMENT_SIZE + k] = joint.wrap[k];
  }
  if (s->isFlexible) {
    memcpy(numbers + placedSize(s, link), sequenceOrigin(s, link), ORIGIN_SIZE * sizeof *numbers);
  }
}

static JointState readJoint(const Sequence* s, int link, const double* numbers) {
  JointState joint = ctSequenceGetJoint(s, link);
  if (hasAngle(s, link)) {
    joint.angle = numbers[0];
  } else {
    memcpy(joint.placement.quaternion, numbers, sizeof joint.placement.quaternion);
  }
  if (hasPosition(s, link)) {
    memcpy(joint.placement.position, numbers + QUATERNION_SIZE, sizeof joint.placement.position);
  }
  for (int k = 0; k < 3 && isWrapped(s, link); k++) {
    joint.wrap[k] = (int)numbers[PLACEMENT_SIZE + k];
  }
  return joint;
}

/* True if these numbers can be the state of the joint, with these reference positions. */
static bool isJoint(const Sequence* s, int link, const double* numbers, const double* reference) {
  const double pi = 3.141592653589793238462643383280;
  if (hasAngle(s, link)) {
    return fabs(numbers[0]) <= (ctSequenceCanTurn(s, link, reference) ? pi : 0);
  }
  double norm = 0;
  for (int i = 0; i < 4; i++) {
    norm += numbers[i] * numbers[i];
  }
  for (int k = 0; k < 3 && isWrapped(s, link); k++) {
    const double count = numbers[PLACEMENT_SIZE + k];
    if (!(fabs(count) <= MOST_VECTORS && count == floor(count))) {
      return false;
    }
  }
  return fabs(norm - 1) <= UNIT_ERROR && (!hasPosition(s, link) || isJointPosition(numbers + QUATERNION_SIZE)) &&
         (!s->isFlexible || areLengths(numbers + placedSize(s, link)));
}

/* ---- The whole ---- */

void ctGetState(const ctChainTree* tree, double* state) {
  if (tree == NULL || state == NULL) {
    return;
  }
  const Sequence* s = &tree->sequence;
  const size_t coordinates = 3 * (size_t)s->particleCount;
  if (coordinates > 0) {
    memcpy(state, s->reference, coordinates * sizeof(double));
  }
  if (s->isFlexible) {
    memcpy(state + coordinates, s->worldOrigin, sizeof s->worldOrigin);
  }
  double* numbers = state + referenceSize(s);
  for (int u = 0; u < s->userLinkCount; u++) {
    const int link = sequenceLink(s, u);
    const int size = jointSize(s, link);
    if (size > 0) {
      writeJoint(s, link, numbers);
    }
    numbers += size;
  }
}

/* Takes the origins of the world and of all links from the numbers of a flexible scene. */
static void takeOrigins(Sequence* s, const double* state) {
  double* origin = s->reference + 3 * (size_t)s->particleCount;
  memcpy(s->worldOrigin, state + 3 * (size_t)s->particleCount, sizeof s->worldOrigin);
  memcpy(origin, s->worldOrigin, sizeof s->worldOrigin);
  const double* numbers = state + referenceSize(s);
  for (int u = 0; u < s->userLinkCount; u++) {
    const int link = sequenceLink(s, u);
    const int size = jointSize(s, link);
    if (size > 0) {
      memcpy(origin + 3 * (size_t)link, numbers + placedSize(s, link), ORIGIN_SIZE * sizeof *numbers);
    }
    numbers += size;
  }
}

ctStatus ctSetState(ctChainTree* tree, const double* state) {
  CT_REQUIRE(tree, tree);
  if (ctGetStateSize(tree) > 0) {
    CT_REQUIRE(tree, state);
  }
  Sequence* s = &tree->sequence;
  const int bad = ctFindBadPosition(s->particleCount, state);
  if (bad != CT_NULL) {
    return ctFail(tree, ctInvalidArgument, "the reference position of particle %d " CT_NO_LENGTH, bad);
  }
  if (s->isFlexible && !areLengths(state + 3 * (size_t)s->particleCount)) {
    return ctFail(tree, ctInvalidArgument, "the origin of the world " CT_NO_LENGTH);
  }
  const double* numbers = state + referenceSize(s);
  for (int u = 0; u < s->userLinkCount; u++) {
    const int link = sequenceLink(s, u);
    const int size = jointSize(s, link);
    if (size > 0 && !isJoint(s, link, numbers, state)) {
      return ctFail(tree, ctInvalidArgument, "the numbers given for link %d are no state of its joint", u);
    }
    numbers += size;
  }
  ctReject(tree);
  if (s->isFlexible) {
    takeOrigins(s, state);
  }
  ctSequenceSetReference(s, state, s->isFlexible ? originsAreSet : originsOfParticles);
  numbers = state + referenceSize(s);
  for (int u = 0; u < s->userLinkCount; u++) {
    const int link = sequenceLink(s, u);
    const int size = jointSize(s, link);
    if (size > 0) {
      const JointState joint = readJoint(s, link, numbers);
      ctSequenceSetJoint(s, link, &joint);
    }
    numbers += size;
  }
  ctTreeMakeOutdated(&tree->ownTree);
  ctTestersForget(tree);
  ctMergedForget(tree);
  ctLeavesForget(&tree->leaves);
  tree->changeCount++;
  return ctSuccess;
}

/* ---- Scaling ---- */

/* Moves each molecule in the numbers of the state so that its centroid is `factor` times where it is. */
static void scaleMolecules(ctChainTree* tree, double factor, double* state) {
  const Sequence* s = &tree->sequence;
  double* numbers = state + referenceSize(s);
  for (int u = 0; u < s->userLinkCount; u++) {
    const int link = sequenceLink(s, u);
    if (isWrapped(s, link)) {
      /* Within the engine, where it is shifted by box vectors, which are scaled, too. */
      double sum[3];
      const int particles = ctTreeSum(ctSceneTree(tree), s, link, sequenceEnd(s, link), sum);
      for (int k = 0; k < 3; k++) {
        numbers[QUATERNION_SIZE + k] += (factor - 1) * (s->worldOrigin[k] + sum[k] / particles);
      }
    }
    numbers += jointSize(s, link);
  }
}

/* Wraps the molecules that are far from worldOrigin. */
static void wrapMolecules(Sequence* s) {
  for (int branch = 0; branch < s->branchCount; branch++) {
    const int link = s->branchHead[branch];
    if (isWrapped(s, link)) {
      JointState joint = ctSequenceGetJoint(s, link);
      double shift[3];
      ctJointWrap(s, &joint, shift);
      ctSequenceSetJoint(s, link, &joint);
    }
  }
}

ctStatus ctScaleBox(ctChainTree* tree, double factor) {
  CT_REQUIRE(tree, tree);
  Sequence* s = &tree->sequence;
  if (!s->box.isPeriodic) {
    return ctFail(tree, ctInvalidArgument, "the scene has no periodic box");
  }
  if (!(factor > 0) || !isfinite(factor)) {
    return ctFail(tree, ctInvalidArgument, "the factor of the periodic box is %g; it must be positive and finite",
                  factor);
  }
  double* state = malloc((ctGetStateSize(tree) + 1) * sizeof *state);
  if (state == NULL) {
    return ctFailOutOfMemory(tree);
  }
  ctGetState(tree, state);
  scaleMolecules(tree, factor, state);
  const PeriodicBox before = s->box;
  double vectors[3][3];
  for (int k = 0; k < 3; k++) {
    for (int d = 0; d < 3; d++) {
      vectors[k][d] = factor * before.vectors[k][d];
    }
  }
  ctStatus status = ctInvalidArgument;
  if (ctSceneTakeBox(tree, (const double(*)[3])vectors, tree->errorText, sizeof tree->errorText)) {
    status = ctSetState(tree, state);
    if (status == ctSuccess) {
      wrapMolecules(s);
    } else {
      s->box = before;
    }
  }
  free(state);
  return status;
}
