/* An accepted turn of one torsion changes O(log N) nodes, on at most two paths (sections 2.1 and 3.1): by the counts it
 * returns, and by comparing all storage of the tree, leaves included, before and after. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The storage is not public. */
#include "../src/scene.h"

typedef enum Shape {
  CHAIN,       /* each torsion moves all that follows */
  MIDDLE_ROOT, /* rooted in the middle: a torsion of the first arm moves an interval that ends inside the sequence */
  COMB         /* a side chain of two links on every link of the backbone */
} Shape;

static const char* const shapeNames[] = {"chain", "chain rooted in its middle", "comb"};

static int parentOf(Shape shape, int link, int count) {
  switch (shape) {
    case CHAIN:
      return link - 1;
    case MIDDLE_ROOT:
      return link < count / 2 ? link + 1 : (link == count / 2 ? CT_NULL : link - 1);
    default:
      return link % 3 == 0 ? link - 3 : link - 1;
  }
}

static bool isTorsion(Shape shape, int link, int count) {
  return parentOf(shape, link, count) >= 0;
}

/* Whether a link carries another than itself: a particle on its own axis stays where it is. */
static bool carries(Shape shape, int link) {
  return shape != COMB || link % 3 != 2;
}

/* A zigzag of one particle a link. */
static ctChainTree* makeScene(Shape shape, int count) {
  double* positions = malloc((size_t)count * sizeof(double[3]));
  double* radii = malloc((size_t)count * sizeof(double));
  int* links = malloc((size_t)count * sizeof(int));
  int* parents = malloc((size_t)count * sizeof(int));
  uint8_t* joints = malloc((size_t)count);
  int(*torsions)[4] = calloc((size_t)count, sizeof *torsions);
  ctChainTree* tree = NULL;
  if (positions != NULL && radii != NULL && links != NULL && parents != NULL && joints != NULL && torsions != NULL) {
    for (int i = 0; i < count; i++) {
      const int parent = parentOf(shape, i, count);
      positions[3 * (size_t)i] = 0.3 * i;
      positions[3 * (size_t)i + 1] = i % 2 == 0 ? 0 : 0.2;
      positions[3 * (size_t)i + 2] = i % 3 == 0 ? 0 : 0.1;
      radii[i] = 0.1;
      links[i] = i;
      parents[i] = parent >= 0 ? parent : CT_NULL;
      joints[i] = isTorsion(shape, i, count) ? ctTorsionJoint : ctFreeJoint;
      if (parent >= 0) {
        const int torsion[4] = {parent, parent, i, i};
        memcpy(torsions[i], torsion, sizeof torsion);
      }
    }
    const ctDefinition definition = {.particleCount = count,
                                     .positions = positions,
                                     .radii = radii,
                                     .particleLinks = links,
                                     .linkCount = count,
                                     .linkParents = parents,
                                     .linkJoints = joints,
                                     .linkTorsions = (const int(*)[4])torsions};
    char text[200];
    if (ctCreate(&definition, &tree, text, sizeof text) != ctSuccess) {
      printf("%s\n", text);
    }
  }
  free(positions);
  free(radii);
  free(links);
  free(parents);
  free(joints);
  free(torsions);
  return tree;
}

typedef struct Storage {
  Frame* shortcut;
  Frame* pose;
  Bound* bound;
  double (*sum)[3];
  Leaf* leaf;
  Members* members;
  Frame* product;
  Frame* returnFrame;
} Storage;

static void* copyOf(const void* data, size_t size) {
  void* copy = malloc(size + 1);
  if (copy == NULL) {
    printf("out of memory\n");
    exit(1);
  }
  memcpy(copy, data, size);
  return copy;
}

static Storage copyStorage(ctChainTree* scene) {
  Tree* tree = ctSceneTree(scene);
  const Sequence* s = &scene->sequence;
  ctTreeCompleteSums(tree, s);
  const size_t nodes = (size_t)tree->nodeCount;
  const size_t leaves = (size_t)tree->levelBegin[1];
  return (Storage){copyOf(tree->shortcut, nodes * sizeof(Frame)),
                   copyOf(tree->pose, nodes * sizeof(Frame)),
                   copyOf(tree->bound, nodes * sizeof(Bound)),
                   copyOf(tree->sum, nodes * sizeof(double[3])),
                   copyOf(tree->leaf, leaves * sizeof(Leaf)),
                   copyOf(tree->members, (nodes - leaves) * sizeof(Members)),
                   copyOf(s->product, (size_t)s->productBegin[s->returnFrameCount] * sizeof(Frame)),
                   copyOf(s->returnFrame, (size_t)s->returnFrameCount * sizeof(Frame))};
}

