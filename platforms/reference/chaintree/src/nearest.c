#include "nearest.h"

#include <string.h>

#include "position.h"
#include "selection.h"
#include "wide.h"

static void positionIn(const Cloud* cloud, int slot, double x[3]) {
  if (cloud->traversal != NULL) {
    ctTraversalPosition(cloud->traversal, slot, x);
  } else {
    memcpy(x, cloud->point[slot], sizeof cloud->point[slot]);
  }
}

static bool isBefore(const int one[2], const int other[2]) {
  return one[0] < other[0] || (one[0] == other[0] && one[1] < other[1]);
}

/* Of several nearest pairs takes the lowest, so that the result does not depend on their order. */
void ctNearestOffer(Nearest* n, const Cloud* a, int slotA, const Cloud* b, int slotB) {
  double x[3];
  double y[3];
  positionIn(a, slotA, x);
  positionIn(b, slotB, y);
  double distance = sqrt(squaredDistance(x, y));
  if (a->traversal != NULL && b->traversal != NULL && distance <= n->distance + n->traversal->tieBand) {
    distance = sqrt(ctTreeSquaredDistance(a->traversal->tree, slotA, slotB));
  }
  const int pair[2] = {a->particle[slotA], b->particle[slotB]};
  if (distance < n->distance || (distance == n->distance && isBefore(pair, n->pair))) {
    n->distance = distance;
    memcpy(n->pair, pair, sizeof pair);
  }
}

/* ---- A selection as clouds ---- */

static Cloud cloudOfSlots(ctChainTree* scene, const ctSelection* selection) {
  return (Cloud){.layout = &scene->ownTree,
                 .mask = selection->mask,
                 .particle = scene->sequence.slotParticle,
                 .traversal = &scene->traversal};
}

/* Computes the world coordinates of the particles that are not modelled. */
static Cloud cloudOfUnmodelled(ctChainTree* scene, ctSelection* selection, Nearest* nearest) {
  const Tree* tree = ctSceneTree(scene);
  PositionReader reader = ctPositionReader(&scene->sequence, &scene->world);
  for (int i = 0; i < selection->unmodelledCount; i++) {
    double* point = selection->unmodelledPoint[i];
    ctReadFromOrigin(&reader, selection->unmodelled[i], point);
    nearest->coordinateBound = larger(nearest->coordinateBound, sqrt(dot(point, point)));
  }
  const double(*points)[3] = (const double(*)[3])selection->unmodelledPoint;
  tree->wide->boundPoints(&selection->unmodelledLayout, points, selection->unmodelledBlock);
  return (Cloud){.layout = &selection->unmodelledLayout,
                 .mask = selection->unmodelledMask,
                 .particle = selection->unmodelled,
                 .block = selection->unmodelledBlock,
                 .point = points};
}

/* Lists the two clouds of a selection that are not empty; returns how many. */
static int cloudsOf(ctChainTree* scene, ctSelection* selection, Nearest* nearest, Cloud clouds[2]) {
  int count = 0;
  if (selection->count > selection->unmodelledCount) {
    clouds[count++] = cloudOfSlots(scene, selection);
  }
  if (selection->unmodelledCount > 0) {
    clouds[count++] = cloudOfUnmodelled(scene, selection, nearest);
  }
  return count;
}

/* ---- The pair that was nearest before ---- */

/* The distance now of the pair that was nearest in the last query of one of the selections; INFINITY if it is no pair
 * of these two. After a small move few pairs are nearer. */
static double knownDistance(ctChainTree* scene, const ctSelection* one, const ctSelection* other) {
  if (one->nearest[0] == CT_NULL || !ctSelectionHolds(other, one->nearest[1])) {
    return INFINITY;
  }
  double x[2][3];
  PositionReader reader = ctPositionReader(&scene->sequence, ctSceneWorld(scene));
  for (int k = 0; k < 2; k++) {
    ctReadFromOrigin(&reader, one->nearest[k], x[k]);
  }
  return sqrt(squaredDistance(x[0], x[1]));
}

static void keepNearest(ctSelection* one, ctSelection* other, const int pair[2]) {
  for (int k = 0; k < 2; k++) {
    one->nearest[k] = pair[k];
    other->nearest[k] = pair[1 - k];
  }
}

ctStatus ctGetMinimumDistance(ctChainTree* tree, ctSelection* selection1, ctSelection* selection2, double* distance,
                              int pair[2], ctCounts* counts) {
  CT_REQUIRE(tree, selection1);
  CT_REQUIRE(tree, selection2);
  CT_REQUIRE(tree, distance);
  CT_REQUIRE(tree, pair);
  if (selection1->scene != tree || selection2->scene != tree) {
    return ctFail(tree, ctInvalidArgument, "a selection is of another scene");
  }
  const Wide* wide = ctSceneTree(tree)->wide;
  Nearest nearest = {.traversal = &tree->traversal, .reach = INFINITY, .distance = INFINITY};
  Cloud clouds1[2];
  Cloud clouds2[2];
  const int count1 = cloudsOf(tree, selection1, &nearest, clouds1);
  const int count2 = cloudsOf(tree, selection2, &nearest, clouds2);
  nearest.known = lesser(knownDistance(tree, selection1, selection2), knownDistance(tree, selection2, selection1));
  for (int i = 0; i < count1; i++) {
    for (int j = 0; j < count2; j++) {
      const Cloud clouds[2] = {clouds1[i], clouds2[j]};
      wide->findNearest(&nearest, clouds);
    }
  }
  addTests(counts, nearest.volumeTests, nearest.particleTests);
  if (nearest.distance == INFINITY) {
    return ctFail(tree, ctInvalidArgument, "the sets of %d and %d particles hold no pair of different particles",
                  selection1->count, selection2->count);
  }
  *distance = nearest.distance;
  memcpy(pair, nearest.pair, sizeof nearest.pair);
  keepNearest(selection1, selection2, pair);
  return ctSuccess;
}
