/* Boxes that are scaled with the centroids of molecules, and tests of whole states. */
#define _POSIX_C_SOURCE 200112L /* setenv */

enum { CHAINS = 6, ROUNDS = 40 };

#include "periodic.h"

static const double TOLERANCE = 0.1;

/* The head of the molecule of a particle. */
static int headOf(int particle) {
  return particle < CHAINS * BEADS ? particle - particle % BEADS : CHAINS * BEADS;
}

static void findCentroids(const double* positions, double (*centroids)[3]) {
  int counts[PARTICLES] = {0};
  memset(centroids, 0, PARTICLES * sizeof *centroids);
  for (int i = 0; i < PARTICLES; i++) {
    counts[headOf(i)]++;
    for (int d = 0; d < 3; d++) {
      centroids[headOf(i)][d] += positions[3 * i + d];
    }
  }
  for (int i = 0; i < PARTICLES; i++) {
    for (int d = 0; d < 3 && headOf(i) == i; d++) {
      centroids[i][d] /= counts[i];
    }
  }
}

/* Moves some links far and by many boxes. */
static void shake(const Scene* scene, ctChainTree* tree, const double (*box)[3]) {
  for (int t = 0; t < 20; t++) {
    ctChange change = {.link = (int)(drawn() * LINKS)};
    const bool isFree = scene->joints[change.link] == ctFreeJoint;
    const int away = isFree ? (int)drawnBetween(-9, 9) : 0;
    for (int d = 0; d < 3; d++) {
      change.rotation[d] = drawnBetween(-1, 1);
      change.translation[d] = drawnBetween(-2, 2) + away * box[2][d];
      change.pivot[d] = drawnBetween(0, 3);
    }
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    ctDisplacement displacements[MOST_DISPLACED];
    if (areFlexible) {
      CHECK_SUCCESS(ctProposeDisplacements(tree, drawDisplacements(box, 3, displacements), displacements));
      CHECK_SUCCESS(ctAccept(tree, NULL));
    }
  }
}

/* Whether some pair, of all images, overlaps by more than the tolerance. */
static bool hasClash(const Scene* scene, const double* positions, const double (*box)[3]) {
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      const double overlap = scene->radii[i] + scene->radii[j] - nearestDistance(positions, i, j, box);
      if (scene->radii[i] > 0 && scene->radii[j] > 0 && !isExcluded(scene, i, j) && overlap > TOLERANCE) {
        return true;
      }
    }
  }
  return false;
}

static void checkScaled(const double* before, const double* after, double factor) {
  static double centroids[2][PARTICLES][3];
  findCentroids(before, centroids[0]);
  findCentroids(after, centroids[1]);
  for (int i = 0; i < PARTICLES; i++) {
    const int head = headOf(i);
    for (int d = 0; d < 3; d++) {
      CHECK_NEAR(centroids[1][head][d], factor * centroids[0][head][d], 1e-11);
      CHECK_NEAR(after[3 * i + d] - centroids[1][head][d], before[3 * i + d] - centroids[0][head][d], 1e-11);
    }
  }
}

static int clashing = 0;

static void testBox(const double (*first)[3]) {
  static Scene scene;
  static double positions[3][3 * PARTICLES];
  ctChainTree* tree = makeScene(&scene, first, TOLERANCE);
  double* numbers = malloc(ctGetStateSize(tree) * sizeof *numbers);
  double box[3][3];
  double scaled[3][3];
  for (int round = 0; round < ROUNDS; round++) {
    CHECK(ctGetBox(tree, box));
    shake(&scene, tree, (const double(*)[3])box);
    ctGetPositions(tree, positions[0]);
    const double factor = box[0][0] > 1.5 * first[0][0] ? 0.6 : drawnBetween(0.9, 1.2);
    const ctChange opened = {.link = 0, .translation = {1, 0, 0}};
    CHECK_SUCCESS(ctPropose(tree, 1, &opened));
    const int64_t changes = ctGetChangeCount(tree);
    CHECK_SUCCESS(ctScaleBox(tree, factor));
    CHECK(!ctHasTrial(tree) && ctGetChangeCount(tree) > changes);
    CHECK(ctGetBox(tree, scaled));
    for (int k = 0; k < 9; k++) {
      CHECK(scaled[k / 3][k % 3] == factor * box[k / 3][k % 3]);
    }
    ctGetPositions(tree, positions[1]);
    checkScaled(positions[0], positions[1], factor);
    bool clash;
    int pair[2] = {CT_NULL, CT_NULL};
    CHECK_SUCCESS(ctTestState(tree, &clash, pair, NULL));
    CHECK(clash == hasClash(&scene, positions[1], (const double(*)[3])scaled));
    CHECK(clash == (pair[0] >= 0 && pair[0] < pair[1]));
    clashing += clash;
    for (int i = 0; i < 3 * PARTICLES; i++) {
      note(positions[1][i]);
    }
    CHECK(ctValidate(tree));
    /* A scene that is given the state has its bits. */
    ctGetState(tree, numbers);
    static Scene same;
    ctDefinition definition = describeScene(&same, (const double(*)[3])scaled, TOLERANCE);
    memcpy(same.positions, scene.positions, sizeof scene.positions);
    memcpy(same.radii, scene.radii, sizeof scene.radii);
    ctChainTree* other = checkedCreate(&definition);
    CHECK_SUCCESS(ctSetState(other, numbers));
    ctGetPositions(other, positions[2]);
    CHECK(memcmp(positions[1], positions[2], sizeof positions[1]) == 0);
    /* Back again: the same up to rounding. */
    CHECK_SUCCESS(ctScaleBox(other, 1 / factor));
    ctGetPositions(other, positions[2]);
    for (int i = 0; i < 3 * PARTICLES; i++) {
      CHECK_NEAR(positions[2][i], positions[0][i], 1e-11);
    }
    ctDestroy(other);
  }
  free(numbers);
  ctDestroy(tree);
}