static void freeStorage(Storage* storage) {
  free(storage->shortcut);
  free(storage->pose);
  free(storage->bound);
  free(storage->sum);
  free(storage->leaf);
  free(storage->members);
  free(storage->product);
  free(storage->returnFrame);
}

static bool differ(const void* a, const void* b, size_t size) {
  return memcmp(a, b, size) != 0;
}

/* True if a node has changed: its own shortcut, bound and sum, its children's poses and volumes, or a leaf's slots. */
static bool nodeChanged(const Storage* a, const Storage* b, const Tree* tree, int level, int node) {
  bool changed = differ(&a->shortcut[node], &b->shortcut[node], sizeof(Frame)) ||
                 differ(&a->bound[node], &b->bound[node], sizeof(Bound)) ||
                 differ(&a->sum[node], &b->sum[node], sizeof(double[3]));
  if (level == 0) {
    return changed || differ(&a->leaf[node], &b->leaf[node], sizeof(Leaf));
  }
  int count;
  const int first = treeChildren(tree, level, node, &count);
  const int inner = node - tree->levelBegin[1];
  return changed || differ(&a->pose[first], &b->pose[first], (size_t)count * sizeof(Frame)) ||
         differ(&a->members[inner], &b->members[inner], sizeof(Members));
}

static int countChanged(const Storage* a, const Storage* b, ctChainTree* scene) {
  const Tree* tree = ctSceneTree(scene);
  const Sequence* s = &scene->sequence;
  int changed = 0;
  for (int level = 0; level < tree->levelCount; level++) {
    for (int i = 0; i < tree->levelSize[level]; i++) {
      changed += nodeChanged(a, b, tree, level, tree->levelBegin[level] + i);
    }
  }
  for (int i = 0; i < s->productBegin[s->returnFrameCount]; i++) {
    changed += differ(&a->product[i], &b->product[i], sizeof(Frame));
  }
  return changed;
}

static bool testShape(Shape shape, int power) {
  const int count = 1 << power;
  ctChainTree* scene = makeScene(shape, count);
  if (scene == NULL) {
    return false;
  }
  /* Two paths through the tree, and one through the products of the path that the interval ends. */
  const int levels = ctSceneTree(scene)->levelCount;
  const int bound = 2 * levels + power + 1;
  int most = 0;
  bool good = levels <= power / 4 + 2;
  Storage before = copyStorage(scene);
  for (int i = 0; i < 12 && good; i++) {
    const int link = 3 + (int)((double)(count - 6) * i / 11);
    if (!isTorsion(shape, link, count) || !carries(shape, link)) {
      continue;
    }
    const ctChange change = {.link = link, .angle = 0.7};
    ctCounts counts = {0};
    good = ctPropose(scene, 1, &change) == ctSuccess && ctAccept(scene, &counts) == ctSuccess;
    Storage after = copyStorage(scene);
    const int changed = countChanged(&before, &after, scene);
    freeStorage(&before);
    before = after;
    good = good && changed > 0 && changed <= counts.nodesUpdated && counts.nodesUpdated <= bound;
    most = counts.nodesUpdated > most ? (int)counts.nodesUpdated : most;
    if (!good) {
      printf("link %d: %d nodes changed, %d counted, at most %d expected\n", link, changed, (int)counts.nodesUpdated,
             bound);
    }
  }
  freeStorage(&before);
  printf("%s of 2^%d links, %d levels: at most %d nodes an accepted trial\n", shapeNames[shape], power, levels, most);
  ctDestroy(scene);
  return good;
}

int main(int argc, char** argv) {
  const int largest = argc > 1 ? atoi(argv[1]) : 20;
  bool good = true;
  for (int power = 10; power <= largest; power++) {
    for (int shape = CHAIN; shape <= COMB; shape++) {
      good = testShape((Shape)shape, power) && good;
    }
  }
  return good ? 0 : 1;
}
