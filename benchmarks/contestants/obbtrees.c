/* The paper's trees of oriented boxes that are rebuilt after each change (section 5): 1-OBBTree, one tree of all
 * spheres, tested against itself; and K-OBBTree, a tree of each rigid piece, tested against those of the others.
 *
 * The trees are those of Gottschalk, Lin and Manocha (1996), whose library the paper used: the spheres of a node are
 * parted where their mean is along the longest edge of its box, until a leaf holds one. */
#include "keeper.h"
#include "obb.h"

typedef struct ObbNode {
  Obb box;
  int first;  /* of its spheres */
  int second; /* the second child, behind the first, which is behind the node itself; 0: a leaf */
} ObbNode;

/* Room for the nodes of one or several trees, and for their spheres. */
typedef struct ObbForest {
  Sphere* spheres; /* parted */
  int* particles;  /* of spheres */
  int nodeCount;
  ObbNode* nodes;
} ObbForest;

static void meanOf(const Sphere* spheres, int count, double mean[3]) {
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
static void principalAxes(const Sphere* spheres, int count, const double mean[3], double axes[3][3]) {
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

static void fitBox(const Sphere* spheres, int count, const double mean[3], Obb* box) {
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
static int part(Sphere* spheres, int* particles, int count, const double normal[3], double at) {
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
static int obbTreeMake(ObbForest* forest, int first, int count) {
  const int index = forest->nodeCount++;
  ObbNode* node = &forest->nodes[index];
  Sphere* spheres = forest->spheres + first;
  double mean[3];
  meanOf(spheres, count, mean);
  node->first = first;
  fitBox(spheres, count, mean, &node->box);
  node->second = 0;
  if (count > 1) {
    const double* half = node->box.half;
    const int longest = half[0] >= half[1] ? (half[0] >= half[2] ? 0 : 2) : (half[1] >= half[2] ? 1 : 2);
    const double* normal = node->box.axes[longest];
    const int firsts = part(spheres, forest->particles + first, count, normal, dot(mean, normal));
    obbTreeMake(forest, first, firsts);
    node->second = obbTreeMake(forest, first + firsts, count - firsts);
  }
  return index;
}

/* Of two leaves. */
static bool spheresClash(const ObbForest* forest, const Scene* scene, int i, int j, Counts* counts) {
  const double sum = forest->spheres[i].radius + forest->spheres[j].radius;
  counts->particleTests++;
  return squaredDistance(forest->spheres[i].x, forest->spheres[j].x) < sum * sum &&
         !sceneExcludes(scene, forest->particles[i], forest->particles[j]);
}

/* Whether spheres of two nodes, neither below the other, clash; the larger box is taken apart first. */
static bool obbNodesClash(const ObbForest* forest, const Scene* scene, int a, int b, Counts* counts) {
  const ObbNode* nodeA = &forest->nodes[a];
  const ObbNode* nodeB = &forest->nodes[b];
  counts->volumeTests++;
  if (!obbsOverlapHere(&nodeA->box, &nodeB->box)) {
    return false;
  }
  if (nodeA->second == 0 && nodeB->second == 0) {
    return spheresClash(forest, scene, nodeA->first, nodeB->first, counts);
  }
  if (nodeB->second == 0 || (nodeA->second > 0 && obbMeasure(&nodeA->box) >= obbMeasure(&nodeB->box))) {
    return obbNodesClash(forest, scene, a + 1, b, counts) || obbNodesClash(forest, scene, nodeA->second, b, counts);
  }
  return obbNodesClash(forest, scene, a, b + 1, counts) || obbNodesClash(forest, scene, a, nodeB->second, counts);
}

/* ---- The contestants ---- */

typedef struct ObbTrees {
  Keeper keeper;
  ObbForest forest;
} ObbTrees;

static void destroy(void* self) {
  ObbForest* forest = &((ObbTrees*)self)->forest;
  free(forest->spheres);
  free(forest->particles);
  free(forest->nodes);
  keeperDestroy(self);
}

static void* make(const Scene* scene) {
  ObbTrees* trees = keeperMake(scene, sizeof *trees);
  trees->forest.spheres = allocate(scene->particleCount, sizeof(Sphere));
  trees->forest.particles = allocate(scene->particleCount, sizeof(int));
  trees->forest.nodes = allocate(2 * scene->particleCount, sizeof(ObbNode));
  return trees;
}

/* Of two nodes of the forest. */
static bool nodesClash(ObbTrees* trees, int a, int b) {
  return obbNodesClash(&trees->forest, trees->keeper.scene, a, b, &trees->keeper.counts);
}

static bool clashesWithItself(ObbTrees* trees, int node) {
  const int second = trees->forest.nodes[node].second;
  return second > 0 && (clashesWithItself(trees, node + 1) || clashesWithItself(trees, second) ||
                        nodesClash(trees, node + 1, second));
}

static bool testOneTree(void* self, int count, const Turn* turns) {
  ObbTrees* trees = self;
  Bodies bodies;
  keeperMove(&trees->keeper, count, turns, &bodies);
  const int particles = trees->keeper.scene->particleCount;
  memcpy(trees->forest.spheres, trees->keeper.trial, (size_t)particles * sizeof(Sphere));
  for (int i = 0; i < particles; i++) {
    trees->forest.particles[i] = i;
  }
  trees->forest.nodeCount = 0;
  return clashesWithItself(trees, obbTreeMake(&trees->forest, 0, particles));
}

/* Makes the tree of the particles of one body, as they are in the trial, behind `first` spheres of other trees. */
static int makeTree(ObbTrees* trees, const Bodies* bodies, int body, int first) {
  int count = 0;
  for (int s = 0; s < bodies->segmentCount; s++) {
    const Segment* segment = &bodies->segments[s];
    for (int i = segment->first; i < segment->last && segment->body == body; i++) {
      trees->forest.spheres[first + count] = trees->keeper.trial[i];
      trees->forest.particles[first + count++] = i;
    }
  }
  return obbTreeMake(&trees->forest, first, count);
}

static bool testTreeOfEachBody(void* self, int count, const Turn* turns) {
  ObbTrees* trees = self;
  Bodies bodies;
  keeperMove(&trees->keeper, count, turns, &bodies);
  int roots[MOST_TURNS + 1];
  int rootCount = 0;
  int first = 0;
  trees->forest.nodeCount = 0;
  for (int body = 0; body < bodies.bodyCount; body++) {
    if (bodies.sizes[body] > 0) {
      roots[rootCount++] = makeTree(trees, &bodies, body, first);
      first += bodies.sizes[body];
    }
  }
  for (int a = 0; a < rootCount; a++) {
    for (int b = 0; b < a; b++) {
      if (nodesClash(trees, roots[a], roots[b])) {
        return true;
      }
    }
  }
  return false;
}

#define OBB_TREES(itsName, itsIdea, itsTest)                                                                     \
  {                                                                                                              \
    .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .test = itsTest, .accept = keeperAccept, \
    .reject = keeperReject, .counts = keeperCounts, .spheres = keeperSpheres                                     \
  }

const Contestant CONTESTANT(contestantObbTree1) = OBB_TREES("obbtree1",
                                                            "the paper's 1-OBBTree: one tree of boxes for each trial",
                                                            testOneTree);
const Contestant CONTESTANT(contestantKObbTree) =
    OBB_TREES("kobbtree", "the paper's K-OBBTree: a tree of boxes of each rigid piece", testTreeOfEachBody);
