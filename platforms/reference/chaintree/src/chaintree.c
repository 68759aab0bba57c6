/* Life and state of a scene. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "definition.h"
#include "scene.h"
#include "selection.h"
#include "wide.h"

/* A dihedral is undefined if the sine between two of its bonds is less. Coordinates of 1 nm are rounded by 1e-16 nm: a
 * component of 1e-8 of a bond of 0.1 nm has seven digits left. */
#define COLLINEAR 1e-8

/* ---- Life ---- */

static bool build(ctChainTree* scene, const ctDefinition* definition) {
  scene->trial = &scene->trials[0];
  scene->next = &scene->trials[1];
  ctSweepInit(&scene->ownSweep, &scene->ownTree, &scene->sequence, &scene->exclusions);
  return ctSequenceBuild(&scene->sequence, &scene->arena, definition) &&
         ctExclusionsBuild(&scene->exclusions, &scene->arena, &scene->sequence, definition) &&
         ctTreeBuild(&scene->ownTree, &scene->arena, &scene->sequence, ctChooseWide()) &&
         ctWorldBuild(&scene->world, &scene->arena, &scene->ownTree) &&
         ctTraversalBuild(&scene->traversal, &scene->arena, &scene->world, &scene->exclusions) &&
         ctCopiedBuild(&scene->followed, &scene->arena, &scene->sequence);
}

bool ctSceneTakeBox(ctChainTree* scene, const double (*vectors)[3], char* text, size_t size) {
  PeriodicBox box = {.isPeriodic = false};
  if (vectors != NULL) {
    const char* fault = ctFindBoxFault(vectors);
    if (fault != NULL) {
      snprintf(text, size, "the vectors of the periodic box %s", fault);
      return false;
    }
    box = ctPeriodicBox(vectors);
    const double reach = 2 * ctLargestRadius(&scene->sequence) - scene->overlapTolerance;
    if (2 * reach > ctBoxWidth(&box)) {
      snprintf(text, size,
               "the periodic box is %g nm wide; it must be twice as wide as particles reach, which is %g nm",
               ctBoxWidth(&box), reach);
      return false;
    }
  }
  scene->sequence.box = box;
  ctRecentClashesForget(&scene->recentClashes);
  return true;
}

static void takeReference(ctChainTree* scene, const double* positions) {
  ctSequenceSetReference(&scene->sequence, positions, originsOfParticles);
  ctTreeMakeOutdated(&scene->ownTree);
  ctTestersForget(scene);
  ctMergedForget(scene);
  ctLeavesForget(&scene->leaves);
  scene->changeCount++;
}

ctStatus ctSetBox(ctChainTree* tree, const double (*box)[3]) {
  CT_REQUIRE(tree, tree);
  const size_t count = 3 * (size_t)tree->sequence.particleCount;
  double* positions = malloc(count > 0 ? count * sizeof *positions : 1);
  if (positions == NULL) {
    return ctFailOutOfMemory(tree);
  }
  ctGetPositions(tree, positions);
  const bool isTaken = ctSceneTakeBox(tree, box, tree->errorText, sizeof tree->errorText);
  if (isTaken) {
    ctReject(tree);
    takeReference(tree, positions);
  }
  free(positions);
  return isTaken ? ctSuccess : ctInvalidArgument;
}

bool ctGetBox(const ctChainTree* tree, double box[3][3]) {
  if (tree == NULL || box == NULL || !tree->sequence.box.isPeriodic) {
    return false;
  }
  memcpy(box, tree->sequence.box.vectors, sizeof tree->sequence.box.vectors);
  return true;
}

