/* Tests of few slots use boxes around leaves once no leaf has moved for a while. Two scenes, of which one has boxes as
 * soon as it can and the other never, give the same results. Looks inside the engine. */
#include "../src/scene.h"
#include "lattice.h"
#include "signedshorts.h"

enum { TRIALS = 4000, NEVER_BOXED = 1 << 20 };

static uint32_t state = 1;

/* From -1 to 1. */
static double drawn(void) {
  state = state * 1664525u + 1013904223u;
  return (state >> 8) * 0x1p-23 - 1;
}

/* True if the end of a box is a number of units less one to three of room, or the end of the range. */
static bool isEnd(int end, double units) {
  const double room = lesser(larger(units, INT16_MIN), INT16_MAX) - end;
  return room < 3.1 && (room > 0.9 || end == INT16_MIN);
}

/* True if the boxes of all leaves, unless they are not in use, hold their particles, with one to three units of room.
 */
static bool boxesHold(const ctChainTree* tree) {
  const Traversal* t = &tree->traversal;
  const Sequence* s = &tree->sequence;
  for (int leaf = tree->ownTree.levelSize[0]; leaf < boxedNodes(&tree->ownTree) * TREE_WIDTH; leaf++) {
    CHECK(t->leafBoxes[leaf / TREE_WIDTH].ends[0][leaf % TREE_WIDTH] == INT16_MAX); /* there is no such leaf */
  }
  for (int leaf = 0; leaf < tree->ownTree.levelSize[0] && t->testsToBoxes == 0; leaf++) {
    const Frame frame = ctTreeFrame(&tree->ownTree, 0, leaf);
    const ShortBoxes* boxes = &t->leafBoxes[leaf / TREE_WIDTH];
    const int k = leaf % TREE_WIDTH;
    for (int d = 0; d < 3; d++) {
      double low = INFINITY;
      double high = -INFINITY;
      for (int slot = leaf * TREE_WIDTH; slot < (leaf + 1) * TREE_WIDTH && slot < s->slotCount; slot++) {
        if (slotIsModelled(s, slot)) {
          double x[3];
          treeLocal(&tree->ownTree, slot, x);
          transformPoint(&frame, x, x);
          const double r = slotRadius(s, slot);
          low = lesser(low, x[d] - r);
          high = larger(high, x[d] + r);
        }
      }
      if (!isEnd(boxes->ends[3 + d][k], low * t->boxScale) || !isEnd(boxes->ends[d][k], -high * t->boxScale)) {
        return false;
      }
    }
  }
  return true;
}

static bool addChanged(void* context, int particle1, int particle2, double before, double after) {
  *(double*)context += (particle1 + 2 * particle2) * (before - 0.5 * after);
  return true;
}

static bool addOverlapping(void* context, int particle, double overlap) {
  (void)overlap;
  *(double*)context += particle * particle;
  return true;
}

/* Asks both scenes of a change, which moves few slots or more, and makes it the state of both if it is free. Returns
 * whether it clashes. */
static bool ask(ctChainTree* trees[2], const ctChange* change, bool isFew, bool alsoPairs, ctCounts counts[2]) {
  bool clash[2];
  int pairs[2][2] = {{0}};
  double changed[2] = {0};
  double overlapping[2] = {0};
  const double middle[3] = {3.3, 2.8, 4.1};
  for (int i = 0; i < 2; i++) {
    CHECK_SUCCESS(ctPropose(trees[i], 1, change));
    CHECK_SUCCESS(ctTestTrial(trees[i], &clash[i], pairs[i], &counts[i]));
    if (alsoPairs) {
      CHECK_SUCCESS(ctForEachChangedPair(trees[i], 1.2, addChanged, &changed[i], NULL));
      CHECK_SUCCESS(ctForEachClashWith(trees[i], middle, 1.5, addOverlapping, &overlapping[i], NULL));
    }
  }
  CHECK(clash[0] == clash[1] && pairs[0][0] == pairs[1][0] && pairs[0][1] == pairs[1][1]);
  CHECK(changed[0] == changed[1] && overlapping[0] == overlapping[1]);
  CHECK(!isFew || boxesHold(trees[0]));
  for (int i = 0; i < 2; i++) {
    if (clash[0]) {
      ctReject(trees[i]);
    } else {
      CHECK_SUCCESS(ctAccept(trees[i], NULL));
    }
  }
  return clash[0];
}

