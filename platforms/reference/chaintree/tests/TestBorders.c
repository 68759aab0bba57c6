/* Each argument of each public call at each forbidden value, and at the ends of the allowed range:
 * the status is the one that chaintree.h says, and the scene answers as it did before. */
#include "borders.h"
#include "check.h"

enum {
  LINKS = 8,
  WIDTH = 3,
  PARTICLES = LINKS * WIDTH,
  COORDINATES = 3 * PARTICLES,
  MOST_PAIRS = PARTICLES * PARTICLES
};

/* What has no place: links and particles below 0 and beyond the last; numbers that are no lengths. */
static const int wrongIndices[] = {INT_MIN, -2, -1, PARTICLES, PARTICLES + 1, INT_MAX - 1, INT_MAX};
static const double noLengths[] = {NAN, INFINITY, -INFINITY, 1.1 * CT_MOST_LENGTH, -1.1 * CT_MOST_LENGTH, 1e300};
static const double smallAndLarge[] = {5e-324, 1e-310, 1e-40, 1e-20, 1e15, 1e19, 1e30, 1e200, 1.7e308};

/* ---- The scene ---- */

static double positions[COORDINATES];
static double radii[PARTICLES];
static uint8_t roles[PARTICLES];
static uint8_t listed[PARTICLES];
static int particleLinks[PARTICLES];
/* A fixed link, a chain that hangs on it, with a side chain and a ball joint; a free chain, and a free link on it. */
static const int parents[LINKS] = {CT_NULL, 0, 1, 2, 1, CT_NULL, 5, 5};
static const uint8_t joints[LINKS] = {ctFixedJoint,   ctTorsionJoint, ctTorsionJoint, ctBallJoint,
                                      ctTorsionJoint, ctFreeJoint,    ctTorsionJoint, ctFreeJoint};
static int torsions[LINKS][4];
static const int exclusions[][2] = {{0, 1}, {4, 3}, {0, 1}};

static ctDefinition describe(void) {
  for (int i = 0; i < PARTICLES; i++) {
    positions[3 * i] = 0.1 * i;
    positions[3 * i + 1] = 0.1 * (i * i % 3);
    positions[3 * i + 2] = 0.1 * (i * i % 5);
    radii[i] = i % 7 == 6 ? 0 : 0.1;
    roles[i] = (uint8_t)(i % 4);
    listed[i] = i % 14 == 6;
    particleLinks[i] = i / WIDTH;
  }
  for (int link = 0; link < LINKS; link++) {
    const int before = parents[link] == CT_NULL ? 0 : WIDTH * parents[link];
    const int torsion[4] = {before + 1, before + 2, WIDTH * link, WIDTH * link + 1};
    memcpy(torsions[link], torsion, sizeof torsion);
  }
  return (ctDefinition){.particleCount = PARTICLES,
                        .positions = positions,
                        .radii = radii,
                        .hydrogenBondRoles = roles,
                        .particleLinks = particleLinks,
                        .listed = listed,
                        .linkCount = LINKS,
                        .linkParents = parents,
                        .linkJoints = joints,
                        .linkTorsions = (const int(*)[4])torsions,
                        .exclusionCount = 3,
                        .exclusions = exclusions,
                        .overlapTolerance = 0.01,
                        .hydrogenBondAllowance = 0.02};
}

/* ---- What a scene answers ---- */

typedef struct Answers {
  double state[COORDINATES + 7 * LINKS];
  double positions[COORDINATES];
  double trial[COORDINATES];
  double forces[COORDINATES];
  double energy;
  double angle;
  double limits[MOST_PAIRS];
  int pairs[2][MOST_PAIRS];
  size_t pairCount;
  size_t leafPairCount;
  int limitCount;
  int pieceCount;
  int64_t counts[3];
  bool clashes[2];
  bool hasTrial;
} Answers;

static void ask(ctChainTree* tree, Answers* a) {
  int limited[MOST_PAIRS][2];
  const ctLeafPair* leafPairs;
  const ctPiece* pieces;
  const ctTransform* motions;
  memset(a, 0, sizeof *a);
  a->hasTrial = ctHasTrial(tree);
  a->counts[0] = ctGetTrialCount(tree);
  a->counts[1] = ctGetChangeCount(tree);
  a->counts[2] = ctGetAcceptedCount(tree);
  ctGetState(tree, a->state);
  ctGetPositions(tree, a->positions);
  CHECK_SUCCESS(ctHasClash(tree, &a->clashes[0], NULL, NULL));
  CHECK_SUCCESS(ctComputeEnergy(tree, 1, &a->energy, a->forces, NULL));
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 2, &a->angle));
  CHECK_SUCCESS(ctGetNeighborPairs(tree, 0.5, true, MOST_PAIRS, a->pairs[0], a->pairs[1], NULL, &a->pairCount, NULL));
  CHECK_SUCCESS(ctGetLeafPairs(tree, 1, &a->leafPairCount, &leafPairs, NULL));
  a->limitCount = ctGetLimitCount(tree);
  ctGetLimits(tree, MOST_PAIRS, limited, a->limits);
  a->pieceCount = ctGetTrialPieces(tree, &pieces, &motions);
  if (a->hasTrial) {
    CHECK_SUCCESS(ctGetTrialPositions(tree, a->trial));
    CHECK_SUCCESS(ctTestTrial(tree, &a->clashes[1], NULL, NULL));
  }
}

