/* Pairs of leaves in periodic boxes, against the boxes around all leaves in all images in double.
 *
 * Usage: TestLeafImages [trials of each box] [seed]. */
#define _POSIX_C_SOURCE 200112L /* setenv */

enum { CHAINS = 20 };

#include "periodic.h"

enum { MOST_LEAVES = 40, REACH = 9 };

/* Listed pairs, and of these the pairs with an image. */
typedef struct Tally {
  long pairs, withImage;
} Tally;

/* Gaps so close (nm) to the cutoff may be on either side of it, and a box may be larger than its particles by that. */
#define ALLOWANCE 1e-3

typedef struct LeafBox {
  bool isEmpty;
  double low[3];
  double high[3];
} LeafBox;

static int particles[MOST_LEAVES * CT_LEAF_WIDTH];

static void boxLeaf(const ctLeafPositions* leaf, const int* own, LeafBox* box) {
  const double* axes[3] = {leaf->x, leaf->y, leaf->z};
  box->isEmpty = true;
  for (int d = 0; d < 3; d++) {
    box->low[d] = INFINITY;
    box->high[d] = -INFINITY;
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      if (own[k] != CT_NULL) {
        box->isEmpty = false;
        box->low[d] = fmin(box->low[d], axes[d][k]);
        box->high[d] = fmax(box->high[d], axes[d][k]);
      }
    }
  }
}

static double gapAlong(const LeafBox* a, const LeafBox* b, int d, double shift) {
  return fmax(fmax(b->low[d] - a->high[d] - shift, a->low[d] + shift - b->high[d]), 0);
}

static double gapOf(const LeafBox* a, const LeafBox* b, const double shift[3]) {
  double squared = 0;
  for (int d = 0; d < 3; d++) {
    squared += gapAlong(a, b, d, shift[d]) * gapAlong(a, b, d, shift[d]);
  }
  return sqrt(squared);
}

/* The slots of a leaf in the open trial, or in the state. */
typedef struct Bodies {
  int pieceCount; /* 0: the state */
  const ctPiece* pieces;
  const ctTransform* motions;
} Bodies;

static int bodyOf(const Bodies* bodies, int slot) {
  int piece = bodies->pieceCount - 1;
  while (bodies->pieces[piece].slotBegin > slot) {
    piece--;
  }
  return bodies->pieces[piece].body;
}

static bool turns(const Bodies* bodies, int body) {
  const double* r = bodies->motions[body].rotation;
  return r[0] != 1 || r[4] != 1 || r[8] != 1;
}

/* Whether some particles of two leaves move relative to each other. */
static bool changes(const Bodies* bodies, int a, int b, bool isImage) {
  for (int k = 0; bodies->pieceCount > 0 && k < CT_LEAF_WIDTH * CT_LEAF_WIDTH; k++) {
    const int slotA = a * CT_LEAF_WIDTH + k / CT_LEAF_WIDTH;
    const int slotB = b * CT_LEAF_WIDTH + k % CT_LEAF_WIDTH;
    if (particles[slotA] != CT_NULL && particles[slotB] != CT_NULL) {
      const int body = bodyOf(bodies, slotA);
      if (body != bodyOf(bodies, slotB) || (isImage && turns(bodies, body))) {
        return true;
      }
    }
  }
  return bodies->pieceCount == 0;
}

static bool isListed(size_t count, const ctLeafPair* pairs, int a, int b, const int n[3], double gap) {
  int times = 0;
  for (size_t i = 0; i < count; i++) {
    const ctLeafPair* pair = &pairs[i];
    if (pair->a == a && pair->b == b && pair->image[0] == n[0] && pair->image[1] == n[1] && pair->image[2] == n[2]) {
      times++;
      const double listed = sqrt((double)pair->squaredGap);
      CHECK(listed <= gap + 1e-6 && listed > gap - ALLOWANCE);
    }
  }
  CHECK(times <= 1);
  return times > 0;
}

/* Two leaves before and in a trial, and the list that has to have them if they are near. */
typedef struct LeafPairCheck {
  int a;
  int b;
  const LeafBox* before[2];
  const LeafBox* after[2];
  bool changes[2]; /* without an image, with one */
  double cutoff;
  size_t count;
  const ctLeafPair* pairs;
} LeafPairCheck;

static bool isFarAlong(const LeafPairCheck* c, int d, double shift) {
  return fmin(gapAlong(c->before[0], c->before[1], d, shift), gapAlong(c->after[0], c->after[1], d, shift)) >
         c->cutoff + ALLOWANCE;
}