static void makeBoth(ctChainTree* trees[2], LatticeLinks kind, double radius) {
  for (int i = 0; i < 2; i++) {
    trees[i] = makeLattice(kind, radius, 0);
    trees[i]->traversal.testsPerLeaf = i == 0 ? 0 : NEVER_BOXED;
  }
}

static void endBoth(ctChainTree* trees[2], int clashing) {
  CHECK(clashing > TRIALS / 20 && clashing < TRIALS - TRIALS / 20);
  CHECK(trees[1]->traversal.testsToBoxes > 0);
  CHECK(ctValidate(trees[0]) && ctValidate(trees[1]));
  ctDestroy(trees[0]);
  ctDestroy(trees[1]);
}

/* Particles move about in a lattice, each alone: no leaf moves, but for a while many change between two tests. */
static void testParticles(int mostBoxedNodes, int mostFirstNodes, int mostUnaskedNodes) {
  static double first[3 * SITES];
  ctChainTree* trees[2];
  ctCounts counts[2] = {{0}};
  int clashing = 0;
  int boxed = 0;
  makeBoth(trees, ONE_EACH, 0.32);
  ctGetPositions(trees[0], first);
  for (int i = 0; i < 2; i++) {
    trees[i]->traversal.mostBoxedNodes = mostBoxedNodes;
    trees[i]->traversal.mostFirstNodes = mostFirstNodes;
    trees[i]->traversal.mostUnaskedNodes = mostUnaskedNodes;
  }
  for (int trial = 0; trial < TRIALS; trial++) {
    const ctChange change = {.link = (int)(0.5 * (drawn() + 1) * SITES), .translation = {drawn(), drawn(), drawn()}};
    clashing += ask(trees, &change, true, trial % 97 == 0, counts);
    boxed += trees[0]->traversal.testsToBoxes == 0;
    for (int many = 0; trial % 250 == 0 && many < 40; many++) {
      const ctChange untested = {.link = many * 7, .translation = {0.01, 0.01 * drawn(), 0}};
      for (int i = 0; i < 2; i++) {
        CHECK_SUCCESS(ctPropose(trees[i], 1, &untested));
        CHECK_SUCCESS(ctAccept(trees[i], NULL));
      }
    }
    for (int i = 0; trial % 1000 == 999 && i < 2; i++) {
      CHECK_SUCCESS(ctSetPositions(trees[i], first));
    }
  }
  CHECK(boxed > TRIALS / 2);
  CHECK(counts[0].particleTests == counts[1].particleTests);
  CHECK(counts[0].volumeTests < counts[1].volumeTests);
  endBoth(trees, clashing);
}

/* The end of a chain turns, often enough for boxes, until a joint before it does. */
static void testChain(void) {
  ctChainTree* trees[2];
  ctCounts counts[2] = {{0}};
  int clashing = 0;
  int boxed = 0;
  makeBoth(trees, ONE_CHAIN, 0.45);
  for (int trial = 0; trial < TRIALS; trial++) {
    const bool isTip = trial % 8 != 0;
    const ctChange change = {.link = isTip ? SITES - 2 - trial % 20 : SITES / 8 + trial * 37 % (SITES / 2),
                             .angle = (isTip ? 3 : 0.01) * drawn()};
    clashing += ask(trees, &change, isTip, false, counts);
    boxed += trees[0]->traversal.testsToBoxes == 0;
  }
  CHECK(boxed > TRIALS / 20);
  endBoth(trees, clashing);
}

/* The ends of chains turn, and whole chains move, each a few leaves within the sequence: these leaves get new boxes,
 * and leaves behind them keep theirs. They have shifted by rounding: positions in double are those of the state. */