ctStatus ctCreate(const ctDefinition* definition, ctChainTree** tree, char* errorText, size_t errorSize) {
  char ignored[1];
  if (errorText == NULL || errorSize == 0) {
    errorText = ignored;
    errorSize = sizeof ignored;
  }
  errorText[0] = '\0';
  if (tree != NULL) {
    *tree = NULL;
  }
  if (tree == NULL || definition == NULL) {
    snprintf(errorText, errorSize, "%s is NULL", tree == NULL ? "tree" : "definition");
    return ctInvalidArgument;
  }
  const ctStatus status = ctDefinitionCheck(definition, errorText, errorSize);
  if (status == ctInvalidArgument) {
    return status;
  }
  ctChainTree* scene = status == ctSuccess ? calloc(1, sizeof *scene) : NULL;
  if (scene == NULL || !build(scene, definition)) {
    snprintf(errorText, errorSize, "out of memory");
    ctDestroy(scene);
    return ctOutOfMemory;
  }
  scene->overlapTolerance = definition->overlapTolerance;
  if (!ctSceneTakeBox(scene, definition->box, errorText, errorSize)) {
    ctDestroy(scene);
    return ctInvalidArgument;
  }
  ctChooseTesters(scene);
  scene->hydrogenBondAllowance = definition->hydrogenBondAllowance;
  takeReference(scene, definition->positions);
  *tree = scene;
  return ctSuccess;
}

void ctDestroy(ctChainTree* tree) {
  if (tree != NULL) {
    ctDisownSelections(tree);
    ctTrialFree(&tree->trials[0]);
    ctTrialFree(&tree->trials[1]);
    ctTraversalFree(&tree->traversal);
    ctClearanceFree(&tree->clearance);
    ctSweepFree(&tree->ownSweep);
    ctLimitsFree(&tree->limits);
    ctLeavesFree(&tree->leaves);
    free(tree->ties.pairs);
    free(tree->sequence.dihedral);
    ctArenaFree(&tree->arena);
    free(tree);
  }
}

const char* ctGetErrorText(const ctChainTree* tree) {
  return tree != NULL ? tree->errorText : "";
}

const char* ctGetInstructionSet(const ctChainTree* tree) {
  return tree != NULL ? tree->ownTree.wide->name : "";
}

/* ---- State ---- */

void ctRenew(ctChainTree* tree) {
  if (tree != NULL) {
    ctMergedForget(tree);
    ctLeavesForget(&tree->leaves);
  }
}

static bool isUserLink(const ctChainTree* tree, int link) {
  return link >= 0 && link < tree->sequence.userLinkCount;
}

static ctStatus failNoLink(ctChainTree* tree, int link) {
  return ctFail(tree, ctInvalidArgument, "there is no link %d; there are %d links", link, tree->sequence.userLinkCount);
}

ctStatus ctSetPositions(ctChainTree* tree, const double* positions) {
  CT_REQUIRE(tree, tree);
  if (tree->sequence.particleCount > 0) {
    CT_REQUIRE(tree, positions);
  }
  const int bad = ctFindBadPosition(tree->sequence.particleCount, positions);
  if (bad != CT_NULL) {
    return ctFail(tree, ctInvalidArgument, "the position of particle %d " CT_NO_LENGTH, bad);
  }
  ctReject(tree);
  takeReference(tree, positions);
  return ctSuccess;
}

void ctGetPositions(ctChainTree* tree, double* positions) {
  if (tree == NULL || positions == NULL) {
    return;
  }
  ctReadPositions(&tree->sequence, ctSceneWorld(tree), positions);
}

ctStatus ctGetTrialPositions(ctChainTree* tree, double* positions) {
  CT_REQUIRE(tree, tree);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (tree->sequence.particleCount > 0) {
    CT_REQUIRE(tree, positions);
  }
  const bool areLeavesKept = ctSceneEnterTrial(tree);
  ctReadPositions(&tree->sequence, ctSceneWorld(tree), positions);
  ctSceneLeaveTrial(tree, areLeavesKept);
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
    areLeavesKept = ctSceneEnterTrial(tree);
  }
  PositionReader reader = ctPositionReader(&tree->sequence, ctSceneWorld(tree));
  for (int i = 0; i < count; i++) {
    ctReadPosition(&reader, particles[i], positions + 3 * (size_t)i);
  }
  if (inTrial) {
    ctSceneLeaveTrial(tree, areLeavesKept);
  }
  return ctSuccess;
}

