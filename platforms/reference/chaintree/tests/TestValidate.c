/* ctValidate notices all that is not as the state gives it: its answer is worth something. Looks inside the engine. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "../src/descent.h"
#include "../src/scene.h"
#include "lattice.h"

static ctChainTree* makeTested(const char* method) {
  setenv("CHAINTREE_TRIALS", method, 1);
  ctChainTree* tree = makeLattice(ONE_CHAIN, 0.3, 0);
  unsetenv("CHAINTREE_TRIALS");
  for (int link = 2; link < SITES; link += 50) {
    const ctChange change = {.link = link, .angle = 0.01};
    bool clash;
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    CHECK_SUCCESS(ctAccept(tree, NULL));
  }
  CHECK(ctValidate(tree));
  return tree;
}

static void checkNoticed(ctChainTree* tree, const char* what, void* place, const void* wrong, size_t size) {
  unsigned char right[sizeof(Frame)];
  memcpy(right, place, size);
  CHECK(memcmp(right, wrong, size) != 0);
  memcpy(place, wrong, size);
  if (ctValidate(tree)) {
    reportFailure("a wrong %s is not noticed\n", what);
  }
  memcpy(place, right, size);
  CHECK(ctValidate(tree));
}

static void testContent(void) {
  ctChainTree* scene = makeTested("tree");
  Tree* tree = &scene->ownTree;
  Sequence* s = &scene->sequence;
  double centroid[3];
  CHECK_SUCCESS(ctGetCentroid(scene, 300, centroid));
  const Frame frame = {{{0.5}}};
  const Bound bound = {0.1f, 0.2f, 0.3f, 100, 100};
  const double x = 17;
  const float f = 17;
  const int node = treeRoot(tree);
  checkNoticed(scene, "shortcut of a leaf", &tree->shortcut[3], &frame, sizeof frame);
  checkNoticed(scene, "shortcut of a node", &tree->shortcut[node], &frame, sizeof frame);
  checkNoticed(scene, "pose", &tree->pose[20], &frame, sizeof frame);
  checkNoticed(scene, "bound", &tree->bound[node], &bound, sizeof bound);
  checkNoticed(scene, "place of a particle", &tree->leaf[7].y[5], &x, sizeof x);
  checkNoticed(scene, "place of a member", &treeMembers(tree, node)->block.z[1], &f, sizeof f);
  checkNoticed(scene, "sum", &tree->sum[4][1], &x, sizeof x);
  CHECK(ctTreeBoundsHold(tree, s));
  tree->bound[5].r *= 0.99f;
  CHECK(!ctTreeBoundsHold(tree, s));
  tree->bound[5].r /= 0.99f;
  tree->bound[node].centres *= 0.5f;
  CHECK(!ctTreeBoundsHold(tree, s));
  ctDestroy(scene);

  ctChainTree* branched = makeLattice(LAYERS, 0.1, 0);
  CHECK(ctValidate(branched) && branched->sequence.returnFrameCount == SIDE - 1);
  checkNoticed(branched, "product", &branched->sequence.product[2], &frame, sizeof frame);
  checkNoticed(branched, "closure", &branched->sequence.returnFrame[2], &frame, sizeof frame);
  ctDestroy(branched);

  ctChainTree* hairy = makeLattice(ROWS_ON_A_WALL, 0.1, 0);
  CHECK(ctValidate(hairy) && hairy->sequence.openPathCount == SIDE * SIDE);
  checkNoticed(hairy, "stem", &hairy->ownTree.stem[2], &frame, sizeof frame);
  ctDestroy(hairy);
}

static void testBoxes(void) {
  ctChainTree* scene = makeTested("boxes");
  /* ctValidate has forgotten all boxes. */
  const ctChange change = {.link = 300, .angle = 0.02};
  bool clash;
  CHECK_SUCCESS(ctPropose(scene, 1, &change));
  CHECK_SUCCESS(ctTestTrial(scene, &clash, NULL, NULL));
  int made = 0;
  while (made < scene->ownTree.levelSize[0] &&
         scene->traversal.box[made].builtFrom < scene->ownTree.contentRevision[made]) {
    made++;
  }
  CHECK(made < scene->ownTree.levelSize[0]);
  scene->traversal.box[made].half *= 0.5f;
  CHECK(!ctValidate(scene));
  ctDestroy(scene);
}

static void testClearances(void) {
  ctChainTree* scene = makeTested("clearances");
  Clearance* c = &scene->clearance;
  CHECK(c->isKept);
  const uint16_t wrong = MOST_CLEARANCE;
  checkNoticed(scene, "clearance of neighbours", &c->least[0 * c->stride + 1], &wrong, sizeof wrong);
  ctDestroy(scene);
}

int main(void) {
  testContent();
  testBoxes();
  testClearances();
  return checkResult();
}
