/* Every allocation of every call fails once: the call says so, changes nothing, and works the next time; by every
 * instruction set, and whichever way trials are tested.
 *
 * The program puts its own functions before the C library's allocator; where that cannot be done, it is skipped. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "failingallocator.h"
#include "lattice.h"

#ifndef HAS_GLIBC_ALLOCATOR

int main(void) {
  return 77;
}

#else

/* ---- Creation ---- */

enum { ROWS = 7, ROW = 20 };

/* Rows of particles, each a link, turning about each other; the first is fixed. Neighbours in a row are excluded. */
static void testCreate(void) {
  static double positions[3 * ROWS * ROW];
  static double radii[ROWS * ROW];
  static int particleLinks[ROWS * ROW];
  static int parents[ROWS];
  static uint8_t joints[ROWS];
  static int torsions[ROWS][4];
  static int exclusions[ROWS * ROW][2];
  for (int i = 0; i < ROWS * ROW; i++) {
    const int row = i / ROW;
    positions[3 * i] = i % ROW;
    positions[3 * i + 1] = row;
    radii[i] = i % 5 == 0 ? 0 : 0.1;
    particleLinks[i] = row;
    exclusions[i][0] = i;
    exclusions[i][1] = (i + 1) % (ROWS * ROW);
  }
  for (int row = 0; row < ROWS; row++) {
    const int torsion[4] = {row * ROW - 1, (row - 1) * ROW, row * ROW, row * ROW + 1};
    parents[row] = row - 1;
    joints[row] = (uint8_t)(row == 0 ? ctFixedJoint : ctTorsionJoint);
    memcpy(torsions[row], torsion, sizeof torsion);
  }
  const ctDefinition definition = {.particleCount = ROWS * ROW,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = ROWS,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions,
                                   .exclusionCount = ROWS * ROW,
                                   .exclusions = (const int(*)[2])exclusions};
  const int before = live;
  int n = 0;
  do {
    ctChainTree* tree = NULL;
    char text[100] = "";
    failAllocation(n++);
    const ctStatus status = ctCreate(&definition, &tree, text, sizeof text);
    allocationsLeft = -1;
    if (status != ctSuccess) {
      CHECK(hasFailed && status == ctOutOfMemory && tree == NULL && strcmp(text, "out of memory") == 0);
      CHECK(live == before);
    }
    ctDestroy(tree);
    CHECK(live == before);
  } while (hasFailed);
  CHECK(n > 50);
}

/* ---- Calls ---- */

/* Beads that just touch, so that a verdict has many pairs to decide by their canonical distance. */
static ctChainTree* makeTouching(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0.5, 0);
  const ctChange change = {.link = 4, .translation = {0, 0, 0}};
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  return tree;
}

static ctStatus proposeMany(ctChainTree* tree) {
  ctChange changes[SIDE] = {{0}};
  for (int link = 0; link < SIDE; link++) {
    changes[link].link = link;
    changes[link].translation[0] = 0.1;
  }
  return ctPropose(tree, SIDE, changes);
}

static ctStatus displaceMany(ctChainTree* tree) {
  ctDisplacement displacements[SIDE] = {{0}};
  for (int i = 0; i < SIDE; i++) {
    displacements[i].particle = 7 * i;
    displacements[i].shift[i % 3] = 0.01 * i;
  }
  return ctProposeDisplacements(tree, SIDE, displacements);
}

/* From the proposal to the end of the trial, whichever of the calls fails. */
static ctStatus displaceAndAccept(ctChainTree* tree) {
  bool clash;
  ctStatus status = displaceMany(tree);
  if (status == ctSuccess) {
    status = ctTestTrial(tree, &clash, NULL, NULL);
  }
  return status == ctSuccess ? ctAccept(tree, NULL) : status;
}

static ctStatus test(ctChainTree* tree) {
  bool clash;
  return ctTestTrial(tree, &clash, NULL, NULL);
}

static bool passChangedPair(void* context, int particle1, int particle2, double before, double after) {
  return countPair(context, particle1, particle2, fmin(before, after));
}