void ctFollowPositions(ctChainTree* tree, bool isNewArray, double* positions) {
  if (tree == NULL || positions == NULL) {
    return;
  }
  if (isNewArray) {
    tree->followed.builtFrom = NO_REVISION;
  }
  ctRefreshPositions(&tree->followed, &tree->sequence, ctSceneWorld(tree), positions);
}

ctStatus ctFollowTrialPositions(ctChainTree* tree, bool isNewArray, double* positions) {
  CT_REQUIRE(tree, tree);
  if (!tree->trial->open) {
    return ctFailNoTrial(tree);
  }
  if (tree->sequence.particleCount > 0) {
    CT_REQUIRE(tree, positions);
  }
  const bool areLeavesKept = ctSceneEnterTrial(tree);
  ctFollowPositions(tree, isNewArray, positions);
  ctSceneLeaveTrial(tree, areLeavesKept);
  return ctSuccess;
}

static bool dihedral(const double* p1, const double* p2, const double* p3, const double* p4, double* angle) {
  double b1[3], b2[3], b3[3], n1[3], n2[3], m[3];
  subtract(p2, p1, b1);
  subtract(p3, p2, b2);
  subtract(p4, p3, b3);
  cross(b1, b2, n1);
  cross(b2, b3, n2);
  const double middle = dot(b2, b2);
  if (!(dot(n1, n1) > COLLINEAR * COLLINEAR * dot(b1, b1) * middle) ||
      !(dot(n2, n2) > COLLINEAR * COLLINEAR * middle * dot(b3, b3))) {
    return false;
  }
  cross(n1, n2, m);
  *angle = atan2(dot(m, b2) / sqrt(middle), dot(n1, n2));
  return true;
}

/* Keeps a reference dihedral for clients that read it in each trial. Without memory it is computed each time. */
static void keepDihedral(Sequence* s, int link, double angle) {
  if (s->dihedral == NULL) {
    s->dihedral = malloc((size_t)s->linkCount * sizeof *s->dihedral);
    for (int i = 0; s->dihedral != NULL && i < s->linkCount; i++) {
      s->dihedral[i] = NAN;
    }
  }
  if (s->dihedral != NULL) {
    s->dihedral[link] = angle;
  }
}

/* Writes positions of the particles of a torsion joint that have its dihedral: the present ones in a flexible scene,
 * else those of the reference. */
static void torsionPositions(ctChainTree* tree, const int p[4], double x[4][3]) {
  if (tree->sequence.isFlexible) {
    ctGetPositionsOf(tree, false, 4, p, x[0]);
    return;
  }
  for (int i = 0; i < 4; i++) {
    memcpy(x[i], tree->sequence.reference + 3 * (size_t)p[i], sizeof x[i]);
  }
}

ctStatus ctGetTorsionAngle(ctChainTree* tree, int link, double* angle) {
  CT_REQUIRE(tree, angle);
  if (!isUserLink(tree, link)) {
    return failNoLink(tree, link);
  }
  const Sequence* s = &tree->sequence;
  const int own = sequenceLink(s, link);
  if (s->jointType[own] != ctTorsionJoint) {
    return ctFail(tree, ctInvalidArgument, "link %d has no torsion joint", link);
  }
  double reference = s->dihedral == NULL ? NAN : s->dihedral[own];
  if (isnan(reference)) {
    const Joint* joint = &s->joint[own];
    const int p[4] = {joint->torsion[1], joint->torsion[0], joint->origin, joint->torsion[2]};
    double x[4][3];
    torsionPositions(tree, p, x);
    if (!dihedral(x[0], x[1], x[2], x[3], &reference)) {
      return ctFail(tree, ctInvalidArgument,
                    "the dihedral of particles %d, %d, %d and %d is undefined: three are collinear", p[0], p[1], p[2],
                    p[3]);
    }
    if (!s->isFlexible) {
      keepDihedral(&tree->sequence, own, reference);
    }
  }
  const double pi = 3.141592653589793238462643383280;
  const double turned = ctAngleTurned(reference, s->angle[own]);
  *angle = turned <= -pi ? pi : turned;
  return ctSuccess;
}

