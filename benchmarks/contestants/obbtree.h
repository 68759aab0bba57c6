/* A tree of oriented boxes over any spheres, made from scratch by their positions: the spheres of a node are parted
 * where their mean is along the longest edge of its box (Gottschalk, Lin and Manocha, 1996). A few spheres are tested
 * sooner than parted. */
#ifndef OBBTREE_H_
#define OBBTREE_H_

#include <stdlib.h>

#include "bodies.h"
#include "obb.h"

enum { LEAF_SPHERES = 8 };

typedef struct ObbNode {
  Obb box;
  int first; /* its spheres */
  int count;
  int second; /* the second child, behind the first, which is behind the node itself; 0: a leaf */
} ObbNode;

/* Room for the nodes of one or several trees, and for their spheres. */
typedef struct ObbForest {
  Sphere* spheres; /* parted */
  int* particles;  /* of spheres */
  int nodeCount;
  ObbNode* nodes;
} ObbForest;

static inline void obbForestFree(ObbForest* forest) {
  free(forest->spheres);
  free(forest->particles);
  free(forest->nodes);
}

/* For up to `count` spheres; false if there is no memory. */
static inline bool obbForestInit(ObbForest* forest, int count) {
  const size_t size = (size_t)count + 1;
  forest->spheres = malloc(size * sizeof(Sphere));
  forest->particles = malloc(size * sizeof(int));
  forest->nodes = malloc(2 * size * sizeof(ObbNode));
  return forest->spheres != NULL && forest->particles != NULL && forest->nodes != NULL;
}

static inline void meanOf(const Sphere* spheres, int count, double mean[3]) {
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < count; i++) {
    sum[0] += spheres[i].x[0];
    sum[1] += spheres[i].x[1];
    sum[2] += spheres[i].x[2];
  }
  for (int k = 0; k < 3; k++) {
    mean[k] = sum[k] / count;
  }
}

/* The eigenvectors of the covariance of the centres. */
static inline void principalAxes(const Sphere* spheres, int count, const double mean[3], double axes[3][3]) {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (int i = 0; i < count; i++) {
    const double x = spheres[i].x[0] - mean[0];
    const double y = spheres[i].x[1] - mean[1];
    const double z = spheres[i].x[2] - mean[2];
    xx += x * x;
    xy += x * y;
    xz += x * z;
    yy += y * y;
    yz += y * z;
    zz += z * z;
  }
  double covariance[3][3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
  eigenvectors(covariance, axes);
}

static inline void fitBox(const Sphere* spheres, int count, const double mean[3], Obb* box) {
  if (count == 1) {
    *box = obbOfSphere(spheres[0].radius);
    memcpy(box->centre, spheres[0].x, sizeof box->centre);
    return;
  }
  double line[3];
  subtract(spheres[count - 1].x, spheres[0].x, line);
  if (count > 2 || !axesAlong(line, &(Obb){.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, box->axes)) {
    principalAxes(spheres, count, mean, box->axes);
  }
  double low[3] = {INFINITY, INFINITY, INFINITY};
  double high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int i = 0; i < count; i++) {
    for (int k = 0; k < 3; k++) {
      const double at = dot(spheres[i].x, box->axes[k]);
      low[k] = at - spheres[i].radius < low[k] ? at - spheres[i].radius : low[k];
      high[k] = at + spheres[i].radius > high[k] ? at + spheres[i].radius : high[k];
    }
  }
  obbSetExtents(box, low, high);
}

/* Parts spheres by the side of a plane they are on; returns how many come first, neither none nor all. */
static inline int part(Sphere* spheres, int* particles, int count, const double normal[3], double at) {
  int first = 0;
  for (int i = 0; i < count; i++) {
    if (dot(spheres[i].x, normal) < at) {
      const Sphere sphere = spheres[i];
      const int particle = particles[i];
      spheres[i] = spheres[first];
      particles[i] = particles[first];
      spheres[first] = sphere;
      particles[first++] = particle;
    }
  }
  return first == 0 || first == count ? count / 2 : first;
}

/* Makes the tree of some spheres of the forest, and returns its root. */
static inline int obbTreeMake(ObbForest* forest, int first, int count) {
  const int index = forest->nodeCount++;
  ObbNode* node = &forest->nodes[index];
  Sphere* spheres = forest->spheres + first;
  double mean[3];
  meanOf(spheres, count, mean);
  node->first = first;
  node->count = count;
  fitBox(spheres, count, mean, &node->box);
  node->second = 0;
  if (count > LEAF_SPHERES) {
    const double* half = node->box.half;
    const int longest = half[0] >= half[1] ? (half[0] >= half[2] ? 0 : 2) : (half[1] >= half[2] ? 1 : 2);
    const double* normal = node->box.axes[longest];
    const int firsts = part(spheres, forest->particles + first, count, normal, dot(mean, normal));
    obbTreeMake(forest, first, firsts);
    node->second = obbTreeMake(forest, first + firsts, count - firsts);
  }
  return index;
}

/* Pairs of spheres of a range with those of another, or of the same. */
static inline bool rangesClash(const ObbForest* forest, const Scene* scene, const ObbNode* a, const ObbNode* b,
                               Counts* counts) {
  for (int i = a->first; i < a->first + a->count; i++) {
    const Sphere* sphere = &forest->spheres[i];
    for (int j = a == b ? i + 1 : b->first; j < b->first + b->count; j++) {
      const double sum = sphere->radius + forest->spheres[j].radius;
      counts->particleTests++;
      if (squaredDistance(sphere->x, forest->spheres[j].x) < sum * sum &&
          !sceneExcludes(scene, forest->particles[i], forest->particles[j])) {
        return true;
      }
    }
  }
  return false;
}

/* Whether spheres of two nodes, neither below the other, clash; the larger box is taken apart first. */
static inline bool obbNodesClash(const ObbForest* forest, const Scene* scene, int a, int b, Counts* counts) {
  const ObbNode* nodeA = &forest->nodes[a];
  const ObbNode* nodeB = &forest->nodes[b];
  counts->volumeTests++;
  if (!obbsOverlapHere(&nodeA->box, &nodeB->box)) {
    return false;
  }
  if (nodeA->second == 0 && nodeB->second == 0) {
    return rangesClash(forest, scene, nodeA, nodeB, counts);
  }
  if (nodeB->second == 0 || (nodeA->second > 0 && obbMeasure(&nodeA->box) >= obbMeasure(&nodeB->box))) {
    return obbNodesClash(forest, scene, a + 1, b, counts) || obbNodesClash(forest, scene, nodeA->second, b, counts);
  }
  return obbNodesClash(forest, scene, a, b + 1, counts) || obbNodesClash(forest, scene, a, nodeB->second, counts);
}

#endif /* OBBTREE_H_ */