typedef struct Border {
  ctChainTree* tree;
  ctChainTree* other; /* of another scene */
  ctSelection* selections[2];
  ctSelection* stranger;
  Answers before;
} Border;

static void checkUnchanged(int line, Border* b) {
  static Answers now;
  ask(b->tree, &now);
  callCount++;
  if (memcmp(&now, &b->before, sizeof now) != 0 || !ctValidate(b->tree)) {
    reportFailure("line %d: the scene answers otherwise than before\n", line);
  }
}

/* A call that must fail, with a text that names the culprit. */
#define REFUSED(expected, culprit, call)               \
  do {                                                 \
    CHECK_FAILURE(b->tree, (expected), culprit, call); \
    checkUnchanged(__LINE__, b);                       \
  } while (0)

#define INVALID(culprit, call) REFUSED(ctInvalidArgument, culprit, call)

/* A call without a scene, which has no text. */
#define NO_SCENE(call)                  \
  do {                                  \
    CHECK((call) == ctInvalidArgument); \
    checkUnchanged(__LINE__, b);        \
  } while (0)

/* A call that is no mistake, or one that has nothing to do. */
#define HARMLESS(call)           \
  do {                           \
    call;                        \
    checkUnchanged(__LINE__, b); \
  } while (0)

/* ---- Callbacks ---- */

static bool refusePair(void* context, int particle1, int particle2, double value) {
  (void)context;
  (void)value;
  reportFailure("particles %d and %d were told of\n", particle1, particle2);
  return true;
}

static bool refuseChange(void* context, int particle1, int particle2, double before, double after) {
  (void)after;
  return refusePair(context, particle1, particle2, before);
}

static bool refuseParticle(void* context, int particle, double overlap) {
  return refusePair(context, particle, particle, overlap);
}

static bool countChange(void* context, int particle1, int particle2, double before, double after) {
  (void)particle1;
  (void)particle2;
  (void)before;
  (void)after;
  ++*(int*)context;
  return true;
}

static bool countParticle(void* context, int particle, double overlap) {
  (void)particle;
  (void)overlap;
  ++*(int*)context;
  return true;
}

/* ---- State ---- */

static void testPositions(Border* b) {
  double x[COORDINATES];
  INVALID("NULL", ctSetPositions(b->tree, NULL));
  NO_SCENE(ctSetPositions(NULL, positions));
  for (EACH(i, noLengths)) {
    for (int k = 0; k < COORDINATES; k++) {
      memcpy(x, positions, sizeof x);
      x[k] = noLengths[i];
      INVALID("position", ctSetPositions(b->tree, x));
    }
  }
  HARMLESS(ctGetPositions(b->tree, NULL));
  HARMLESS(ctGetPositions(NULL, x));
  HARMLESS(ctFollowPositions(b->tree, false, NULL));
  HARMLESS(ctFollowPositions(NULL, true, x));
  NO_SCENE(ctGetTrialPositions(NULL, x));
  NO_SCENE(ctFollowTrialPositions(NULL, true, x));
  const ctStatus expected = ctHasTrial(b->tree) ? ctInvalidArgument : ctNoTrial;
  const char* culprit = ctHasTrial(b->tree) ? "NULL" : "no open trial";
  REFUSED(expected, culprit, ctGetTrialPositions(b->tree, NULL));
  REFUSED(expected, culprit, ctFollowTrialPositions(b->tree, true, NULL));
}

static void testPositionsOf(Border* b) {
  double x[COORDINATES];
  const int first[] = {0, 1};
  for (int inTrial = 0; inTrial < 2; inTrial++) {
    NO_SCENE(ctGetPositionsOf(NULL, inTrial == 1, 2, first, x));
    INVALID("without a list", ctGetPositionsOf(b->tree, inTrial == 1, 2, NULL, x));
    INVALID("NULL", ctGetPositionsOf(b->tree, inTrial == 1, 2, first, NULL));
    for (EACH(i, wrongCounts)) {
      INVALID("cannot be", ctGetPositionsOf(b->tree, inTrial == 1, wrongCounts[i], first, x));
    }
    for (EACH(i, wrongIndices)) {
      const int particles[] = {0, wrongIndices[i]};
      INVALID("no particle", ctGetPositionsOf(b->tree, inTrial == 1, 2, particles, x));
    }
  }
  HARMLESS(CHECK_SUCCESS(ctGetPositionsOf(b->tree, false, 0, NULL, NULL)));
}