static void testEndsOfChains(void) {
  ctChainTree* trees[2];
  ctCounts counts[2] = {{0}};
  int clashing = 0;
  makeBoth(trees, LAYERED_CHAINS, 0.45);
  const Tree* tree = &trees[0]->ownTree;
  for (int trial = 0; trial < TRIALS; trial++) {
    const int chain = trial * 7 % SIDE;
    const bool isWhole = trial % 5 == 0;
    const int link = isWhole ? chain * SIDE * SIDE : (chain + 1) * SIDE * SIDE - 2 - trial % 20;
    ctChange change = {.link = link, .angle = 3 * drawn()};
    if (isWhole) {
      change = (ctChange){.link = link, .translation = {0.05 * drawn(), 0.05 * drawn(), 0}};
    }
    clashing += ask(trees, &change, !isWhole, false, counts);
    CHECK(trial < 3 || trees[0]->traversal.testsToBoxes == 0);
    const int slot = (int)(0.5 * (drawn() + 1) * SITES);
    const Frame frame = ctTreeFrame(tree, 0, slot / TREE_WIDTH);
    double expected[3];
    double found[3];
    treeLocal(tree, slot, expected);
    transformPoint(&frame, expected, expected);
    ctPositionInView(&trees[0]->traversal, slot, 0, found);
    CHECK(found[0] == expected[0] && found[1] == expected[1] && found[2] == expected[2]);
  }
  endBoth(trees, clashing);
}

/* No boxes are made where leaves may lose their world coordinates, nor too early. */
static void testWhen(void) {
  ctChainTree* trees[2];
  ctCounts counts[2] = {{0}};
  makeBoth(trees, ONE_EACH, 0.32);
  trees[0]->traversal.testsPerLeaf = 2;
  const ctChange still = {.link = 5};
  for (int trial = 0; trial < 2 * trees[0]->ownTree.levelSize[0] + 1; trial++) {
    ask(trees, &still, true, false, counts);
    CHECK(trees[0]->traversal.testsToBoxes > 0);
  }
  ask(trees, &still, true, false, counts);
  CHECK(trees[0]->traversal.testsToBoxes == 0);
  ctDestroy(trees[0]);
  ctDestroy(trees[1]);
  makeBoth(trees, ONE_EACH, 0.32);
  trees[0]->world.leafEntryCount = 4;
  for (int trial = 0; trial < 100; trial++) {
    const ctChange change = {.link = 7 * trial, .translation = {drawn(), drawn(), drawn()}};
    ask(trees, &change, true, false, counts);
    CHECK(trees[0]->traversal.testsToBoxes > 0);
  }
  ctDestroy(trees[0]);
  ctDestroy(trees[1]);
}

/* Particles that move far beyond the range of the boxes' units still meet others there. */
static void testFarAway(void) {
  ctChainTree* trees[2];
  ctCounts counts[2] = {{0}};
  makeBoth(trees, ONE_EACH, 0.32);
  /* Boxes are made in a trial that goes far away itself: the range is that of the state. */
  const ctChange away = {.link = 5, .translation = {1e6, 0, 0}};
  for (int trial = 0; trial < 2; trial++) {
    bool clash;
    for (int i = 0; i < 2; i++) {
      CHECK_SUCCESS(ctPropose(trees[i], 1, &away));
      CHECK_SUCCESS(ctTestTrial(trees[i], &clash, NULL, &counts[i]));
      ctReject(trees[i]);
    }
  }
  CHECK(trees[0]->traversal.testsToBoxes == 0 && trees[0]->traversal.boxScale > 1000);
  double positions[3 * SITES];
  ctGetPositions(trees[0], positions);
  for (int axis = 0; axis < 6; axis++) {
    double far[3] = {0, 0, 0};
    far[axis % 3] = axis < 3 ? 1e3 : -1e3;
    for (int i = 0; i < 3; i++) {
      const int link = 7 + 11 * axis + i;
      ctChange change = {.link = link};
      for (int d = 0; d < 3; d++) {
        change.translation[d] = (i == 1 ? 2 : 1) * far[d] - positions[3 * link + d];
      }
      CHECK(ask(trees, &change, false, false, counts) == (i == 2)); /* far, twice as far, where the first is */
      CHECK(trees[0]->traversal.testsToBoxes == 0);
    }
  }
  ctDestroy(trees[0]);
  ctDestroy(trees[1]);
}

