/* The search for the nearest pair. */
#include "view.h"

/* ---- Clouds ---- */

/* A node of a cloud or one slot of a leaf, with a sphere around the centres of its particles. */
typedef struct Cluster {
  int level;
  int node;
  unsigned members; /* of the node that belong to the cluster; bits */
  Sphere around;
} Cluster;

/* The members of a cluster's node in the world, but for their radii. Its parent must be up to date. */
static const Block* membersOf(const Cloud* cloud, const Cluster* cluster) {
  if (cloud->traversal == NULL) {
    return &cloud->block[cluster->node];
  }
  updateWorld(cloud->traversal->world, cluster->level, cluster->node);
  return worldOf(cloud->traversal->world, cluster->node);
}

/* The radii of spheres around the centres of particles. */
static const float* radiiOf(const Cloud* cloud, const Cluster* cluster) {
  static const float points[TREE_WIDTH] = {0};
  if (cluster->level == 0) {
    return points;
  }
  return cloud->traversal == NULL ? cloud->block[cluster->node].r
                                  : treeMembers(cloud->traversal->tree, cluster->node)->centres;
}

static Cluster rootOf(const Cloud* cloud) {
  const int root = treeRoot(cloud->layout);
  return (Cluster){treeTop(cloud->layout), root, cloud->mask[root], {0, 0, 0, INFINITY}};
}

/* ---- Points of their own ---- */

/* Computes the spheres of all nodes over points. They have no room for rounding, see findNearest. */
void CT_WIDE(boundPoints)(const Tree* layout, const double (*point)[3], Block* block) {
  for (int level = 0; level < layout->levelCount; level++) {
    for (int i = 0; i < layout->levelSize[level]; i++) {
      const int node = layout->levelBegin[level] + i;
      Block* own = &block[node];
      int end;
      const int begin = treeSlots(layout, level, node, &end);
      if (level == 0) {
        for (int k = 0; k < TREE_WIDTH; k++) {
          const bool empty = begin + k >= end;
          own->x[k] = empty ? 0 : (float)point[begin + k][0];
          own->y[k] = empty ? 0 : (float)point[begin + k][1];
          own->z[k] = empty ? 0 : (float)point[begin + k][2];
          own->r[k] = empty ? -INFINITY : 0;
        }
      }
      if (level < treeTop(layout)) {
        Sphere sphere = middleOfBlock(own);
        sphere.r = radiusAbout(sphere, own, own->r);
        Block* parent = &block[treeParent(layout, level, node)];
        const int k = memberIndex(i);
        parent->x[k] = sphere.x;
        parent->y[k] = sphere.y;
        parent->z[k] = sphere.z;
        parent->r[k] = sphere.r;
      }
    }
  }
}

/* The box around the members of the root that belong to the cloud. */
void CT_WIDE(boundCloud)(const Cloud* cloud, double low[3], double high[3]) {
  const Cluster root = rootOf(cloud);
  Block block = *membersOf(cloud, &root);
  store16(block.r, blend16(root.members, all16(-INFINITY), load16(radiiOf(cloud, &root))));
  boundsOfBlock(&block, low, high);
}

/* ---- The search ---- */

/* A sphere around a cluster of this side, relative to the other side's members: these are of an image if they are of
 * the first cloud. */
static Sphere seenFrom(const Nearest* n, int side, Sphere around) {
  return shifted(around, n->shift, side == 0 ? 1 : -1);
}

typedef struct NearestVisit {
  float bound; /* of the distance of the two clusters, but for rounding */
  Cluster cluster[2];
} NearestVisit;

/* The members (bits) of leaf b of the other cloud that are the same particle as member k of leaf a of one. */
static unsigned itself(const Cloud clouds[2], int side, int a, int k, int b) {
  if (clouds[0].traversal != clouds[1].traversal) {
    return 0; /* a particle with a slot, and one without */
  }
  if (clouds[0].traversal != NULL) {
    return a == b ? 1u << k : 0;
  }
  return equal16(clouds[1 - side].particle + b * TREE_WIDTH, clouds[side].particle[a * TREE_WIDTH + k]);
}

static void offer(Nearest* n, const Cloud clouds[2], int side, int slot, int otherSlot) {
  const int slots[2] = {side == 0 ? slot : otherSlot, side == 0 ? otherSlot : slot};
  ctNearestOffer(n, &clouds[0], slots[0], &clouds[1], slots[1]);
}