static void checkImage(const LeafPairCheck* c, const int n[3], const double shift[3], Tally* tally) {
  const bool isImage = n[0] != 0 || n[1] != 0 || n[2] != 0;
  const bool isFirst = n[2] != 0 ? n[2] > 0 : n[1] != 0 ? n[1] > 0 : n[0] > 0;
  const double gap = fmin(gapOf(c->before[0], c->before[1], shift), gapOf(c->after[0], c->after[1], shift));
  if (gap > c->cutoff + ALLOWANCE || !c->changes[isImage] || (c->a == c->b && isImage && !isFirst)) {
    return;
  }
  const bool found = isListed(c->count, c->pairs, c->a, c->b, n, gap);
  CHECK(found || gap > c->cutoff);
  tally->pairs += found;
  tally->withImage += found && isImage;
}

/* Later vectors do not reach into the dimensions of earlier ones. */
static void checkImages(const LeafPairCheck* c, const double (*box)[3], Tally* tally) {
  int n[3];
  for (n[2] = -REACH; n[2] <= REACH; n[2]++) {
    const double z = n[2] * box[2][2];
    for (n[1] = -REACH; n[1] <= REACH && !isFarAlong(c, 2, z); n[1]++) {
      const double y = n[2] * box[2][1] + n[1] * box[1][1];
      for (n[0] = -REACH; n[0] <= REACH && !isFarAlong(c, 1, y); n[0]++) {
        const double shift[3] = {n[2] * box[2][0] + n[1] * box[1][0] + n[0] * box[0][0], y, z};
        checkImage(c, n, shift, tally);
      }
    }
  }
}

/* Each pair of leaves and image is listed once if it is near and changes, and no other. */
static void checkList(const double (*box)[3], double cutoff, const Bodies* bodies, int leafCount, const LeafBox* before,
                      const LeafBox* after, size_t count, const ctLeafPair* pairs, Tally* tally) {
  const long formerPairs = tally->pairs;
  for (int a = 0; a < leafCount; a++) {
    for (int b = a; b < leafCount; b++) {
      if (!before[a].isEmpty && !before[b].isEmpty) {
        const LeafPairCheck check = {.a = a,
                                     .b = b,
                                     .before = {&before[a], &before[b]},
                                     .after = {&after[a], &after[b]},
                                     .changes = {changes(bodies, a, b, false), changes(bodies, a, b, true)},
                                     .cutoff = cutoff,
                                     .count = count,
                                     .pairs = pairs};
        checkImages(&check, box, tally);
      }
    }
  }
  CHECK(tally->pairs - formerPairs == (long)count);
}

