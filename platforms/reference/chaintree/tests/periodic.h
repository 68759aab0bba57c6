/* Scenes in periodic boxes: chains of beads and a rigid rod, and the images of their pairs in long double. */
#ifndef PERIODIC_H_
#define PERIODIC_H_

#include "check.h"

/* CHAINS, and _POSIX_C_SOURCE for setenv, are defined before this file is included. */
enum { BEADS = 16, RIGID = 12, PARTICLES = CHAINS * BEADS + RIGID, LINKS = CHAINS * BEADS + 1 };

static uint32_t state = 1;

/* From 0 to 1. */
static inline double drawn(void) {
  state = state * 1664525u + 1013904223u;
  return (state >> 8) * 0x1p-24;
}

static inline double drawnBetween(double low, double high) {
  return low + (high - low) * drawn();
}

/* Whether scenes that are described are flexible. */
static bool areFlexible = false;

/* Box vectors: cubic, flat, a slab, a truncated octahedron, a rhombic dodecahedron, skewed, at the edge of OpenMM's
 * reduced form, and so small that a chain meets itself. */
static const double boxes[][3][3] = {
    {{5, 0, 0}, {0, 5, 0}, {0, 0, 5}},
    {{6, 0, 0}, {0, 5, 0}, {0, 0, 3}},
    {{3, 0, 0}, {0, 3, 0}, {0, 0, 20}},
    {{5, 0, 0}, {5 / 3.0, 4.714045207910317, 0}, {-5 / 3.0, 2.3570226039551585, 4.08248290463863}},
    {{5, 0, 0}, {0, 5, 0}, {2.5, 2.5, 3.5355339059327378}},
    {{4, 0, 0}, {1.3, 4.4, 0}, {-1.1, 0.9, 5}},
    {{4, 0, 0}, {2, 4, 0}, {-2, 2, 4}},
    {{1.65, 0, 0}, {0, 1.65, 0}, {0, 0, 1.65}},
};
enum { BOXES = sizeof boxes / sizeof boxes[0] };

typedef struct Scene {
  double positions[3 * PARTICLES];
  double radii[PARTICLES];
  int links[PARTICLES];
  int parents[LINKS];
  uint8_t joints[LINKS];
  int torsions[LINKS][4];
  int exclusions[CHAINS * BEADS][2];
} Scene;

/* Chains of beads that turn about each other, about one box wide, and a rigid rod that is several boxes long. */
static inline ctDefinition describeScene(Scene* scene, const double (*box)[3], double tolerance) {
  memset(scene, 0, sizeof *scene);
  int exclusionCount = 0;
  for (int i = 0; i < PARTICLES; i++) {
    const bool isRigid = i >= CHAINS * BEADS;
    const bool isHead = isRigid ? i == CHAINS * BEADS : i % BEADS == 0;
    double* x = scene->positions + 3 * i;
    for (int d = 0; d < 3; d++) {
      const double step = drawnBetween(-0.3, 0.4);
      x[d] = isHead ? drawnBetween(0, 1.5) * box[d][d] : x[d - 3] + (isRigid ? 0.45 + 0.1 * step : step);
    }
    scene->radii[i] = i % 7 == 3 ? 0 : drawnBetween(0.05, 0.15);
    const int link = isRigid ? CHAINS * BEADS : i;
    scene->links[i] = link;
    scene->parents[link] = isHead || isRigid ? CT_NULL : i - 1;
    scene->joints[link] = isHead || isRigid ? ctFreeJoint : ctBallJoint;
    if (!isHead && !isRigid) {
      scene->torsions[link][1] = i - 1;
      scene->exclusions[exclusionCount][0] = i;
      scene->exclusions[exclusionCount++][1] = i - 1;
    }
  }
  return (ctDefinition){.particleCount = PARTICLES,
                        .positions = scene->positions,
                        .radii = scene->radii,
                        .particleLinks = scene->links,
                        .linkCount = LINKS,
                        .linkParents = scene->parents,
                        .linkJoints = scene->joints,
                        .linkTorsions = (const int(*)[4])scene->torsions,
                        .exclusionCount = exclusionCount,
                        .exclusions = (const int(*)[2])scene->exclusions,
                        .box = box,
                        .overlapTolerance = tolerance,
                        .isFlexible = areFlexible};
}

