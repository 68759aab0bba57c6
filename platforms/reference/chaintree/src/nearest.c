#include "nearest.h"

#include <string.h>

#include "instructions.h"
#include "position.h"
#include "selection.h"

static void positionIn(const Cloud* cloud, int slot, double x[3]) {
  if (cloud->traversal != NULL) {
    ctTraversalPosition(cloud->traversal, slot, x);
  } else {
    memcpy(x, cloud->point[slot], sizeof cloud->point[slot]);
  }
}

void ctNearestOffer(Nearest* n, const Cloud* a, int slotA, const Cloud* b, int slotB) {
  double x[3];
  double y[3];
  positionIn(a, slotA, x);
  positionIn(b, slotB, y);
  double distance = sqrt(squaredDistance(x, y));
  if (a->traversal != NULL && b->traversal != NULL && distance <= n->distance + n->traversal->band) {
    distance = sqrt(ctTreeSquaredDistance(a->traversal->tree, slotA, slotB));
  }
  if (distance < n->distance) {
    n->distance = distance;
    n->pair[0] = a->particle[slotA];
    n->pair[1] = b->particle[slotB];
  }
}

/* ---- A selection as clouds ---- */

static Cloud cloudOfSlots(ctChainTree* scene, const ctSelection* selection) {
  return (Cloud){.layout = &scene->staleTree,
                 .mask = selection->mask,
                 .particle = scene->sequence.slotParticle,
                 .traversal = &scene->traversal};
}

/* Puts the particles without a slot into the world. */
static Cloud cloudOfIdle(ctChainTree* scene, ctSelection* selection, Nearest* nearest) {
  const Tree* tree = ctSceneTree(scene);
  PositionReader reader = ctPositionReader(&scene->sequence, tree);
  for (int i = 0; i < selection->idleCount; i++) {
    double* point = selection->idlePoint[i];
    ctReadFromOrigin(&reader, selection->idle[i], point);
    nearest->extent = larger(nearest->extent, sqrt(dot(point, point)));
  }
  const double(*points)[3] = (const double(*)[3])selection->idlePoint;
  tree->instructions->boundPoints(&selection->idleLayout, points, selection->idleBlock);
  return (Cloud){.layout = &selection->idleLayout,
                 .mask = selection->idleMask,
                 .particle = selection->idle,
                 .block = selection->idleBlock,
                 .point = points};
}

/* Those of its two clouds that are not empty; returns how many. */
static int cloudsOf(ctChainTree* scene, ctSelection* selection, Nearest* nearest, Cloud clouds[2]) {
  int count = 0;
  if (selection->count > selection->idleCount) {
    clouds[count++] = cloudOfSlots(scene, selection);
  }
  if (selection->idleCount > 0) {
    clouds[count++] = cloudOfIdle(scene, selection, nearest);
  }
  return count;
}

ctStatus ctGetMinimumDistance(ctChainTree* tree, ctSelection* selection1, ctSelection* selection2, double* distance,
                              int pair[2], ctCounts* counts) {
  if (selection1->scene != tree || selection2->scene != tree) {
    return ctFail(tree, ctInvalidArgument, "a selection is of another scene");
  }
  const InstructionSet* instructions = ctSceneTree(tree)->instructions;
  Nearest nearest = {.traversal = &tree->traversal, .reach = INFINITY, .distance = INFINITY};
  Cloud clouds1[2];
  Cloud clouds2[2];
  const int count1 = cloudsOf(tree, selection1, &nearest, clouds1);
  const int count2 = cloudsOf(tree, selection2, &nearest, clouds2);
  for (int i = 0; i < count1; i++) {
    for (int j = 0; j < count2; j++) {
      const Cloud clouds[2] = {clouds1[i], clouds2[j]};
      instructions->findNearest(&nearest, clouds);
    }
  }
  if (counts != NULL) {
    counts->volumeTests += nearest.volumeTests;
    counts->particleTests += nearest.particleTests;
  }
  if (nearest.distance == INFINITY) {
    return ctFail(tree, ctInvalidArgument, "the sets of %d and %d particles hold no pair of different particles",
                  selection1->count, selection2->count);
  }
  *distance = nearest.distance;
  memcpy(pair, nearest.pair, sizeof nearest.pair);
  return ctSuccess;
}