static void testState(Border* b) {
  double state[COORDINATES + 7 * LINKS];
  const size_t size = ctGetStateSize(b->tree);
  CHECK(size == COORDINATES + 4 * 1 + 4 + 2 * 7);
  CHECK(ctGetStateSize(NULL) == 0);
  INVALID("NULL", ctSetState(b->tree, NULL));
  NO_SCENE(ctSetState(NULL, b->before.state));
  HARMLESS(ctGetState(b->tree, NULL));
  HARMLESS(ctGetState(NULL, state));
  for (size_t k = 0; k < size; k++) {
    for (EACH(i, noLengths)) {
      memcpy(state, b->before.state, sizeof state);
      state[k] = noLengths[i];
      const bool isPlacement = (k >= size - 11 && k < size - 8) || k >= size - 3; /* up to ten times as far */
      if (!isPlacement || !(fabs(noLengths[i]) < 10 * CT_MOST_LENGTH)) {
        INVALID(k < COORDINATES ? "position" : "no state", ctSetState(b->tree, state));
      }
    }
  }
  HARMLESS(ctRenew(NULL));
  HARMLESS(ctRenew(b->tree));
}

static void testLinks(Border* b) {
  double numbers[3];
  ctTransform transform;
  for (EACH(i, wrongIndices)) {
    INVALID("no link", ctGetTorsionAngle(b->tree, wrongIndices[i], numbers));
    INVALID("no link", ctGetCentroid(b->tree, wrongIndices[i], numbers));
    INVALID("no link", ctGetRelativeTransform(b->tree, wrongIndices[i], 0, &transform));
    INVALID("no link", ctGetRelativeTransform(b->tree, 0, wrongIndices[i], &transform));
  }
  for (int link = 0; link < LINKS; link++) {
    if (joints[link] != ctTorsionJoint) {
      INVALID("no torsion joint", ctGetTorsionAngle(b->tree, link, numbers));
    }
  }
  INVALID("fixed", ctGetCentroid(b->tree, 0, numbers));
  INVALID("NULL", ctGetTorsionAngle(b->tree, 1, NULL));
  INVALID("NULL", ctGetCentroid(b->tree, 1, NULL));
  INVALID("NULL", ctGetRelativeTransform(b->tree, 1, 0, NULL));
  double orientations[LINKS][9];
  HARMLESS(ctGetOrientations(b->tree, NULL));
  HARMLESS(ctGetOrientations(NULL, orientations));
  NO_SCENE(ctGetTorsionAngle(NULL, 1, numbers));
  NO_SCENE(ctGetCentroid(NULL, 1, numbers));
  NO_SCENE(ctGetRelativeTransform(NULL, 1, 0, &transform));
}

/* ---- Limits ---- */

static void testLimits(Border* b) {
  int pairs[2][2] = {{1, 9}, {2, 8}};
  double limits[2] = {0.1, 0.2};
  NO_SCENE(ctSetLimits(NULL, 2, (const int(*)[2])pairs, limits));
  INVALID("pairs is NULL", ctSetLimits(b->tree, 2, NULL, limits));
  INVALID("limits is NULL", ctSetLimits(b->tree, 2, (const int(*)[2])pairs, NULL));
  for (EACH(i, wrongCounts)) {
    INVALID("limits", ctSetLimits(b->tree, wrongCounts[i], (const int(*)[2])pairs, limits));
  }
  for (EACH(i, wrongIndices)) {
    for (int k = 0; k < 4; k++) {
      const int right = pairs[k / 2][k % 2];
      pairs[k / 2][k % 2] = wrongIndices[i];
      INVALID("limit ", ctSetLimits(b->tree, 2, (const int(*)[2])pairs, limits));
      pairs[k / 2][k % 2] = right;
    }
  }
  limits[1] = NAN;
  INVALID("limit 1", ctSetLimits(b->tree, 2, (const int(*)[2])pairs, limits));
  pairs[1][0] = pairs[1][1];
  limits[1] = 0.2;
  INVALID("limit 1", ctSetLimits(b->tree, 2, (const int(*)[2])pairs, limits));
  INVALID("NULL", ctRaiseLimits(b->tree, NULL, NULL));
  int raised;
  NO_SCENE(ctRaiseLimits(NULL, &raised, NULL));
  CHECK(ctGetLimitCount(NULL) == 0);
  HARMLESS(ctGetLimits(NULL, 2, pairs, limits));
  HARMLESS(ctGetLimits(b->tree, INT_MIN, pairs, limits));
  HARMLESS(ctGetLimits(b->tree, INT_MAX, NULL, limits));
  HARMLESS(ctGetLimits(b->tree, INT_MAX, pairs, NULL));
}

/* ---- Trials ---- */

