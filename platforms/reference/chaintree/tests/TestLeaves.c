/* Leaves of scenes whose pieces and pairs are known by hand: which pairs a trial changes, their order, and errors.
 * Random scenes are in TestRandomLeaves. */
#include "arm.h"

enum { LINKS = 30, LEAVES = 4 };

typedef struct Listed {
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* positions;
} Listed;

static Listed changedPairs(ctChainTree* tree, double cutoff) {
  Listed listed = {0};
  CHECK_SUCCESS(ctGetChangedLeafPairs(tree, cutoff, &listed.count, &listed.pairs, &listed.positions, NULL));
  return listed;
}

/* Checks that these pairs are listed, in any order. */
static void checkPairs(Listed listed, size_t count, const int (*pairs)[2]) {
  CHECK(listed.count == count);
  for (size_t i = 0; i < count; i++) {
    int times = 0;
    for (size_t k = 0; k < listed.count; k++) {
      times += listed.pairs[k].a == pairs[i][0] && listed.pairs[k].b == pairs[i][1];
    }
    CHECK(times == 1);
  }
}

/* An arm of two particles a link has eight links a leaf. Its root comes first, and all links in a row. */
static void testArm(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  int particles[LEAVES * CT_LEAF_WIDTH];
  CHECK(ctGetLeafCount(arm) == LEAVES);
  ctGetLeafParticles(arm, particles);
  for (int slot = 0; slot < LEAVES * CT_LEAF_WIDTH; slot++) {
    CHECK(slot < 2 * LINKS ? particles[slot] / 2 == slot / 2 : particles[slot] == CT_NULL);
  }
  const ctPiece* pieces;
  const ctTransform* motions;
  const int* links;
  CHECK(ctGetTrialPieces(arm, &pieces, &motions) == 0 && pieces == NULL && motions == NULL);
  CHECK(ctGetTrialLinks(arm, &links) == 0 && links == NULL);

  /* The last turn comes to lie around the first. */
  const ctChange changes[] = {{.link = 25, .angle = 2}, {.link = 14, .angle = 1}};
  CHECK_SUCCESS(ctPropose(arm, 2, changes));
  CHECK(ctGetTrialPieces(arm, &pieces, &motions) == 3);
  CHECK(pieces[0].slotBegin == 0 && pieces[1].slotBegin == 28 && pieces[2].slotBegin == 50);
  CHECK(pieces[0].body == 0 && pieces[1].body == 1 && pieces[2].body == 2);
  CHECK(motions[0].rotation[0] == 1 && motions[0].translation[0] == 0);
  CHECK_NEAR(motions[1].rotation[0], cos(1), 1e-12);
  CHECK_NEAR(motions[2].rotation[0], cos(3), 1e-12);
  CHECK(ctGetTrialLinks(arm, &links) == 2 && links[0] == 14 && links[1] == 25);
  /* Leaf 0 is static, leaf 2 of body 1; leaves 1 and 3 are of two bodies. */
  const int both[][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 1}, {1, 2}, {1, 3}, {2, 3}, {3, 3}};
  checkPairs(changedPairs(arm, INFINITY), 8, both);

  CHECK_SUCCESS(ctPropose(arm, 1, &changes[1]));
  CHECK(ctGetTrialPieces(arm, &pieces, &motions) == 2 && pieces[1].slotBegin == 28);
  CHECK(ctGetTrialLinks(arm, &links) == 1 && links[0] == 14);
  const int one[][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 1}, {1, 2}, {1, 3}};
  checkPairs(changedPairs(arm, INFINITY), 6, one);
  /* In this arm leaves with another between them are 6 nm apart, or more. */
  const int near[][2] = {{0, 1}, {1, 1}, {1, 2}};
  checkPairs(changedPairs(arm, 1.01), 3, near);
  ctDestroy(arm);
}

/* The gap that counts is the least before the trial and in it. */
static void testGaps(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  const double pi = 3.14159265358979323846;
  const ctChange fold = {.link = 8, .angle = pi}; /* slot 16: the hands of leaf 1 come back over those of leaf 0 */
  for (int back = 0; back < 2; back++) {
    CHECK_SUCCESS(ctPropose(arm, 1, &fold));
    const Listed listed = changedPairs(arm, 0.5);
    /* Before, leaf 2 is 8 nm from leaf 0. In the trial it begins where the arm does. */
    const int pairs[][2] = {{0, 1}, {0, 2}};
    checkPairs(listed, 2, pairs);
    for (size_t i = 0; i < listed.count; i++) {
      CHECK_NEAR((double)listed.pairs[i].squaredGap, 0, 1e-9);
    }
    CHECK_SUCCESS(ctAccept(arm, NULL));
  }
  ctDestroy(arm);
}