static void testBox(const double (*box)[3], int trialCount, Tally* ofStates, Tally* ofTrials) {
  static Scene scene;
  static LeafBox before[MOST_LEAVES];
  static LeafBox after[MOST_LEAVES];
  ctChainTree* tree = makeScene(&scene, box, 0.1);
  const int leafCount = ctGetLeafCount(tree);
  const double width = fmin(fmin(box[0][0], box[1][1]), box[2][2]);
  CHECK(leafCount <= MOST_LEAVES);
  ctGetLeafParticles(tree, particles);
  for (int t = 0; t < trialCount; t++) {
    const double cutoff = t % 4 == 0 ? width / 2 : drawnBetween(0.05, 0.3) * width;
    ctChange changes[2] = {{0}};
    const int changeCount = 1 + (drawn() < 0.3);
    for (int c = 0; c < changeCount; c++) {
      changes[c].link = t % 8 == 3 ? LINKS - 1 - c : ((int)(drawn() * (LINKS / 2)) * 2 + c) % LINKS;
      const bool isFree = scene.joints[changes[c].link] == ctFreeJoint;
      const bool isTurn = !isFree || drawn() < 0.7;
      for (int d = 0; d < 3; d++) {
        changes[c].rotation[d] = isTurn ? drawnBetween(-2, 2) : 0;
        changes[c].translation[d] = drawnBetween(-1, 1);
        changes[c].pivot[d] = drawnBetween(0, 3);
      }
    }
    size_t count;
    const ctLeafPair* pairs;
    const ctLeafPositions* positions;
    Bodies bodies = {0};
    const ctLeafPositions* leaves = ctGetLeaves(tree);
    for (int a = 0; a < leafCount; a++) {
      boxLeaf(&leaves[a], particles + CT_LEAF_WIDTH * a, &before[a]);
    }
    if (t % 10 == 0) {
      CHECK_SUCCESS(ctGetLeafPairs(tree, cutoff, &count, &pairs, NULL));
      checkList(box, cutoff, &bodies, leafCount, before, before, count, pairs, ofStates);
    }
    ctDisplacement displacements[MOST_DISPLACED];
    const int displaced = areFlexible && t % 2 == 1 ? drawDisplacements(box, 0, displacements) : 0;
    CHECK_SUCCESS(displaced > 0 ? ctProposeDisplacements(tree, displaced, displacements)
                                : ctPropose(tree, changeCount, changes));
    CHECK_SUCCESS(ctGetChangedLeafPairs(tree, cutoff, &count, &pairs, &positions, NULL));
    bodies.pieceCount = ctGetTrialPieces(tree, &bodies.pieces, &bodies.motions);
    leaves = ctGetLeaves(tree);
    for (int a = 0; a < leafCount; a++) {
      ctLeafPositions moved;
      for (int k = 0; k < CT_LEAF_WIDTH; k++) {
        const ctTransform* m = &bodies.motions[bodyOf(&bodies, a * CT_LEAF_WIDTH + k)];
        const double x[3] = {leaves[a].x[k], leaves[a].y[k], leaves[a].z[k]};
        double* const to[3] = {&moved.x[k], &moved.y[k], &moved.z[k]};
        for (int d = 0; d < 3; d++) {
          const double* r = m->rotation + 3 * (size_t)d;
          *to[d] = r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + m->translation[d];
        }
      }
      boxLeaf(&moved, particles + CT_LEAF_WIDTH * a, &after[a]);
    }
    checkList(box, cutoff, &bodies, leafCount, before, after, count, pairs, ofTrials);
    for (size_t i = 0; i < count; i++) {
      for (int k = 0; k < 2; k++) { /* positions of listed leaves are those of the trial */
        LeafBox listed;
        const int leaf = k == 0 ? pairs[i].a : pairs[i].b;
        boxLeaf(&positions[leaf], particles + (size_t)CT_LEAF_WIDTH * (size_t)leaf, &listed);
        for (int d = 0; d < 3; d++) {
          CHECK_NEAR(listed.low[d], after[leaf].low[d], 1e-12);
          CHECK_NEAR(listed.high[d], after[leaf].high[d], 1e-12);
        }
      }
    }
    if (drawn() < 0.7) {
      CHECK_SUCCESS(ctAccept(tree, NULL));
    }
  }
  ctDestroy(tree);
}