static void testProposals(Border* b) {
  ctChange changes[LINKS + 1] = {{.link = 1, .angle = 0.1}, {.link = 5, .translation = {0.1}}};
  NO_SCENE(ctPropose(NULL, 1, changes));
  INVALID("NULL", ctPropose(b->tree, 1, NULL));
  for (EACH(i, wrongCounts)) {
    INVALID("changes", ctPropose(b->tree, wrongCounts[i], changes));
  }
  INVALID("changes", ctPropose(b->tree, LINKS + 1, changes));
  for (EACH(i, wrongIndices)) {
    changes[1].link = wrongIndices[i];
    INVALID("no link", ctPropose(b->tree, 2, changes));
  }
  changes[1].link = 0;
  INVALID("fixed", ctPropose(b->tree, 2, changes));
  changes[1].link = 1;
  INVALID("link 1 is changed twice", ctPropose(b->tree, 2, changes));
  for (int link = 1; link < LINKS; link++) {
    for (EACH(i, noLengths)) {
      for (int k = 0; k < 10; k++) {
        ctChange change = {.link = link};
        double* numbers[] = {change.rotation, change.pivot, change.translation};
        *(k == 9 ? &change.angle : &numbers[k / 3][k % 3]) = noLengths[i];
        const bool isRead = joints[link] == ctTorsionJoint ? k == 9 && !isfinite(noLengths[i])
                            : joints[link] == ctBallJoint  ? k < 3
                                                           : k < 9;
        if (isRead) {
          INVALID(" given for link ", ctPropose(b->tree, 1, &change));
        }
      }
    }
  }
  ctChange far[2] = {{.link = 5, .pivot = {CT_MOST_LENGTH, CT_MOST_LENGTH, CT_MOST_LENGTH}, .rotation = {3, 0, 0}},
                     {.link = 7, .translation = {CT_MOST_LENGTH, 0, 0}}};
  far[0].translation[1] = CT_MOST_LENGTH;
  if (ctPropose(b->other, 2, far) == ctSuccess) {
    CHECK_SUCCESS(ctAccept(b->other, NULL));
    CHECK(ctValidate(b->other));
  }
}

static void testWithoutTrial(Border* b) {
  bool clash;
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* leaves;
  double x[COORDINATES];
  int particle = 0;
  const char* none = "no open trial";
  REFUSED(ctNoTrial, none, ctTestTrial(b->tree, &clash, NULL, NULL));
  REFUSED(ctNoTrial, none, ctForEachChangedPair(b->tree, 1, refuseChange, NULL, NULL));
  REFUSED(ctNoTrial, none, ctAccept(b->tree, NULL));
  REFUSED(ctNoTrial, none, ctGetTrialPositions(b->tree, x));
  REFUSED(ctNoTrial, none, ctFollowTrialPositions(b->tree, true, x));
  REFUSED(ctNoTrial, none, ctGetPositionsOf(b->tree, true, 1, &particle, x));
  REFUSED(ctNoTrial, none, ctGetChangedLeafPairs(b->tree, 1, &count, &pairs, &leaves, NULL));
  HARMLESS(ctReject(b->tree));
}

static void testTrials(Border* b) {
  bool clash;
  NO_SCENE(ctTestTrial(NULL, &clash, NULL, NULL));
  NO_SCENE(ctAccept(NULL, NULL));
  NO_SCENE(ctForEachChangedPair(NULL, 1, refuseChange, NULL, NULL));
  HARMLESS(ctReject(NULL));
  CHECK(!ctHasTrial(NULL) && ctGetTrialCount(NULL) == 0 && ctGetChangeCount(NULL) == 0);
  CHECK(ctGetAcceptedCount(NULL) == 0 && ctGetTotalShift(NULL) == 0);
  INVALID("clash is NULL", ctTestTrial(b->tree, NULL, NULL, NULL));
  INVALID("function is NULL", ctForEachChangedPair(b->tree, 1, NULL, NULL, NULL));
  if (!ctHasTrial(b->tree)) {
    testWithoutTrial(b);
    return;
  }
  INVALID("cutoff", ctForEachChangedPair(b->tree, INFINITY, refuseChange, NULL, NULL));
  for (EACH(i, notPositive)) {
    INVALID("cutoff", ctForEachChangedPair(b->tree, notPositive[i], refuseChange, NULL, NULL));
  }
  int all = 0;
  CHECK_SUCCESS(ctForEachChangedPair(b->tree, 1e3, countChange, &all, NULL));
  for (EACH(i, smallAndLarge)) {
    int count = 0;
    HARMLESS(CHECK_SUCCESS(ctForEachChangedPair(b->tree, smallAndLarge[i], countChange, &count, NULL)));
    CHECK(count == (smallAndLarge[i] < 1 ? 0 : all));
  }
}

/* ---- Leaves ---- */