/* The number of the state grows with each change, and with nothing else. */
static void testVersions(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  double positions[6 * LINKS];
  double* state = calloc(ctGetStateSize(arm), sizeof(double));
  const ctChange turn = {.link = 10, .angle = 0.5};
  int64_t later;
  int64_t first = ctGetChangeCount(arm);
  ctGetPositions(arm, positions);
  CHECK_SUCCESS(ctPropose(arm, 1, &turn));
  CHECK_SUCCESS(ctGetTrialPositions(arm, positions));
  later = ctGetChangeCount(arm);
  CHECK(later == first);
  ctReject(arm);
  later = ctGetChangeCount(arm);
  CHECK(later == first);
  turnArm(arm, 10, 0.5);
  later = ctGetChangeCount(arm);
  CHECK(later > first);
  first = later;
  CHECK_SUCCESS(ctSetPositions(arm, positions));
  later = ctGetChangeCount(arm);
  CHECK(later > first);
  first = later;
  ctGetState(arm, state);
  CHECK_SUCCESS(ctSetState(arm, state));
  later = ctGetChangeCount(arm);
  CHECK(later > first);
  CHECK(ctValidate(arm));
  free(state);
  ctDestroy(arm);
}

static void testRefusals(void) {
  ctChainTree* arm = makeArm(LINKS, ctFixedJoint, 0.1);
  const ctChange turn = {.link = 10, .angle = 0.5};
  const double none[] = {0, -1, NAN, -INFINITY};
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* positions;
  CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctGetChangedLeafPairs(arm, 1, &count, &pairs, &positions, NULL));
  CHECK_SUCCESS(ctPropose(arm, 1, &turn));
  for (int i = 0; i < 4; i++) {
    CHECK_FAILURE(arm, ctInvalidArgument, "cutoff",
                  ctGetChangedLeafPairs(arm, none[i], &count, &pairs, &positions, NULL));
    CHECK_FAILURE(arm, ctInvalidArgument, "cutoff", ctGetLeafPairs(arm, none[i], &count, &pairs, NULL));
  }
  CHECK(ctHasTrial(arm));
  ctCounts counts = {0};
  CHECK_SUCCESS(ctGetChangedLeafPairs(arm, 1, &count, &pairs, &positions, &counts));
  CHECK(counts.volumeTests > 0);
  CHECK_SUCCESS(ctAccept(arm, NULL));
  CHECK_FAILURE(arm, ctNoTrial, "no open trial", ctGetChangedLeafPairs(arm, 1, &count, &pairs, &positions, NULL));
  ctDestroy(arm);
}

/* A scene without particles; one leaf alone; and trials that move nothing, or all as one body. */
static void testEdges(void) {
  const ctDefinition nothing = {0};
  ctChainTree* empty = checkedCreate(&nothing);
  size_t count;
  const ctLeafPair* pairs;
  CHECK(ctGetLeafCount(empty) == 1 && ctGetLeaves(empty) != NULL);
  CHECK_SUCCESS(ctPropose(empty, 0, NULL));
  CHECK(changedPairs(empty, INFINITY).count == 0);
  CHECK_SUCCESS(ctGetLeafPairs(empty, INFINITY, &count, &pairs, NULL));
  CHECK(count == 0);
  ctDestroy(empty);

  ctChainTree* arm = makeArm(3, ctFreeJoint, 0.1);
  const ctChange turn = {.link = 2, .angle = 0.5};
  const ctChange shift = {.link = 0, .translation = {1, 2, 3}};
  const int self[][2] = {{0, 0}};
  CHECK_SUCCESS(ctPropose(arm, 0, NULL));
  CHECK(changedPairs(arm, INFINITY).count == 0);
  CHECK_SUCCESS(ctPropose(arm, 1, &shift));
  CHECK(changedPairs(arm, INFINITY).count == 0);
  CHECK_SUCCESS(ctPropose(arm, 1, &turn));
  const Listed listed = changedPairs(arm, 0.001);
  checkPairs(listed, 1, self);
  CHECK(listed.pairs[0].squaredGap == 0);
  int particles[CT_LEAF_WIDTH];
  ctGetLeafParticles(arm, particles);
  for (int slot = 0; slot < CT_LEAF_WIDTH; slot++) {
    const double x = listed.positions[0].x[slot];
    CHECK(particles[slot] != CT_NULL || x == 0);
    CHECK(particles[slot] != armHand(2) || fabs(x - (1 + cos(0.5))) <= 1e-12);
  }
  CHECK_SUCCESS(ctGetLeafPairs(arm, 0.001, &count, &pairs, NULL));
  CHECK(count == 1 && pairs[0].a == 0 && pairs[0].b == 0);
  ctDestroy(arm);
}

int main(void) {
  testArm();
  testGaps();
  testVersions();
  testRefusals();
  testEdges();
  return checkResult();
}
