/* Pairs across the faces of periodic boxes whose overlap is within CT_SIGMA of the limit, or just beyond. */
#define _POSIX_C_SOURCE 200112L /* setenv */

enum { CHAINS = 0 };

#include "../src/tester.h"
#include "periodic.h"

enum { COUNT = 3 };

static const double radius = 0.2;
static const double tolerance = 0.05;

/* Three beads, of which the last is far from the others' images. */
static ctDefinition describeBeads(double positions[3 * COUNT], const double (*box)[3]) {
  static const double radii[COUNT] = {radius, radius, radius};
  static const int links[COUNT] = {0, 1, 2};
  static const int parents[COUNT] = {CT_NULL, CT_NULL, CT_NULL};
  static const uint8_t joints[COUNT] = {ctFreeJoint, ctFreeJoint, ctFreeJoint};
  const double parts[COUNT] = {0.02, 0.3, 0.63};
  for (int i = 0; i < COUNT; i++) {
    for (int d = 0; d < 3; d++) {
      positions[3 * i + d] = parts[i] * (box[0][d] + box[1][d] + box[2][d]);
    }
  }
  return (ctDefinition){.particleCount = COUNT,
                        .positions = positions,
                        .radii = radii,
                        .particleLinks = links,
                        .linkCount = COUNT,
                        .linkParents = parents,
                        .linkJoints = joints,
                        .box = box,
                        .overlapTolerance = tolerance};
}

/* Moves bead 1 to an image of bead 0, `excess` beyond the distance at which they clash. Returns the verdict. */
static bool testPair(const double (*box)[3], const int n[3], double excess) {
  double positions[3 * COUNT];
  double after[3 * COUNT];
  const ctDefinition definition = describeBeads(positions, box);
  ctChainTree* trees[2] = {checkedCreate(&definition), checkedCreate(&definition)};
  ctChange change = {.link = 1};
  const double direction[3] = {drawnBetween(-1, 1), drawnBetween(-1, 1), drawnBetween(-1, 1)};
  const double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
  for (int d = 0; d < 3; d++) {
    const double image = positions[d] + n[0] * box[0][d] + n[1] * box[1][d] + n[2] * box[2][d];
    change.translation[d] = image + (2 * radius - tolerance + excess) * direction[d] / length - positions[3 + d];
  }
  bool clash;
  CHECK_SUCCESS(ctPropose(trees[0], 1, &change));
  CHECK_SUCCESS(ctTestTrial(trees[0], &clash, NULL, NULL));
  CHECK_SUCCESS(ctGetTrialPositions(trees[0], after));
  const double overlap = (double)(2 * radius - tolerance - imageDistance(after, 0, 1, box, n));
  CHECK(fabs(overlap) < CT_SIGMA || clash == (overlap > 0));

  /* The state has the verdict of the trial, and so have a scene that is given the state, and a trial that moves the
   * other bead nowhere. */
  bool hasClash[2];
  double numbers[64];
  CHECK_SUCCESS(ctAccept(trees[0], NULL));
  CHECK(ctGetStateSize(trees[0]) <= 64);
  ctGetState(trees[0], numbers);
  CHECK_SUCCESS(ctSetState(trees[1], numbers));
  for (int k = 0; k < 2; k++) {
    PairCount pairs = {0};
    CHECK_SUCCESS(ctHasClash(trees[k], &hasClash[k], NULL, NULL));
    CHECK(hasClash[k] == clash);
    CHECK_SUCCESS(ctForEachClash(trees[k], countPair, &pairs, NULL));
    CHECK(pairs.count == (clash ? 1 : 0));
    ctDestroy(trees[k]);
  }
  return clash;
}

/* A trial that clashed with an image is tested again: in the same box it clashes at once, in a wider one, where that
 * image is elsewhere, not. */
static void testWiderBox(void) {
  const double box[2][3][3] = {{{3, 0, 0}, {0, 3, 0}, {0, 0, 3}}, {{3.4, 0, 0}, {0, 3.4, 0}, {0, 0, 3.4}}};
  double positions[3 * COUNT] = {0};
  ctDefinition definition = describeBeads(positions, box[0]);
  const double near[3 * COUNT] = {0.06, 0.06, 0.06, 1.5, 1.5, 1.5, 2.94, 2, 2};
  definition.positions = near;
  ctChainTree* tree = checkedCreate(&definition);
  ctChange change = {.link = 1, .translation = {2.81 - 1.5, 0.06 - 1.5, 0.06 - 1.5}};
  CHECK(ctSwitchTester(tree, "fewMovers", false));
  for (int k = 0; k < 3; k++) {
    bool clash;
    ctCounts counts = {0};
    CHECK_SUCCESS(k == 1 ? ctSuccess : ctSetBox(tree, box[k / 2]));
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, &counts));
    CHECK(clash == (k < 2));
    CHECK((counts.volumeTests + counts.particleTests == 1) == (k == 1));
    ctReject(tree);
  }
  ctDestroy(tree);
}

int main(void) {
  static const char* const sets[] = {"avx512", "avx2", "portable"};
  static const char* const courses[] = {"tree", "boxes", "clearances", "any"};
  enum { SETS = 3, COURSES = 4, STEPS = 40 };
  int clashes = 0;
  testWiderBox();
  for (int box = 0; box < BOXES; box++) {
    for (int image = 0; image < 27; image++) {
      const int n[3] = {image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1};
      for (int step = -STEPS; step <= STEPS; step += 3 + image % 7) {
        const uint32_t before = state;
        bool first = false;
        for (int way = 0; way < SETS * COURSES; way++) {
          setenv("CHAINTREE_SIMD", sets[way % SETS], 1);
          setenv("CHAINTREE_TRIALS", courses[way / SETS], 1);
          state = before;
          const bool clash = testPair(boxes[box], n, step * CT_SIGMA / 16);
          first = way == 0 ? clash : first;
          CHECK(clash == first);
        }
        clashes += first;
      }
    }
  }
  CHECK(clashes > 27 * BOXES);
  return checkResult();
}