static void testLeaves(Border* b) {
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* leaves;
  const ctPiece* pieces;
  const ctTransform* motions;
  const int* links;
  int particles[4 * PARTICLES];
  CHECK(ctGetLeafCount(NULL) == 0 && ctGetLeaves(NULL) == NULL);
  HARMLESS(ctGetLeafParticles(NULL, particles));
  HARMLESS(ctGetLeafParticles(b->tree, NULL));
  CHECK(ctGetTrialPieces(NULL, &pieces, &motions) == 0 && ctGetTrialLinks(NULL, &links) == 0);
  CHECK(ctGetTrialPieces(b->tree, NULL, &motions) == 0 && ctGetTrialPieces(b->tree, &pieces, NULL) == 0);
  CHECK(ctGetTrialLinks(b->tree, NULL) == 0);
  for (EACH(i, wrongIndices)) {
    double shift[3] = {1, 1, 1};
    HARMLESS(ctGetMoleculeShift(b->tree, wrongIndices[i], false, shift));
    CHECK(shift[0] == 0 && shift[1] == 0 && shift[2] == 0);
  }
  HARMLESS(ctGetMoleculeShift(b->tree, 0, false, NULL));
  NO_SCENE(ctGetLeafPairs(NULL, 1, &count, &pairs, NULL));
  NO_SCENE(ctGetChangedLeafPairs(NULL, 1, &count, &pairs, &leaves, NULL));
  INVALID("count is NULL", ctGetLeafPairs(b->tree, 1, NULL, &pairs, NULL));
  INVALID("pairs is NULL", ctGetLeafPairs(b->tree, 1, &count, NULL, NULL));
  INVALID("count is NULL", ctGetChangedLeafPairs(b->tree, 1, NULL, &pairs, &leaves, NULL));
  INVALID("pairs is NULL", ctGetChangedLeafPairs(b->tree, 1, &count, NULL, &leaves, NULL));
  INVALID("positions is NULL", ctGetChangedLeafPairs(b->tree, 1, &count, &pairs, NULL, NULL));
  for (EACH(i, notPositive)) {
    INVALID("cutoff", ctGetLeafPairs(b->tree, notPositive[i], &count, &pairs, NULL));
    if (ctHasTrial(b->tree)) {
      INVALID("cutoff", ctGetChangedLeafPairs(b->tree, notPositive[i], &count, &pairs, &leaves, NULL));
    }
  }
  const int leafCount = ctGetLeafCount(b->tree);
  const size_t all = (size_t)leafCount * ((size_t)leafCount + 1) / 2;
  for (EACH(i, smallAndLarge)) {
    HARMLESS(CHECK_SUCCESS(ctGetLeafPairs(b->tree, smallAndLarge[i], &count, &pairs, NULL)));
    CHECK(smallAndLarge[i] < 1 ? count >= (size_t)leafCount && count <= all : count == all);
  }
}

/* ---- Selections ---- */

static void testSelections(Border* b) {
  ctSelection* made = b->stranger; /* anything but NULL */
  const int two[] = {0, 1};
  NO_SCENE(ctSelect(NULL, 2, two, &made));
  CHECK(made == NULL);
  INVALID("NULL", ctSelect(b->tree, 2, two, NULL));
  INVALID("without a list", ctSelect(b->tree, 2, NULL, &made));
  for (EACH(i, wrongCounts)) {
    INVALID("cannot be", ctSelect(b->tree, wrongCounts[i], two, &made));
  }
  for (EACH(i, wrongIndices)) {
    const int particles[] = {3, wrongIndices[i]};
    INVALID("no particle", ctSelect(b->tree, 2, particles, &made));
  }
  HARMLESS(ctFreeSelection(NULL));
  HARMLESS(CHECK_SUCCESS(ctSelect(b->tree, 0, NULL, &made)));
  double distance = -1;
  int pair[2];
  INVALID("no pair", ctGetMinimumDistance(b->tree, made, b->selections[0], &distance, pair, NULL));
  INVALID("no pair", ctGetMinimumDistance(b->tree, b->selections[0], made, &distance, pair, NULL));
  ctFreeSelection(made);
  ctSelection** s = b->selections;
  NO_SCENE(ctGetMinimumDistance(NULL, s[0], s[1], &distance, pair, NULL));
  INVALID("selection1 is NULL", ctGetMinimumDistance(b->tree, NULL, s[1], &distance, pair, NULL));
  INVALID("selection2 is NULL", ctGetMinimumDistance(b->tree, s[0], NULL, &distance, pair, NULL));
  INVALID("distance is NULL", ctGetMinimumDistance(b->tree, s[0], s[1], NULL, pair, NULL));
  INVALID("pair is NULL", ctGetMinimumDistance(b->tree, s[0], s[1], &distance, NULL, NULL));
  INVALID("another scene", ctGetMinimumDistance(b->tree, b->stranger, s[1], &distance, pair, NULL));
  INVALID("another scene", ctGetMinimumDistance(b->tree, s[0], b->stranger, &distance, pair, NULL));
  CHECK(distance == -1);
}

/* ---- Queries ---- */