ctStatus ctGetCentroid(ctChainTree* tree, int link, double centroid[3]) {
  CT_REQUIRE(tree, centroid);
  if (!isUserLink(tree, link)) {
    return failNoLink(tree, link);
  }
  const int own = sequenceLink(&tree->sequence, link);
  if (own == 0) {
    return ctFail(tree, ctInvalidArgument, "link %d is fixed; only what can move has a centroid here", link);
  }
  const Sequence* s = &tree->sequence;
  const int particles = ctTreeSum(ctSceneTree(tree), s, own, sequenceEnd(s, own), centroid);
  double shift[3];
  ctSequenceLinkShift(s, own, shift);
  for (int k = 0; k < 3; k++) {
    centroid[k] = s->worldOrigin[k] + centroid[k] / particles - shift[k];
  }
  return ctSuccess;
}

/* The frame of a caller's link in the frame of the engine's link that holds it. They differ for fixed links, which are
 * part of the world. */
static Frame userFrame(const Sequence* s, int link) {
  Frame frame = transformIdentity();
  if (sequenceLink(s, link) == 0) {
    double origin[3];
    subtract(s->reference + 3 * (size_t)~s->linkOfUser[link], s->worldOrigin, origin);
    setTranslation(&frame, origin);
  }
  return frame;
}

/* The frame of link b in that of link a, where callers have both. */
static Frame relativeFrame(const Tree* tree, const Sequence* s, int a, int b) {
  Frame frame = ctTreeRelative(tree, s, a, b);
  if (s->box.isPeriodic) {
    const Frame own = ctTreeRelative(tree, s, 0, a);
    double shiftA[3];
    double shiftB[3];
    ctSequenceLinkShift(s, a, shiftA);
    ctSequenceLinkShift(s, b, shiftB);
    double apart[3];
    subtract(shiftA, shiftB, apart);
    rotateBack(&own, apart, apart);
    for (int k = 0; k < 3; k++) {
      frame.m[k][3] += apart[k];
    }
  }
  return frame;
}

static void copyRotation(const Frame* frame, double rotation[9]) {
  for (int i = 0; i < 3; i++) {
    memcpy(rotation + 3 * (size_t)i, frame->m[i], 3 * sizeof(double));
  }
}

ctStatus ctGetRelativeTransform(ctChainTree* tree, int linkA, int linkB, ctTransform* transform) {
  CT_REQUIRE(tree, transform);
  if (!isUserLink(tree, linkA) || !isUserLink(tree, linkB)) {
    return failNoLink(tree, isUserLink(tree, linkA) ? linkB : linkA);
  }
  const Sequence* s = &tree->sequence;
  const Frame between = relativeFrame(ctSceneTree(tree), s, sequenceLink(s, linkA), sequenceLink(s, linkB));
  const Frame a = userFrame(s, linkA);
  const Frame b = userFrame(s, linkB);
  const Frame fromA = transformInverse(&a);
  Frame frame = transformCompose(&between, &b);
  frame = transformCompose(&fromA, &frame);
  copyRotation(&frame, transform->rotation);
  translationOf(&frame, transform->translation);
  return ctSuccess;
}

void ctGetOrientations(ctChainTree* tree, double (*orientations)[9]) {
  if (tree == NULL || orientations == NULL) {
    return;
  }
  const Sequence* s = &tree->sequence;
  const Tree* current = ctSceneTree(tree);
  for (int u = 0; u < s->userLinkCount; u++) {
    const Frame frame = ctTreeRelative(current, s, 0, sequenceLink(s, u));
    copyRotation(&frame, orientations[u]);
  }
}
