#include "scene.h"

#include <stdarg.h>
#include <stdio.h>

ctStatus ctFail(ctChainTree* scene, ctStatus status, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(scene->errorText, sizeof scene->errorText, format, arguments);
  va_end(arguments);
  return status;
}

Tree* ctSceneLooseTree(ctChainTree* scene) {
  if (stateChangedSince(&scene->ownTree.changes, scene->ownTree.builtFrom)) {
    ctPathsMultiply(&scene->sequence);
    ctTreeRefresh(&scene->ownTree, &scene->sequence);
  }
  return &scene->ownTree;
}

Tree* ctSceneTree(ctChainTree* scene) {
  Tree* tree = ctSceneLooseTree(scene);
  ctTreeTighten(tree);
  return tree;
}

World* ctSceneWorld(ctChainTree* scene) {
  ctSceneTree(scene);
  return &scene->world;
}

Sweep* ctSceneSweep(ctChainTree* scene) {
  Sweep* sweep = &scene->ownSweep;
  const Changes* changes = &scene->ownTree.changes;
  if (!ctSweepReserve(sweep)) {
    return NULL;
  }
  if (stateChangedSince(changes, sweep->snapshot.builtFrom)) {
    /* Equal states have equal bits: use the reference whenever it is the state. */
    if (scene->sequence.displacedCount == 0 && !ctSequenceIsWrapped(&scene->sequence)) {
      ctSnapshotTakeReference(&sweep->snapshot, &scene->sequence);
    } else if (ctSnapshotReserve(&sweep->snapshot, &sweep->arena, &scene->sequence)) {
      ctSnapshotTakeTree(&sweep->snapshot, &scene->sequence, ctSceneWorld(scene));
    } else {
      return NULL;
    }
    ctSweepBound(sweep);
    sweep->snapshot.builtFrom = changes->now;
  }
  return sweep;
}

ctStatus ctFailOutOfMemory(ctChainTree* scene) {
  return ctFail(scene, ctOutOfMemory, "out of memory");
}

ctStatus ctFailNoTrial(ctChainTree* scene) {
  return ctFail(scene, ctNoTrial, "there is no open trial");
}

ctStatus ctFailMissing(ctChainTree* scene, const char* argument) {
  return scene == NULL ? ctInvalidArgument : ctFail(scene, ctInvalidArgument, "%s is NULL", argument);
}

ctStatus ctCheckCutoff(ctChainTree* scene, double cutoff) {
  if (!(cutoff > 0) || !isfinite(cutoff)) {
    return ctFail(scene, ctInvalidArgument, "the cutoff is %g nm; it must be finite and positive", cutoff);
  }
  if (scene->sequence.box.isPeriodic && 2 * cutoff > ctBoxWidth(&scene->sequence.box)) {
    return ctFail(scene, ctInvalidArgument,
                  "the cutoff is %g nm; it must be at most half the periodic box's width, %g nm", cutoff,
                  ctBoxWidth(&scene->sequence.box) / 2);
  }
  return ctSuccess;
}

Image ctSceneNearestImage(ctChainTree* scene, int slotA, int slotB) {
  const Tree* tree = ctSceneTree(scene);
  double a[3];
  double b[3];
  double apart[3];
  ctTreeSlotInWorld(tree, slotA, a);
  ctTreeSlotInWorld(tree, slotB, b);
  subtract(a, b, apart);
  return ctNearestImage(&scene->sequence.box, apart);
}

void ctSceneSearchImages(ctChainTree* scene, double reach, CandidateFunction* function, void* context,
                         ctCounts* counts) {
  if (scene->sequence.box.isPeriodic) {
    const View view = ctViewOfState(reach);
    ctSceneTree(scene);
    ctTraverseImages(&scene->traversal, &view, &scene->sequence.box, false, function, context, counts);
  }
}

ctStatus ctCheckParticles(ctChainTree* scene, int count, const int* particles) {
  const int particleCount = scene->sequence.particleCount;
  if (count < 0 || count > CT_MOST_COUNT || (count > 0 && particles == NULL)) {
    return ctFail(scene, ctInvalidArgument, "there cannot be %d particles%s", count,
                  particles == NULL ? " without a list of them" : "");
  }
  for (int i = 0; i < count; i++) {
    if (particles[i] < 0 || particles[i] >= particleCount) {
      return ctFail(scene, ctInvalidArgument, "there is no particle %d; there are %d particles", particles[i],
                    particleCount);
    }
  }
  return ctSuccess;
}