/* Limits decide whether a state clashes, and scaling keeps them. */
static void testLimits(void) {
  static Scene scene;
  ctChainTree* tree = makeScene(&scene, boxes[0], TOLERANCE);
  bool clash;
  int raised;
  int pair[2];
  CHECK_SUCCESS(ctTestState(tree, &clash, pair, NULL));
  CHECK(clash);
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  CHECK(raised > 0);
  CHECK_SUCCESS(ctTestState(tree, &clash, NULL, NULL));
  CHECK(!clash);
  /* Without the limit of one pair, that pair alone clashes. */
  const int count = ctGetLimitCount(tree);
  int(*pairs)[2] = malloc((size_t)count * sizeof *pairs);
  double* limits = malloc((size_t)count * sizeof *limits);
  ctGetLimits(tree, count, pairs, limits);
  CHECK_SUCCESS(ctSetLimits(tree, count - 1, (const int(*)[2])pairs, limits));
  CHECK_SUCCESS(ctTestState(tree, &clash, pair, NULL));
  CHECK(clash && pair[0] == pairs[count - 1][0] && pair[1] == pairs[count - 1][1]);
  CHECK_SUCCESS(ctSetLimits(tree, count, (const int(*)[2])pairs, limits));
  CHECK_SUCCESS(ctScaleBox(tree, 1.5));
  CHECK(ctGetLimitCount(tree) == count);
  free(pairs);
  free(limits);
  ctDestroy(tree);
}

static void testFaults(void) {
  static Scene scene;
  static double positions[2][3 * PARTICLES];
  ctChainTree* tree = makeScene(&scene, boxes[5], TOLERANCE);
  double box[3][3];
  ctGetPositions(tree, positions[0]);
  CHECK_FAILURE(tree, ctInvalidArgument, "positive and finite", ctScaleBox(tree, 0));
  CHECK_FAILURE(tree, ctInvalidArgument, "positive and finite", ctScaleBox(tree, -1));
  CHECK_FAILURE(tree, ctInvalidArgument, "positive and finite", ctScaleBox(tree, NAN));
  CHECK_FAILURE(tree, ctInvalidArgument, "nm wide", ctScaleBox(tree, 0.01));
  CHECK_FAILURE(tree, ctInvalidArgument, "at most 1e15 nm long", ctScaleBox(tree, 1e16));
  CHECK(ctScaleBox(NULL, 1) == ctInvalidArgument);
  CHECK(ctTestState(tree, NULL, NULL, NULL) == ctInvalidArgument);
  CHECK(ctGetBox(tree, box) && memcmp(box, boxes[5], sizeof box) == 0);
  ctGetPositions(tree, positions[1]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  CHECK_SUCCESS(ctSetBox(tree, NULL));
  CHECK_FAILURE(tree, ctInvalidArgument, "no periodic box", ctScaleBox(tree, 1.1));
  ctDestroy(tree);
}

int main(void) {
  for (int box = 0; box < 2 * BOXES; box++) {
    areFlexible = box >= BOXES;
    checkInstructionSets(testBox, boxes[box % BOXES], (uint32_t)(box % BOXES) + 1);
  }
  printf("%d of %d states clash\n", clashing, 6 * BOXES * ROUNDS);
  CHECK(clashing > 0 && clashing < 6 * BOXES * ROUNDS);
  testLimits();
  testFaults();
  return checkResult();
}