/* A rigid rod that is many boxes long: more images than are searched one by one from the root. */
static void testRod(void) {
  enum { COUNT = 600, LEAVES = COUNT / CT_LEAF_WIDTH + 1, SLOTS = LEAVES * CT_LEAF_WIDTH };
  static double positions[3 * COUNT];
  static double radii[COUNT];
  static int links[COUNT];
  const int parent = CT_NULL;
  const uint8_t joint = ctFreeJoint;
  const double box[3][3] = {{3, 0, 0}, {0, 3, 0}, {0, 0, 3}};
  for (int i = 0; i < COUNT; i++) {
    radii[i] = 0.1;
    for (int d = 0; d < 3; d++) {
      positions[3 * i + d] = 0.2 * i * (d == 0 ? 1 : 0.37 * d);
    }
  }
  const ctDefinition definition = {.particleCount = COUNT,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = 1,
                                   .linkParents = &parent,
                                   .linkJoints = &joint,
                                   .box = box};
  ctChainTree* tree = checkedCreate(&definition);
  const ctChange turn = {.link = 0, .rotation = {0.3, 0.2, -0.5}};
  const ctChange shift = {.link = 0, .translation = {1, 2, 3}};
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* trial;
  CHECK_SUCCESS(ctPropose(tree, 1, &shift));
  CHECK_SUCCESS(ctGetChangedLeafPairs(tree, 0.7, &count, &pairs, &trial, NULL));
  CHECK(count == 0);
  CHECK_SUCCESS(ctPropose(tree, 1, &turn));
  CHECK_SUCCESS(ctGetChangedLeafPairs(tree, 0.7, &count, &pairs, &trial, NULL));
  static double x[2][3 * SLOTS]; /* before the trial and in it */
  const ctLeafPositions* leaves = ctGetLeaves(tree);
  const ctPiece* pieces;
  const ctTransform* motions;
  const int pieceCount = ctGetTrialPieces(tree, &pieces, &motions);
  const ctTransform* motion = &motions[pieces[pieceCount - 1].body];
  int own[LEAVES * CT_LEAF_WIDTH];
  CHECK(ctGetLeafCount(tree) == LEAVES);
  ctGetLeafParticles(tree, own);
  for (int i = 0; i < SLOTS; i++) {
    const ctLeafPositions* leaf = &leaves[i / CT_LEAF_WIDTH];
    const int k = i % CT_LEAF_WIDTH;
    const double from[3] = {leaf->x[k], leaf->y[k], leaf->z[k]};
    for (int d = 0; d < 3; d++) {
      const double* r = motion->rotation + 3 * (size_t)d;
      x[0][3 * i + d] = from[d];
      x[1][3 * i + d] = r[0] * from[0] + r[1] * from[1] + r[2] * from[2] + motion->translation[d];
    }
  }
  int near = 0;
  for (int i = 0; i < SLOTS; i++) {
    for (int j = 0; j <= i; j++) {
      bool isNear = false;
      if (own[i] == CT_NULL || own[j] == CT_NULL) {
        continue;
      }
      int n[3] = {0, 0, 0};
      for (int k = 0; k < 2 && !isNear; k++) {
        nearestImage(x[k], j, i, box, n);
        isNear = (n[0] != 0 || n[1] != 0 || n[2] != 0) && imageDistance(x[k], j, i, box, n) < 0.7L;
      }
      if (!isNear) {
        continue;
      }
      near++;
      int times = 0;
      const int a = j / CT_LEAF_WIDTH;
      const int b = i / CT_LEAF_WIDTH;
      for (size_t p = 0; p < count; p++) {
        bool isSame = pairs[p].a == a && pairs[p].b == b;
        bool isOpposite = isSame && a == b;
        for (int d = 0; d < 3; d++) {
          isSame = isSame && pairs[p].image[d] == n[d];
          isOpposite = isOpposite && pairs[p].image[d] == -n[d];
        }
        times += isSame || isOpposite;
      }
      CHECK(times == 1);
    }
  }
  CHECK(near > 10);
  ctDestroy(tree);
}

static void testRefusals(void) {
  static Scene scene;
  ctChainTree* tree = makeScene(&scene, boxes[0], 0.1);
  const ctChange turn = {.link = 1, .rotation = {1, 0, 0}};
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* positions;
  double box[3][3];
  CHECK(ctGetBox(tree, box) && memcmp(box, boxes[0], sizeof box) == 0);
  CHECK_SUCCESS(ctPropose(tree, 1, &turn));
  CHECK_SUCCESS(ctGetLeafPairs(tree, 2.5, &count, &pairs, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "half the periodic box's width, 2.5 nm",
                ctGetLeafPairs(tree, 2.501, &count, &pairs, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "must be finite",
                ctGetChangedLeafPairs(tree, INFINITY, &count, &pairs, &positions, NULL));
  CHECK_SUCCESS(ctSetBox(tree, NULL));
  CHECK(!ctGetBox(tree, box));
  CHECK_SUCCESS(ctGetLeafPairs(tree, INFINITY, &count, &pairs, NULL));
  for (size_t i = 0; i < count; i++) {
    CHECK(pairs[i].image[0] == 0 && pairs[i].image[1] == 0 && pairs[i].image[2] == 0);
  }
  ctDestroy(tree);
}

int main(int argumentCount, char** arguments) {
  const int trialCount = argumentCount > 1 ? atoi(arguments[1]) : 40;
  Tally ofStates = {0, 0};
  Tally ofTrials = {0, 0};
  testRefusals();
  testRod();
  state = argumentCount > 2 ? (uint32_t)strtoul(arguments[2], NULL, 10) : 1;
  for (int box = 0; box < 2 * BOXES; box++) {
    const long before[2] = {ofStates.withImage, ofTrials.withImage};
    areFlexible = box >= BOXES;
    testBox(boxes[box % BOXES], trialCount, &ofStates, &ofTrials);
    CHECK(ofStates.withImage > before[0] && ofTrials.withImage > before[1]);
  }
  printf("%ld pairs in states, %ld with images; %ld in %d trials, %ld with images\n", ofStates.pairs,
         ofStates.withImage, ofTrials.pairs, 2 * BOXES * trialCount, ofTrials.withImage);
  return checkResult();
}
