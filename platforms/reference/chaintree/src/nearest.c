#include "nearest.h"

#include <string.h>

#include "position.h"
#include "selection.h"
#include "volume.h"
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
  double distance = sqrt(n->image == NULL ? squaredDistance(x, y) : squaredImageDistance(x, y, n->image));
  if (a->traversal != NULL && b->traversal != NULL && distance <= n->distance + n->traversal->tieBand) {
    const Tree* tree = a->traversal->tree;
    distance = sqrt(n->image == NULL ? ctTreeSquaredDistance(tree, slotA, slotB)
                                     : ctTreeSquaredImageDistance(tree, slotA, slotB, n->image));
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

static void searchClouds(ctChainTree* scene, Nearest* nearest, int count1, const Cloud clouds1[2], int count2,
                         const Cloud clouds2[2]) {
  for (int i = 0; i < count1; i++) {
    for (int j = 0; j < count2; j++) {
      const Cloud clouds[2] = {clouds1[i], clouds2[j]};
      ctSceneTree(scene)->wide->findNearest(nearest, clouds);
    }
  }
}

/* The box around the points of some clouds, by the spheres around their nodes. */
static void boundClouds(ctChainTree* scene, int count, const Cloud clouds[2], double low[3], double high[3]) {
  for (int d = 0; d < 3; d++) {
    low[d] = INFINITY;
    high[d] = -INFINITY;
  }
  for (int i = 0; i < count; i++) {
    double cloudLow[3];
    double cloudHigh[3];
    ctSceneTree(scene)->wide->boundCloud(&clouds[i], cloudLow, cloudHigh);
    for (int d = 0; d < 3; d++) {
      low[d] = lesser(low[d], cloudLow[d]);
      high[d] = larger(high[d], cloudHigh[d]);
    }
  }
}

/* Looks for nearer pairs in images. The nearest image of the nearest pair so far bounds the search. */
static void searchImages(ctChainTree* scene, Nearest* nearest, int count1, const Cloud clouds1[2], int count2,
                         const Cloud clouds2[2]) {
  double x[2][3];
  double apart[3];
  PositionReader reader = ctPositionReader(&scene->sequence, ctSceneWorld(scene));
  for (int k = 0; k < 2; k++) {
    ctReadFromOrigin(&reader, nearest->pair[k], x[k]);
  }
  subtract(x[0], x[1], apart);
  const Image known = ctNearestImage(&scene->sequence.box, apart);
  nearest->known = lesser(nearest->known, sqrt(squaredImageDistance(x[0], x[1], &known)));
  double low[2][3];
  double high[2][3];
  boundClouds(scene, count1, clouds1, low[0], high[0]);
  boundClouds(scene, count2, clouds2, low[1], high[1]);
  const double size = larger(scene->traversal.coordinateBound, nearest->coordinateBound);
  const double reach = nearest->known + floatMargin(4 * size);
  ImageRange range = ctImageRange(&scene->sequence.box, low[0], high[0], low[1], high[1], reach);
  while (ctNextImage(&range)) {
    const double* shift = range.image.shift;
    nearest->image = &range.image;
    nearest->coordinateBound = larger(nearest->coordinateBound, size + sqrt(dot(shift, shift)));
    for (int d = 0; d < 3; d++) {
      nearest->shift[d] = (float)shift[d];
    }
    searchClouds(scene, nearest, count1, clouds1, count2, clouds2);
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
  Nearest nearest = {.traversal = &tree->traversal, .reach = INFINITY, .distance = INFINITY};
  Cloud clouds1[2];
  Cloud clouds2[2];
  const int count1 = cloudsOf(tree, selection1, &nearest, clouds1);
  const int count2 = cloudsOf(tree, selection2, &nearest, clouds2);
  nearest.known = lesser(knownDistance(tree, selection1, selection2), knownDistance(tree, selection2, selection1));
  searchClouds(tree, &nearest, count1, clouds1, count2, clouds2);
  if (tree->sequence.box.isPeriodic && nearest.distance < INFINITY) {
    searchImages(tree, &nearest, count1, clouds1, count2, clouds2);
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
