/* Rigid bodies in periodic boxes: many that are small beside the box, and one that is as long as it. */
#define _POSIX_C_SOURCE 200112L /* setenv */

enum { CHAINS = 0 };

#include "../src/tester.h"
#include "periodic.h"

enum { BODIES = 60, SIZE = 16, COUNT = BODIES * SIZE, MOVED = 4 };

static const double radius = 0.3;

/* Bodies of sixteen particles each, at these places, within 1 nm. */
static ctChainTree* makeBodies(const double (*box)[3], double positions[3 * COUNT]) {
  static double radii[COUNT];
  static int links[COUNT];
  static int parents[BODIES];
  static uint8_t joints[BODIES];
  for (int body = 0; body < BODIES; body++) {
    parents[body] = CT_NULL;
    joints[body] = ctFreeJoint;
    for (int i = 0; i < SIZE; i++) {
      for (int d = 0; d < 3; d++) {
        double place = drawnBetween(-0.5, 0.5);
        for (int k = 0; k < 3; k++) {
          const int at = k == 0 ? body % 4 : k == 1 ? body / 4 % 4 : body / 16;
          place += 0.25 * (at + 0.5) * box[k][d];
        }
        positions[3 * (body * SIZE + i) + d] = place;
      }
      radii[body * SIZE + i] = radius;
      links[body * SIZE + i] = body;
    }
  }
  const ctDefinition definition = {.particleCount = COUNT,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = BODIES,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .box = box};
  return checkedCreate(&definition);
}

/* True if a particle of a moved body and one of another body overlap in their nearest images. Adds to `doubtful` where
 * rounding decides. */
static bool clashes(const double* positions, const ctChange changes[MOVED], const double (*box)[3], int* doubtful) {
  bool isClash = false;
  for (int m = 0; m < MOVED; m++) {
    for (int i = changes[m].link * SIZE; i < (changes[m].link + 1) * SIZE; i++) {
      for (int j = 0; j < COUNT; j++) {
        if (j / SIZE == changes[m].link) {
          continue;
        }
        int n[3];
        nearestImage(positions, i, j, box, n);
        const double overlap = 2 * radius - (double)imageDistance(positions, i, j, box, n);
        *doubtful += fabs(overlap) < CT_SIGMA;
        isClash = isClash || overlap > 0;
      }
    }
  }
  return isClash;
}

/* Trials that move four of the bodies anywhere. Counts free trials and clashes. */
static void testManyBodies(const double (*box)[3], int found[2]) {
  static double positions[3 * COUNT];
  ctChainTree* tree = makeBodies(box, positions);
  int doubtful = 0;
  for (int trial = 0; trial < 30; trial++) {
    ctChange changes[MOVED];
    memset(changes, 0, sizeof changes);
    const double size = trial % 2 == 0 ? 3 : 30;
    for (int m = 0; m < MOVED; m++) {
      changes[m].link = (trial * 7 + m * 13) % BODIES;
      for (int d = 0; d < 3; d++) {
        changes[m].rotation[d] = drawnBetween(-1, 1);
        changes[m].translation[d] = drawnBetween(-size, size);
      }
    }
    bool clash;
    CHECK_SUCCESS(ctPropose(tree, MOVED, changes));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    CHECK_SUCCESS(ctGetTrialPositions(tree, positions));
    CHECK(clash == clashes(positions, changes, box, &doubtful));
    found[clash]++;
    if (clash) {
      ctReject(tree);
    } else {
      CHECK_SUCCESS(ctAccept(tree, NULL));
    }
  }
  CHECK(doubtful == 0);
  ctDestroy(tree);
}

/* A rod of seventeen beads along the diagonal of a face is longer than the box, which it fills when it turns. */
static void testRod(void) {
  enum { RODS = 2, LENGTH = 17 };
  const double box[3][3] = {{3, 0, 0}, {0, 3, 0}, {0, 0, 3}};
  double positions[3 * RODS * LENGTH] = {0};
  double radii[RODS * LENGTH];
  int links[RODS * LENGTH];
  const int parents[RODS] = {CT_NULL, CT_NULL};
  const uint8_t joints[RODS] = {ctFreeJoint, ctFreeJoint};
  for (int i = 0; i < RODS * LENGTH; i++) {
    positions[3 * i] = 0.2 * (i % LENGTH) * cos(0.5);
    positions[3 * i + 1] = 0.2 * (i % LENGTH) * sin(0.5);
    positions[3 * i + 2] = i < LENGTH ? 0 : 1.5;
    radii[i] = 0.15;
    links[i] = i / LENGTH;
  }
  const ctDefinition definition = {.particleCount = RODS * LENGTH,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = RODS,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .box = box};
  ctChainTree* tree = checkedCreate(&definition);
  const ctChange turn = {.link = 0, .rotation = {0, 0, -0.5}};
  const ctChange shift = {.link = 0, .translation = {1.1, -7.3, 0.4}};
  bool clash;
  CHECK_SUCCESS(ctPropose(tree, 1, &turn));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  CHECK(clash);
  CHECK_SUCCESS(ctPropose(tree, 1, &shift));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  CHECK(!clash);
  ctDestroy(tree);
}

int main(void) {
  static const char* const courses[] = {"tree", "boxes", "clearances", "any"};
  int found[2] = {0, 0};
  for (int course = 0; course < 4; course++) {
    setenv("CHAINTREE_TRIALS", courses[course], 1);
    testRod();
    for (int box = 0; box < BOXES; box++) {
      double wide[3][3];
      for (int k = 0; k < 3; k++) {
        for (int d = 0; d < 3; d++) {
          wide[k][d] = boxes[box][k][d] * 15 / boxes[box][0][0];
        }
      }
      testManyBodies((const double(*)[3])wide, found);
    }
  }
  CHECK(found[0] > 200 && found[1] > 200);
  return checkResult();
}