static ctStatus listChanged(ctChainTree* tree) {
  PairCount pairs = {0};
  return ctForEachChangedPair(tree, 1.2, passChangedPair, &pairs, NULL);
}

static ctStatus acceptTrial(ctChainTree* tree) {
  return ctAccept(tree, NULL);
}

static ctStatus setLimits(ctChainTree* tree) {
  const int pairs[][2] = {{4, 3}, {1, 2}};
  const double limits[] = {0.1, 0.2};
  return ctSetLimits(tree, 2, pairs, limits);
}

static ctStatus raiseLimits(ctChainTree* tree) {
  int raised;
  return ctRaiseLimits(tree, &raised, NULL);
}

static ctStatus selectFew(ctChainTree* tree) {
  const int particles[] = {0, 1};
  ctSelection* selection;
  const ctStatus status = ctSelect(tree, 2, particles, &selection);
  CHECK((selection != NULL) == (status == ctSuccess));
  ctFreeSelection(selection);
  return status;
}

static ctStatus listNeighbors(ctChainTree* tree) {
  PairCount pairs = {0};
  return ctForEachNeighborPair(tree, 1.2, countPair, &pairs, NULL);
}

static ctStatus sortNeighbors(ctChainTree* tree) {
  static int particles[2][SITES * SITES];
  size_t count;
  return ctGetNeighborPairs(tree, 1.2, true, SITES * SITES, particles[0], particles[1], NULL, &count, NULL);
}

static ctStatus readLeaves(ctChainTree* tree) {
  return ctGetLeaves(tree) != NULL ? ctSuccess : ctOutOfMemory;
}

static ctStatus listLeafPairs(ctChainTree* tree) {
  size_t count;
  const ctLeafPair* pairs;
  return ctGetLeafPairs(tree, 2.5, &count, &pairs, NULL);
}

static ctStatus listChangedLeafPairs(ctChainTree* tree) {
  size_t count;
  const ctLeafPair* pairs;
  const ctLeafPositions* positions;
  return ctGetChangedLeafPairs(tree, 2.5, &count, &pairs, &positions, NULL);
}

static ctStatus findClash(ctChainTree* tree) {
  bool clash;
  return ctHasClash(tree, &clash, NULL, NULL);
}

static ctStatus testState(ctChainTree* tree) {
  bool clash;
  return ctTestState(tree, &clash, NULL, NULL);
}

static ctStatus listClashes(ctChainTree* tree) {
  PairCount pairs = {0};
  return ctForEachClash(tree, countPair, &pairs, NULL);
}

static ctStatus computeEnergy(ctChainTree* tree) {
  static double forces[3 * SITES];
  double energy;
  return ctComputeEnergy(tree, 1, &energy, forces, NULL);
}

static bool passParticle(void* context, int particle, double overlap) {
  return countPair(context, particle, particle, overlap);
}

static ctStatus probe(ctChainTree* tree) {
  static const double position[3] = {1, 1, 1};
  PairCount particles = {0};
  return ctForEachClashWith(tree, position, 1.2, passParticle, &particles, NULL);
}

/* What needs no memory of its own. */
static ctStatus readState(ctChainTree* tree) {
  ctTransform transform;
  double centroid[3];
  const ctStatus status = ctGetCentroid(tree, 1, centroid);
  return status == ctSuccess ? ctGetRelativeTransform(tree, 1, 2, &transform) : status;
}

/* A validation that is refused memory is none. */
static ctStatus validate(ctChainTree* tree) {
  const bool valid = ctValidate(tree);
  CHECK(valid != hasFailed);
  return ctSuccess;
}

static ctStatus setSameState(ctChainTree* tree) {
  static double state[3 * SITES + 3 + 10 * SIDE];
  ctGetState(tree, state);
  return ctSetState(tree, state);
}

static ctStatus setSamePositions(ctChainTree* tree) {
  static double positions[3 * SITES];
  ctGetPositions(tree, positions);
  return ctSetPositions(tree, positions);
}