static void testQueries(Border* b) {
  bool clash;
  double energy = -1;
  size_t count = 7;
  int ids[2][MOST_PAIRS];
  NO_SCENE(ctHasClash(NULL, &clash, NULL, NULL));
  NO_SCENE(ctForEachClash(NULL, refusePair, NULL, NULL));
  NO_SCENE(ctForEachNeighborPair(NULL, 1, refusePair, NULL, NULL));
  NO_SCENE(ctGetNeighborPairs(NULL, 1, true, 1, ids[0], ids[1], NULL, &count, NULL));
  NO_SCENE(ctComputeEnergy(NULL, 1, &energy, NULL, NULL));
  INVALID("clash is NULL", ctHasClash(b->tree, NULL, NULL, NULL));
  INVALID("function is NULL", ctForEachClash(b->tree, NULL, NULL, NULL));
  INVALID("function is NULL", ctForEachNeighborPair(b->tree, 1, NULL, NULL, NULL));
  INVALID("particles1 is NULL", ctGetNeighborPairs(b->tree, 1, true, 1, NULL, ids[1], NULL, &count, NULL));
  INVALID("particles2 is NULL", ctGetNeighborPairs(b->tree, 1, true, 1, ids[0], NULL, NULL, &count, NULL));
  INVALID("count is NULL", ctGetNeighborPairs(b->tree, 1, true, 1, ids[0], ids[1], NULL, NULL, NULL));
  INVALID("energy is NULL", ctComputeEnergy(b->tree, 1, NULL, NULL, NULL));
  for (EACH(i, notFinite)) {
    INVALID("constant", ctComputeEnergy(b->tree, notFinite[i], &energy, NULL, NULL));
    INVALID("cutoff", ctForEachNeighborPair(b->tree, notFinite[i], refusePair, NULL, NULL));
    INVALID("cutoff", ctGetNeighborPairs(b->tree, notFinite[i], true, 1, ids[0], ids[1], NULL, &count, NULL));
  }
  for (EACH(i, notPositive)) {
    INVALID("cutoff", ctForEachNeighborPair(b->tree, notPositive[i], refusePair, NULL, NULL));
    INVALID("cutoff", ctGetNeighborPairs(b->tree, notPositive[i], true, 1, ids[0], ids[1], NULL, &count, NULL));
  }
  CHECK(count == 7 && energy == -1);
  size_t all;
  double distances[MOST_PAIRS];
  CHECK_SUCCESS(ctGetNeighborPairs(b->tree, 1e3, false, 0, NULL, NULL, NULL, &all, NULL));
  for (EACH(i, smallAndLarge)) {
    const double cutoff = smallAndLarge[i];
    const size_t expected = cutoff < 1 ? 0 : all;
    PairCount pairs = {0};
    HARMLESS(CHECK_SUCCESS(ctForEachNeighborPair(b->tree, cutoff, countPair, &pairs, NULL)));
    CHECK((size_t)pairs.count == expected);
    HARMLESS(
        CHECK_SUCCESS(ctGetNeighborPairs(b->tree, cutoff, true, MOST_PAIRS, ids[0], ids[1], distances, &count, NULL)));
    CHECK(count == expected);
    HARMLESS(CHECK_SUCCESS(ctGetNeighborPairs(b->tree, cutoff, true, 0, NULL, NULL, NULL, &count, NULL)));
    CHECK(count == expected);
    HARMLESS(CHECK_SUCCESS(ctComputeEnergy(b->tree, cutoff, &energy, NULL, NULL)));
    HARMLESS(CHECK_SUCCESS(ctComputeEnergy(b->tree, -cutoff, &energy, NULL, NULL)));
  }
}

static void testProbes(Border* b) {
  const double middle[3] = {1, 0.1, 0.1};
  NO_SCENE(ctForEachClashWith(NULL, middle, 1, refuseParticle, NULL, NULL));
  INVALID("position is NULL", ctForEachClashWith(b->tree, NULL, 1, refuseParticle, NULL, NULL));
  INVALID("function is NULL", ctForEachClashWith(b->tree, middle, 1, NULL, NULL, NULL));
  for (EACH(i, noLengths)) {
    INVALID("radius", ctForEachClashWith(b->tree, middle, noLengths[i], refuseParticle, NULL, NULL));
    for (int k = 0; k < 3; k++) {
      double x[3] = {0};
      x[k] = noLengths[i];
      INVALID("probe", ctForEachClashWith(b->tree, x, 1, refuseParticle, NULL, NULL));
    }
  }
  INVALID("radius", ctForEachClashWith(b->tree, middle, -5e-324, refuseParticle, NULL, NULL));
  int modelled = 0;
  for (int i = 0; i < PARTICLES; i++) {
    modelled += radii[i] > 0;
  }
  int count = 0;
  HARMLESS(CHECK_SUCCESS(ctForEachClashWith(b->tree, middle, CT_MOST_LENGTH, countParticle, &count, NULL)));
  CHECK(count == modelled);
  const double corner[3] = {CT_MOST_LENGTH, -CT_MOST_LENGTH, CT_MOST_LENGTH};
  HARMLESS(CHECK_SUCCESS(ctForEachClashWith(b->tree, corner, 5e-324, refuseParticle, NULL, NULL)));
}