/* In a scene of more than eight nodes over leaves, a particle meets each that it goes to. */
static void testManyNodes(void) {
  enum { ROW = 46, COUNT = ROW * ROW };
  static double positions[COUNT][3];
  static double radii[COUNT];
  static int links[COUNT];
  static int parents[COUNT];
  static uint8_t joints[COUNT];
  for (int i = 0; i < COUNT; i++) {
    const int row = i / ROW;
    positions[i][0] = i % ROW;
    positions[i][1] = row;
    radii[i] = 0.3;
    links[i] = i;
    parents[i] = CT_NULL;
    joints[i] = ctFreeJoint;
  }
  const ctDefinition definition = {.particleCount = COUNT,
                                   .positions = positions[0],
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = COUNT,
                                   .linkParents = parents,
                                   .linkJoints = joints};
  ctChainTree* tree;
  CHECK_SUCCESS(ctCreate(&definition, &tree, NULL, 0));
  tree->traversal.testsPerLeaf = 0;
  for (int target = 1; target < COUNT; target++) {
    const int row = target / ROW;
    for (int away = 0; away < 2; away++) {
      const ctChange change = {.link = 0, .translation = {target % ROW + 0.1, row, 0.7 * away}};
      bool clash;
      int pair[2] = {0, 0};
      CHECK_SUCCESS(ctPropose(tree, 1, &change));
      CHECK_SUCCESS(ctTestTrial(tree, &clash, pair, NULL));
      CHECK(clash == (away == 0));
      CHECK(away == 1 || pair[0] + pair[1] == target);
    }
  }
  CHECK(tree->traversal.testsToBoxes == 0 && tree->ownTree.levelSize[1] > 8);
  ctDestroy(tree);
}

/* As shorts, numbers are rounded towards 0 and shifted; numbers beyond the range become its ends. */
static void testShorts(void) {
  const float numbers[8] = {2.9f, -2.9f, 32766.5f, 1e30f, -1e30f, INFINITY, -INFINITY, 0};
  const int16_t expected[8] = {2, -2, 32766, INT16_MAX, INT16_MIN, INT16_MAX, INT16_MIN, 0};
  const int16_t opposite[8] = {0, 8, INT16_MIN + 3, INT16_MIN + 3, INT16_MAX, INT16_MIN + 3, INT16_MAX, 4};
  int16_t shorts[8];
  storeSignedShorts8(shorts, numbers, 1, 0, 0);
  CHECK(memcmp(shorts, expected, sizeof shorts) == 0);
  storeSignedShorts8(shorts, numbers, -1.5f, 1, 3);
  CHECK(memcmp(shorts, opposite, sizeof shorts) == 0);
  int16_t rows[6][16];
  for (int trial = 0; trial < 2000; trial++) {
    int16_t limits[6];
    unsigned below = 0xffff;
    for (int i = 0; i < 6; i++) {
      limits[i] = (int16_t)(32767 * drawn());
      for (int k = 0; k < 16; k++) {
        rows[i][k] = trial % 3 == 0 ? (int16_t)(limits[i] - (k < 12)) : (int16_t)(32767 * drawn() - 20000);
        below &= ~((unsigned)(rows[i][k] >= limits[i]) << k);
      }
    }
    CHECK(belowSixLimits(rows, sixLimits(limits)) == below);
  }
}

int main(void) {
  testShorts();
  testManyNodes();
  testFarAway();
  testParticles(MOST_BOXED_NODES, MOST_FIRST_NODES, MOST_UNASKED_NODES);
  testParticles(MOST_BOXED_NODES, MOST_FIRST_NODES, 1); /* in two steps where there are no boxes */
  testParticles(0, 1, MOST_UNASKED_NODES);              /* from the root: boxes of one node at a time */
  testChain();
  testEndsOfChains();
  testWhen();
  return checkResult();
}