static inline ctChainTree* makeScene(Scene* scene, const double (*box)[3], double tolerance) {
  const ctDefinition definition = describeScene(scene, box, tolerance);
  return checkedCreate(&definition);
}

enum { MOST_DISPLACED = 4 };

/* Draws displacements of one to four particles, often by one shift, now and then by up to `mostAway` box vectors. */
static inline int drawDisplacements(const double (*box)[3], int mostAway, ctDisplacement* displacements) {
  const int count = 1 + (int)(drawn() * MOST_DISPLACED);
  const int first = (int)(drawn() * PARTICLES);
  const int step = drawn() < 0.5 ? 1 : 17;
  const double most = drawn() < 0.7 ? 0.1 : 1;
  const int away = drawn() < 0.1 ? (int)drawnBetween(-mostAway, mostAway + 1) : 0;
  for (int n = 0; n < count; n++) {
    const bool isAsBefore = drawn() < 0.4;
    displacements[n].particle = (first + n * step) % PARTICLES;
    for (int d = 0; d < 3; d++) {
      const double own = drawnBetween(-most, most) + away * box[n % 3][d];
      displacements[n].shift[d] = n > 0 && isAsBefore ? displacements[n - 1].shift[d] : own;
    }
  }
  return count;
}

static inline bool isExcluded(const Scene* scene, int i, int j) {
  return j == i - 1 && scene->joints[scene->links[i]] == ctBallJoint && i < CHAINS * BEADS;
}

static inline long double imageDistance(const double* positions, int i, int j, const double (*box)[3], const int n[3]) {
  long double squared = 0;
  for (int d = 0; d < 3; d++) {
    long double apart = (long double)positions[3 * i + d] - positions[3 * j + d];
    for (int k = 0; k < 3; k++) {
      apart += (long double)n[k] * box[k][d];
    }
    squared += apart * apart;
  }
  return sqrtl(squared);
}

/* The image of i that is nearest to j, if they are within half a box width of each other. */
static inline void nearestImage(const double* positions, int i, int j, const double (*box)[3], int n[3]) {
  double apart[3];
  for (int d = 0; d < 3; d++) {
    apart[d] = positions[3 * i + d] - positions[3 * j + d];
  }
  for (int k = 2; k >= 0; k--) {
    n[k] = -(int)floor(apart[k] / box[k][k] + 0.5);
    for (int d = 0; d < 3; d++) {
      apart[d] += n[k] * box[k][d];
    }
  }
}

/* The nearest image, for any distance: the least of 125 about the reduced one. */
static inline double nearestDistance(const double* positions, int i, int j, const double (*box)[3]) {
  int middle[3];
  int nearest[3] = {0, 0, 0};
  double apart[3];
  double least = INFINITY;
  nearestImage(positions, i, j, box, middle);
  for (int image = 0; image < 125; image++) {
    const int n[3] = {middle[0] + image % 5 - 2, middle[1] + image / 5 % 5 - 2, middle[2] + image / 25 - 2};
    for (int d = 0; d < 3; d++) {
      apart[d] = positions[3 * i + d] - positions[3 * j + d] + n[0] * box[0][d] + n[1] * box[1][d] + n[2] * box[2][d];
    }
    const double squared = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2];
    if (squared < least) {
      least = squared;
      memcpy(nearest, n, sizeof nearest);
    }
  }
  return (double)imageDistance(positions, i, j, box, nearest);
}

/* A hash of what a test has found. */
static uint64_t answers;

static inline void note(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  answers = (answers ^ bits) * 0x100000001b3u;
}

/* Runs a test of a box on each instruction set; all have to find the same. */
static inline void checkInstructionSets(void (*testBox)(const double (*box)[3]), const double (*box)[3],
                                        uint32_t seed) {
  static const char* const sets[] = {"portable", "avx2", "avx512"};
  uint64_t ofFirst = 0;
  for (int set = 0; set < 3; set++) {
    setenv("CHAINTREE_SIMD", sets[set], 1);
    state = seed;
    answers = 0;
    testBox(box);
    ofFirst = set == 0 ? answers : ofFirst;
    CHECK(answers == ofFirst);
  }
}

#endif /* PERIODIC_H_ */