/* `allocates`: whether the call needs memory at all, on a scene that has not been used before. */
static void testCall(const char* name, ctStatus (*call)(ctChainTree* tree), bool allocates, double overlap) {
  static double state[3 * SITES];
  static double trial[3 * SITES];
  static double now[3 * SITES];
  int refused = 0;
  int n = 0;
  do {
    ctChainTree* tree = makeTouching();
    const int pair[][2] = {{0, 1}};
    const double limit = 0.3;
    if (overlap > 0) {
      const ctChange change = {.link = 0, .translation = {0, 0, overlap}};
      CHECK_SUCCESS(ctPropose(tree, 1, &change));
      CHECK_SUCCESS(ctAccept(tree, NULL));
    }
    CHECK_SUCCESS(ctSetLimits(tree, 1, pair, &limit));
    ctGetPositions(tree, state);
    const bool hasTrial = ctHasTrial(tree);
    if (hasTrial) {
      CHECK_SUCCESS(ctGetTrialPositions(tree, trial));
    }
    failAllocation(n++);
    const ctStatus status = call(tree);
    allocationsLeft = -1;
    CHECK(status == ctSuccess || (hasFailed && status == ctOutOfMemory));
    if (status != ctSuccess) {
      refused++;
      CHECK(strcmp(ctGetErrorText(tree), "out of memory") == 0);
      CHECK(ctHasTrial(tree) == hasTrial);
      CHECK(ctGetLimitCount(tree) == 1);
      ctGetPositions(tree, now);
      CHECK(memcmp(state, now, sizeof state) == 0);
      if (hasTrial) {
        CHECK_SUCCESS(ctGetTrialPositions(tree, now));
        CHECK(memcmp(trial, now, sizeof trial) == 0);
      }
      CHECK(call(tree) == ctSuccess);
      CHECK(ctValidate(tree));
    }
    ctDestroy(tree);
  } while (hasFailed);
  if ((refused > 0) != allocates) {
    printf("%s was refused memory %d times\n", name, refused);
    checkFailures++;
  }
}