/* Counts that begin anywhere end at the largest number at most. */
static void testCounts(Border* b) {
  const ctCounts full = {INT64_MAX, INT64_MAX - 1, INT64_MAX};
  const double middle[3] = {1, 0.1, 0.1};
  ctCounts counts = full;
  bool clash;
  size_t count;
  double distance;
  int pair[2];
  const ctLeafPair* pairs;
  HARMLESS(CHECK_SUCCESS(ctHasClash(b->tree, &clash, NULL, &counts)));
  int number = 0;
  HARMLESS(CHECK_SUCCESS(ctForEachClashWith(b->tree, middle, 1, countParticle, &number, &counts)));
  HARMLESS(CHECK_SUCCESS(ctGetNeighborPairs(b->tree, 1, false, 0, NULL, NULL, NULL, &count, &counts)));
  HARMLESS(CHECK_SUCCESS(ctGetLeafPairs(b->tree, 1, &count, &pairs, &counts)));
  HARMLESS(CHECK_SUCCESS(ctGetMinimumDistance(b->tree, b->selections[0], b->selections[1], &distance, pair, &counts)));
  if (ctHasTrial(b->tree)) {
    HARMLESS(CHECK_SUCCESS(ctTestTrial(b->tree, &clash, NULL, &counts)));
    HARMLESS(CHECK_SUCCESS(ctForEachChangedPair(b->tree, 1, countChange, &number, &counts)));
  }
  CHECK(counts.volumeTests == INT64_MAX && counts.particleTests == INT64_MAX);
  counts = full;
  CHECK_SUCCESS(ctPropose(b->other, 1, &(ctChange){.link = 1, .angle = 0.1}));
  CHECK_SUCCESS(ctAccept(b->other, &counts));
  CHECK(counts.nodesUpdated == INT64_MAX);
}

/* ---- Definitions ---- */

static void checkRefused(int line, const ctDefinition* d, const char* culprit) {
  ctChainTree* tree = (ctChainTree*)positions; /* anything but NULL */
  char text[200] = "";
  callCount++;
  if (ctCreate(d, &tree, text, sizeof text) != ctInvalidArgument || tree != NULL || strstr(text, culprit) == NULL) {
    reportFailure("line %d: \"%s\" does not name \"%s\"\n", line, text, culprit);
  }
}

static void testMissingArrays(void) {
  ctDefinition d = describe();
  checkRefused(__LINE__, NULL, "definition is NULL");
  CHECK(ctCreate(&d, NULL, NULL, 0) == ctInvalidArgument);
  CHECK(ctGetErrorText(NULL)[0] == '\0' && ctGetInstructionSet(NULL)[0] == '\0' && !ctValidate(NULL));
  const struct {
    const char* name;
    const void** array;
  } arrays[] = {
      {"positions is NULL", (const void**)&d.positions},         {"radii is NULL", (const void**)&d.radii},
      {"particleLinks is NULL", (const void**)&d.particleLinks}, {"linkParents is NULL", (const void**)&d.linkParents},
      {"linkJoints is NULL", (const void**)&d.linkJoints},       {"no torsion is given", (const void**)&d.linkTorsions},
      {"exclusions is NULL", (const void**)&d.exclusions}};
  for (EACH(i, arrays)) {
    const void* right = *arrays[i].array;
    *arrays[i].array = NULL;
    checkRefused(__LINE__, &d, arrays[i].name);
    *arrays[i].array = right;
  }
}

static void testWrongDefinitions(void) {
  ctDefinition d = describe();
  int* counts[] = {&d.particleCount, &d.linkCount, &d.exclusionCount};
  for (EACH(i, counts)) {
    const int right = *counts[i];
    for (EACH(k, wrongCounts)) {
      *counts[i] = wrongCounts[k];
      checkRefused(__LINE__, &d, "counts must be");
    }
    *counts[i] = right;
  }
  double* lengths[] = {&d.overlapTolerance, &d.hydrogenBondAllowance, &radii[7], &positions[8]};
  for (EACH(i, lengths)) {
    const double right = *lengths[i];
    for (EACH(k, noLengths)) {
      *lengths[i] = noLengths[k];
      checkRefused(__LINE__, &d, i < 2 ? "must be from 0" : "particle");
    }
    *lengths[i] = right;
  }
  for (EACH(k, wrongIndices)) {
    particleLinks[4] = wrongIndices[k];
    checkRefused(__LINE__, &d, "particle 4");
    particleLinks[4] = 1;
    for (int p = 0; p < 4; p++) {
      const int right = torsions[2][p];
      torsions[2][p] = wrongIndices[k];
      checkRefused(__LINE__, &d, "torsion of link 2");
      torsions[2][p] = right;
    }
    torsions[3][1] = wrongIndices[k];
    checkRefused(__LINE__, &d, "ball joint of link 3");
    d = describe();
    int wrongParents[LINKS];
    memcpy(wrongParents, parents, sizeof parents);
    wrongParents[2] = wrongIndices[k];
    d.linkParents = wrongParents;
    checkRefused(__LINE__, &d, "link 2");
    int pairs[2][2] = {{0, 1}, {2, wrongIndices[k]}};
    d = describe();
    d.exclusionCount = 2;
    d.exclusions = (const int(*)[2])pairs;
    checkRefused(__LINE__, &d, "exclusion 1");
    d = describe();
  }
  for (int wrong = 4; wrong < 256; wrong += 83) {
    uint8_t wrongJoints[LINKS];
    memcpy(wrongJoints, joints, sizeof joints);
    wrongJoints[6] = (uint8_t)wrong;
    d.linkJoints = wrongJoints;
    checkRefused(__LINE__, &d, "link 6");
    d = describe();
    roles[3] = (uint8_t)wrong;
    checkRefused(__LINE__, &d, "particle 3");
    d = describe();
  }
}