static void compareLeaves(Nearest* n, const Cloud clouds[2], const Cluster leaves[2]) {
  /* Fewer slots of the larger leaf are near the smaller one than the other way round. */
  const int side = leaves[1].around.r > leaves[0].around.r;
  const Cluster* one = &leaves[side];
  const Cluster* other = &leaves[1 - side];
  membersOf(&clouds[side], one);
  const Block* otherBlock = membersOf(&clouds[1 - side], other);
  const Block* block = membersOf(&clouds[side], one); /* again, as in blocksOf */
  const Sphere around = seenFrom(n, 1 - side, other->around);
  const float far = around.r + n->reach;
  const unsigned slots = one->members & greater16(all16(far * far), squaredFrom(block, around.x, around.y, around.z));
  n->volumeTests += __builtin_popcount(one->members);
  n->particleTests += __builtin_popcount(slots) * __builtin_popcount(other->members);
  /* First the least distance in float, so that few pairs are compared in double. */
  Float16 rows[TREE_WIDTH];
  Float16 least = all16(INFINITY);
  for (unsigned left = slots; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const unsigned others = other->members & ~itself(clouds, side, one->node, k, other->node);
    const Sphere own = seenFrom(n, side, (Sphere){block->x[k], block->y[k], block->z[k], 0});
    rows[k] = blend16(others, all16(INFINITY), squaredFrom(otherBlock, own.x, own.y, own.z));
    least = min16(least, rows[k]);
  }
  if (greater16(all16(n->reach * n->reach), least) == 0) {
    return;
  }
  const float reach = sqrtf(least16(least)) + 2 * n->margin;
  n->reach = reach < n->reach ? reach : n->reach;
  const Float16 squaredReach = all16(n->reach * n->reach);
  for (unsigned left = slots; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    for (unsigned near = greater16(squaredReach, rows[k]); near != 0; near &= near - 1) {
      offer(n, clouds, side, one->node * TREE_WIDTH + k, other->node * TREE_WIDTH + __builtin_ctz(near));
    }
  }
}

/* Puts the members of one cluster on the stack, each with the other cluster; the nearest one last, to be visited first.
 */
static int splitCluster(Nearest* n, const Cloud* cloud, const NearestVisit* visit, int side, NearestVisit* stack) {
  const Cluster* whole = &visit->cluster[side];
  const Sphere other = seenFrom(n, 1 - side, visit->cluster[1 - side].around);
  const Block* block = membersOf(cloud, whole);
  const float* radii = radiiOf(cloud, whole);
  n->volumeTests += __builtin_popcount(whole->members);
  const Float16 squared = squaredFrom(block, other.x, other.y, other.z);
  const Float16 sum = max16(add16(load16(radii), all16(other.r + n->reach)), all16(0));
  const unsigned near = whole->members & greater16(mul16(sum, sum), squared);
  if (near == 0) {
    return 0;
  }
  const Float16 bounds = sub16(sub16(sqrt16(squared), load16(radii)), all16(other.r));
  float bound[TREE_WIDTH];
  store16(bound, bounds);
  unsigned nearest = near;
  if ((near & (near - 1)) != 0) {
    const Float16 ofNear = blend16(near, all16(INFINITY), bounds);
    nearest = near & ~greater16(ofNear, all16(least16(ofNear)));
  }
  const bool isLeaf = whole->level == 0;
  int count;
  const int first = isLeaf ? 0 : treeChildren(cloud->layout, whole->level, whole->node, &count);
  int pushed = 0;
  for (int last = 0; last < 2; last++) {
    for (unsigned members = last ? nearest : near & ~nearest; members != 0; members &= members - 1) {
      const int k = __builtin_ctz(members);
      NearestVisit* part = &stack[pushed++];
      part->bound = bound[k];
      const Sphere around = {block->x[k], block->y[k], block->z[k], radii[k]};
      part->cluster[side] = isLeaf ? (Cluster){0, whole->node, 1u << k, around}
                                   : (Cluster){whole->level - 1, first + k, cloud->mask[first + k], around};
      part->cluster[1 - side] = visit->cluster[1 - side];
    }
  }
  return pushed;
}

/* True if a cluster is a single slot. */
static bool isSlot(const Cluster* cluster) {
  return cluster->level == 0 && (cluster->members & (cluster->members - 1)) == 0;
}

/* Chooses the cluster to split: the larger one. */
static int sideToSplit(const Cluster clusters[2]) {
  const Cluster* a = &clusters[0];
  const Cluster* b = &clusters[1];
  return isSlot(a) || (!isSlot(b) && b->around.r > a->around.r);
}

/* Searches two clouds. The margin: distances of spheres in float are off by up to 38 u E for their centres and 12 u E
 * for the test (u = 2^-24, E: the larger coordinate bound; see FLOAT_MARGIN, here without motions of a view), those of
 * points by 8 u E. The reach is a distance of points, or one in double, with two margins of 67 u E: one for itself, one
 * for the spheres. That leaves 76 u E for the radii of spheres around points of their own, which have no room for
 * rounding: 5 u for each level. */
void CT_WIDE(findNearest)(Nearest* n, const Cloud clouds[2]) {
  /* Splits go down both trees to single slots, each with all members of a node on the stack. */
  NearestVisit stack[2 * (TREE_MAX_LEVELS + 1) * TREE_WIDTH];
  Traversal* t = n->traversal;
  const View view = ctViewOfState(0);
  CT_WIDE(startView)(t, &view);
  n->margin = (float)floatMargin(larger(t->coordinateBound, n->coordinateBound));
  const float known = (float)n->known + 2 * n->margin;
  n->reach = known < n->reach ? known : n->reach;
  int depth = 0;
  stack[depth++] = (NearestVisit){-INFINITY, {rootOf(&clouds[0]), rootOf(&clouds[1])}};
  while (depth > 0) {
    const NearestVisit visit = stack[--depth];
    if (visit.bound >= n->reach) {
      continue;
    }
    if (visit.cluster[0].level == 0 && visit.cluster[1].level == 0) {
      compareLeaves(n, clouds, visit.cluster);
    } else {
      const int side = sideToSplit(visit.cluster);
      depth += splitCluster(n, &clouds[side], &visit, side, stack + depth);
    }
  }
}