/* Each allocation on the way to an accepted displacement fails once. The next try gives the same positions. */
static void testDisplaced(void) {
  static double positions[2][3 * SITES];
  int n = 0;
  bool continues;
  do {
    ctChainTree* tree = makeLattice(LAYERS, 0.4, 0);
    failAllocation(n++);
    const ctStatus status = displaceAndAccept(tree);
    continues = hasFailed;
    allocationsLeft = -1;
    CHECK(status == ctSuccess || (hasFailed && status == ctOutOfMemory));
    if (status != ctSuccess) {
      CHECK_SUCCESS(displaceAndAccept(tree));
    }
    CHECK(ctValidate(tree));
    ctGetPositions(tree, positions[n > 1]);
    CHECK(n == 1 || memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
    ctDestroy(tree);
  } while (continues);
  CHECK(n > 3);
}

/* ---- A selection of particles without radius, which are apart from the others ---- */

static void testSelectBare(void) {
  ctChainTree* tree = makeLattice(LAYERS, 0, 0);
  const int particles[] = {5, 1, 5, SITES - 1};
  const int before = live;
  int n = 0;
  bool continues;
  do {
    ctSelection* selection = NULL;
    failAllocation(n++);
    const ctStatus status = ctSelect(tree, 4, particles, &selection);
    continues = hasFailed;
    CHECK((selection != NULL) == (status == ctSuccess) && (status == ctSuccess || hasFailed));
    double distance;
    int pair[2];
    failAllocation(0);
    CHECK(selection == NULL || ctGetMinimumDistance(tree, selection, selection, &distance, pair, NULL) == ctSuccess);
    allocationsLeft = -1;
    ctFreeSelection(selection);
    CHECK(live == before);
  } while (continues);
  CHECK(n > 2);
  ctDestroy(tree);
}

/* ---- A long run ---- */

enum { RUN = 400 };

/* Asks again where there was no memory. */
static bool isTrialFree(ctChainTree* tree, const ctChange* change) {
  bool clash = false;
  ctStatus status;
  do {
    status = ctPropose(tree, 1, change);
  } while (status == ctOutOfMemory);
  CHECK(status == ctSuccess);
  do {
    status = ctTestTrial(tree, &clash, NULL, NULL);
  } while (status == ctOutOfMemory);
  CHECK(status == ctSuccess);
  return !clash;
}

/* Turns that are accepted unless they clash: enough of them that testers are chosen that pay only in the long run. */
static void run(bool verdicts[RUN], double positions[3 * SITES]) {
  ctChainTree* tree = makeLattice(ONE_CHAIN, 0.45, 0);
  unsigned chance = 1;
  for (int i = 0; i < RUN; i++) {
    chance = chance * 1664525u + 1013904223u;
    const ctChange change = {.link = 1 + (int)(chance >> 8) % (SITES - 1),
                             .angle = 0.001 * (double)((int)(chance >> 20) % 16 - 8)};
    verdicts[i] = isTrialFree(tree, &change);
    if (verdicts[i]) {
      CHECK(ctAccept(tree, NULL) == ctSuccess);
    }
  }
  ctGetPositions(tree, positions);
  allocationsLeft = -1;
  CHECK(ctValidate(tree)); /* which needs memory */
  ctDestroy(tree);
}

/* An allocation that fails on the way leaves no trace: neither in verdicts nor in positions. */
static void testRun(void) {
  static bool expected[RUN];
  static bool verdicts[RUN];
  static double expectedPositions[3 * SITES];
  static double positions[3 * SITES];
  const int before = live;
  run(expected, expectedPositions);
  /* Allocations of ctCreate fail elsewhere. */
  int n = -asked;
  ctDestroy(makeLattice(ONE_CHAIN, 0.45, 0));
  n += asked;
  do {
    failAllocation(n++);
    run(verdicts, positions);
    allocationsLeft = -1;
    CHECK(memcmp(verdicts, expected, sizeof verdicts) == 0);
    CHECK(memcmp(positions, expectedPositions, sizeof positions) == 0);
    CHECK(live == before);
  } while (hasFailed);
}

static void testAll(void) {
  const int before = live;
  testCreate();
  testCall("propose", proposeMany, true, 0);
  areFlexible = true;
  testCall("displace", displaceMany, true, 0);
  testCall("set the state of a flexible scene", setSameState, false, 0.2);
  testDisplaced();
  areFlexible = false;
  testCall("test", test, true, 0);
  testCall("list changed pairs", listChanged, true, 0);
  testCall("read leaves", readLeaves, true, 0);
  testCall("list pairs of leaves", listLeafPairs, true, 0);
  testCall("list changed pairs of leaves", listChangedLeafPairs, true, 0);
  testCall("set limits", setLimits, true, 0);
  testCall("raise limits", raiseLimits, true, 0.2);
  testCall("select", selectFew, true, 0);
  testCall("accept", acceptTrial, false, 0);
  testCall("find a clash", findClash, true, 0.2);
  testCall("test the state", testState, true, 0.2);
  testCall("list clashes", listClashes, true, 0.2);
  testCall("compute the energy", computeEnergy, true, 0.2);
  testCall("probe", probe, false, 0.2);
  testCall("list neighbours", listNeighbors, true, 0);
  testCall("sort neighbours", sortNeighbors, true, 0.2);
  testCall("set positions", setSamePositions, false, 0);
  testCall("set state", setSameState, false, 0.2);
  testCall("read the state", readState, false, 0.2);
  testCall("validate", validate, false, 0);
  testSelectBare();
  testRun();
  CHECK(live == before);
}

int main(void) {
  printf("\n"); /* its buffer is no leak of ours */
  const char* const sets[] = {"avx512", "avx2", "portable"};
  const char* const courses[] = {"cost", "tree", "boxes", "clearances"};
  for (int i = 0; i < 3; i++) {
    for (int k = 0; k < 4; k++) {
      setenv("CHAINTREE_SIMD", sets[i], 1);
      setenv("CHAINTREE_TRIALS", courses[k], 1);
      testAll();
    }
  }
  return checkResult();
}

#endif