/* What an energy asks of the definition that it names. */
static void testStructure(Border* b) {
  ctDefinition d = describe();
  CHECK(ctHasStructure(b->tree, &d) && !ctHasStructure(b->tree, NULL) && !ctHasStructure(NULL, &d));
  positions[4] = NAN;
  radii[5] = -1;
  CHECK(ctHasStructure(b->tree, &d)); /* wherever particles are, and however large */
  d = describe();
  int* counts[] = {&d.particleCount, &d.linkCount};
  for (EACH(i, counts)) {
    const int right = *counts[i];
    const int wrong[] = {right - 1, right + 1, -1, 0, INT_MAX, INT_MIN};
    for (EACH(k, wrong)) {
      *counts[i] = wrong[k];
      CHECK(!ctHasStructure(b->tree, &d));
    }
    *counts[i] = right;
  }
  const void** arrays[] = {(const void**)&d.particleLinks, (const void**)&d.linkParents, (const void**)&d.linkJoints,
                           (const void**)&d.linkTorsions};
  for (EACH(i, arrays)) {
    const void* right = *arrays[i];
    *arrays[i] = NULL;
    CHECK(!ctHasStructure(b->tree, &d));
    *arrays[i] = right;
  }
  const int others[] = {INT_MIN, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8, INT_MAX};
  for (EACH(k, others)) {
    for (int i = 0; i < PARTICLES; i++) {
      const int right = particleLinks[i];
      particleLinks[i] = others[k];
      CHECK(ctHasStructure(b->tree, &d) == (others[k] == right));
      particleLinks[i] = right;
    }
    for (int link = 0; link < LINKS; link++) {
      int wrongParents[LINKS];
      memcpy(wrongParents, parents, sizeof parents);
      wrongParents[link] = others[k];
      d.linkParents = wrongParents;
      /* Links that hang on a fixed link hang on the world. */
      const bool isSame = others[k] == parents[link] || (link > 0 && (parents[link] == 0 || parents[link] == CT_NULL) &&
                                                         others[k] <= 0 && others[k] >= -1);
      CHECK(ctHasStructure(b->tree, &d) == isSame);
      uint8_t wrongJoints[LINKS];
      memcpy(wrongJoints, joints, sizeof joints);
      wrongJoints[link] = (uint8_t)others[k];
      d.linkParents = parents;
      d.linkJoints = wrongJoints;
      CHECK(ctHasStructure(b->tree, &d) == (wrongJoints[link] == joints[link]));
      d.linkJoints = joints;
      for (int p = 1; p < 3; p++) {
        const int right = torsions[link][p];
        const bool isRead = joints[link] == ctTorsionJoint || (joints[link] == ctBallJoint && p == 1);
        torsions[link][p] = others[k];
        CHECK(ctHasStructure(b->tree, &d) == (!isRead || others[k] == right));
        torsions[link][p] = right;
      }
    }
  }
}

/* ---- All ---- */

static void testAll(Border* b) {
  ask(b->tree, &b->before);
  testPositions(b);
  testPositionsOf(b);
  testState(b);
  testLinks(b);
  testLimits(b);
  testProposals(b);
  testTrials(b);
  testLeaves(b);
  testSelections(b);
  testQueries(b);
  testProbes(b);
  testCounts(b);
}

int main(void) {
  testMissingArrays();
  testWrongDefinitions();
  const ctDefinition d = describe();
  Border b = {.tree = checkedCreate(&d), .other = checkedCreate(&d)};
  const int some[] = {0, 6, 6, 7};
  const int others[] = {20, 21, 6};
  b.selections[0] = checkedSelect(b.tree, 4, some);
  b.selections[1] = checkedSelect(b.tree, 3, others);
  b.stranger = checkedSelect(b.other, 3, others);
  testStructure(&b);
  const ctChange changes[] = {{.link = 2, .angle = 1}, {.link = 7, .rotation = {0.1}, .translation = {0, 0.2}}};
  const int pairs[][2] = {{0, 5}, {3, 17}};
  const double limits[] = {0.15, INFINITY};
  testAll(&b); /* the reference */
  CHECK_SUCCESS(ctPropose(b.tree, 2, changes));
  testAll(&b);
  CHECK_SUCCESS(ctAccept(b.tree, NULL));
  CHECK_SUCCESS(ctSetLimits(b.tree, 2, pairs, limits));
  testAll(&b); /* another state, with limits */
  CHECK_SUCCESS(ctPropose(b.tree, 1, changes + 1));
  testAll(&b);
  ctFreeSelection(b.selections[0]);
  ctFreeSelection(b.selections[1]);
  ctDestroy(b.other);
  ctFreeSelection(b.stranger); /* after its scene */
  ctDestroy(b.tree);
  printf("%d calls\n", callCount);
  return checkResult();
}
