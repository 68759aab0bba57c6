/* Trials and queries in periodic boxes, against all images of all pairs in long double.
 *
 * Usage: TestImages [trials of each box] [seed]. */
#define _POSIX_C_SOURCE 200112L /* setenv */

enum { CHAINS = 6, DRIFT_TRIALS = 150 };

#include "periodic.h"

static int trialCount = 100;

/* What happened: proof that the comparison was about something. */
static struct Tally {
  long trials, displacements, clashes, byImageAlone, doubtful, accepted, neighbors, listedClashes, changed, boxes;
} tally;

/* A trial: links that change, or particles that are displaced, and positions before and in it. */
typedef struct Trial {
  int count;
  ctChange changes[2];
  int displacementCount;
  ctDisplacement displacements[MOST_DISPLACED];
  double before[3 * PARTICLES];
  double after[3 * PARTICLES];
} Trial;

static bool isPivot(const Scene* scene, const Trial* trial, int particle) {
  for (int c = 0; c < trial->count; c++) {
    const int link = trial->changes[c].link;
    if (scene->joints[link] == ctBallJoint && scene->torsions[link][1] == particle) {
      return true;
    }
  }
  return false;
}

static double squaredDistance(const double* positions, int i, int j, const double shift[3]) {
  double squared = 0;
  for (int d = 0; d < 3; d++) {
    const double apart = positions[3 * i + d] - positions[3 * j + d] + shift[d];
    squared += apart * apart;
  }
  return squared;
}

typedef struct Verdict {
  bool isClash;
  bool isClashHere; /* without images */
  bool isDoubtful;  /* it hangs on less than CT_SIGMA, or on a distance from a pivot, which is the same but is tested */
} Verdict;

/* Whether a pair whose distance changes clashes in an image. */
static void judgeImage(const Scene* scene, const Trial* trial, const double (*box)[3], int i, int j, const int n[3],
                       double contact, Verdict* verdict) {
  const long double distance = imageDistance(trial->after, i, j, box, n);
  const double overlap = (double)(contact - distance);
  if (overlap <= -CT_SIGMA) {
    return;
  }
  if (fabs((double)(imageDistance(trial->before, i, j, box, n) - distance)) > 1e-11) {
    verdict->isDoubtful = verdict->isDoubtful || overlap < CT_SIGMA;
    verdict->isClash = verdict->isClash || overlap > 0;
    verdict->isClashHere = verdict->isClashHere || (overlap > 0 && n[0] == 0 && n[1] == 0 && n[2] == 0);
  } else {
    verdict->isDoubtful = verdict->isDoubtful || isPivot(scene, trial, i) || isPivot(scene, trial, j);
  }
}

static Verdict judge(const Scene* scene, const Trial* trial, const double (*box)[3], double tolerance) {
  Verdict verdict = {false, false, false};
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      if (scene->radii[i] == 0 || scene->radii[j] == 0 || isExcluded(scene, i, j)) {
        continue;
      }
      const double contact = scene->radii[i] + scene->radii[j] - tolerance;
      int middle[3];
      nearestImage(trial->after, i, j, box, middle);
      for (int image = 0; image < 27; image++) {
        const int n[3] = {middle[0] + image % 3 - 1, middle[1] + image / 3 % 3 - 1, middle[2] + image / 9 - 1};
        double shift[3];
        for (int d = 0; d < 3; d++) {
          shift[d] = n[0] * box[0][d] + n[1] * box[1][d] + n[2] * box[2][d];
        }
        if (squaredDistance(trial->after, i, j, shift) < (contact + 1e-4) * (contact + 1e-4)) {
          judgeImage(scene, trial, box, i, j, n, contact, &verdict);
        }
      }
    }
  }
  return verdict;
}

/* ---- Queries of the state ---- */

typedef struct Listed {
  double value[PARTICLES][PARTICLES]; /* of pairs j < i; 0: not listed */
  bool twice;
} Listed;

static bool list(void* context, int particle1, int particle2, double value) {
  Listed* listed = context;
  CHECK(particle1 < particle2);
  listed->twice = listed->twice || listed->value[particle2][particle1] != 0;
  listed->value[particle2][particle1] = value;
  note(particle1 * PARTICLES + particle2);
  note(value);
  return true;
}

static bool listChanged(void* context, int particle1, int particle2, double before, double after) {
  (void)before;
  return list(context, particle1, particle2, after);
}

/* Listed pairs have these distances, and no pair is missing. */
static void checkNeighbors(const Scene* scene, ctChainTree* tree, const double* positions, const double (*box)[3],
                           double cutoff) {
  static Listed listed;
  static int pairs[2][PARTICLES * PARTICLES];
  static double distances[PARTICLES * PARTICLES];
  memset(&listed, 0, sizeof listed);
  CHECK_SUCCESS(ctForEachNeighborPair(tree, cutoff, list, &listed, NULL));
  CHECK(!listed.twice);
  size_t expected = 0;
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      const bool counts = scene->radii[i] > 0 && scene->radii[j] > 0 && !isExcluded(scene, i, j);
      const double distance = nearestDistance(positions, i, j, box);
      const double found = listed.value[i][j];
      CHECK(found == 0 ? !counts || distance > cutoff - CT_SIGMA : counts && fabs(found - distance) < 1e-12);
      expected += found != 0;
      tally.neighbors += found != 0;
    }
  }
  size_t count = 0;
  CHECK_SUCCESS(
      ctGetNeighborPairs(tree, cutoff, true, PARTICLES * PARTICLES, pairs[0], pairs[1], distances, &count, NULL));
  CHECK(count == expected);
  for (size_t i = 0; i < count; i++) {
    CHECK(distances[i] == listed.value[pairs[1][i]][pairs[0][i]]);
  }
}

static void checkClashes(const Scene* scene, ctChainTree* tree, const double* positions, const double (*box)[3],
                         double tolerance) {
  static Listed listed;
  static double forces[3 * PARTICLES];
  memset(&listed, 0, sizeof listed);
  memset(forces, 0, sizeof forces);
  CHECK_SUCCESS(ctForEachClash(tree, list, &listed, NULL));
  CHECK(!listed.twice);
  double sum = 0;
  bool some = false;
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      const bool counts = scene->radii[i] > 0 && scene->radii[j] > 0 && !isExcluded(scene, i, j);
      const double overlap = scene->radii[i] + scene->radii[j] - nearestDistance(positions, i, j, box);
      const double found = listed.value[i][j];
      CHECK(found == 0 ? !counts || overlap < tolerance + CT_SIGMA : counts && fabs(found - overlap) < 1e-12);
      sum += counts && overlap > tolerance ? 0.5 * (overlap - tolerance) * (overlap - tolerance) : 0;
      some = some || found != 0;
      tally.listedClashes += found != 0;
    }
  }
  double energy;
  bool clash;
  CHECK_SUCCESS(ctComputeEnergy(tree, 1, &energy, forces, NULL));
  CHECK_NEAR(energy, sum, 1e-12);
  CHECK_SUCCESS(ctHasClash(tree, &clash, NULL, NULL));
  CHECK(clash == some);
  double total[3] = {0, 0, 0};
  for (int i = 0; i < 3 * PARTICLES; i++) {
    total[i % 3] += forces[i];
  }
  CHECK_NEAR(total[0] * total[0] + total[1] * total[1] + total[2] * total[2], 0, 1e-20);
}

static void checkMinimumDistance(ctChainTree* tree, const double* positions, const double (*box)[3]) {
  int sets[2][8];
  int pair[2];
  double distance;
  double least = INFINITY;
  for (int k = 0; k < 16; k++) {
    sets[k / 8][k % 8] = (int)(drawn() * PARTICLES);
  }
  for (int a = 0; a < 8; a++) {
    for (int b = 0; b < 8; b++) {
      if (sets[0][a] != sets[1][b]) {
        least = fmin(least, nearestDistance(positions, sets[0][a], sets[1][b], box));
      }
    }
  }
  CHECK_SUCCESS(minimumDistance(tree, 8, sets[0], 8, sets[1], &distance, pair));
  CHECK_NEAR(distance, least, 1e-12);
}

typedef struct Probed {
  double overlap[PARTICLES];
} Probed;

static bool noteParticle(void* context, int particle, double overlap) {
  Probed* probed = context;
  CHECK(probed->overlap[particle] == 0);
  probed->overlap[particle] = overlap;
  return true;
}

static void checkProbe(const Scene* scene, ctChainTree* tree, const double* positions, const double (*box)[3],
                       double tolerance) {
  Probed probed = {{0}};
  double with[3 * (PARTICLES + 1)];
  memcpy(with, positions, 3 * PARTICLES * sizeof(double));
  for (int d = 0; d < 3; d++) {
    with[3 * PARTICLES + d] = drawnBetween(-20, 20);
  }
  const double radius = 0.6;
  CHECK_SUCCESS(ctForEachClashWith(tree, with + 3 * PARTICLES, radius, noteParticle, &probed, NULL));
  for (int i = 0; i < PARTICLES; i++) {
    const double overlap = scene->radii[i] + radius - nearestDistance(with, i, PARTICLES, box);
    const bool expected = scene->radii[i] > 0 && overlap > tolerance;
    CHECK(expected ? fabs(probed.overlap[i] - overlap) < 1e-12 : probed.overlap[i] == 0);
  }
}

/* All pairs within the cutoff in the trial whose nearest distance changes are listed, with that. */
static void checkChanged(const Scene* scene, ctChainTree* tree, const Trial* trial, const double (*box)[3],
                         double cutoff) {
  static Listed listed;
  memset(&listed, 0, sizeof listed);
  CHECK_SUCCESS(ctForEachChangedPair(tree, cutoff, listChanged, &listed, NULL));
  CHECK(!listed.twice);
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      const bool counts = scene->radii[i] > 0 && scene->radii[j] > 0 && !isExcluded(scene, i, j);
      const double before = nearestDistance(trial->before, i, j, box);
      const double after = nearestDistance(trial->after, i, j, box);
      const double found = listed.value[i][j];
      if (found == 0) {
        CHECK(!counts || fabs(before - after) < 1e-11 || (before > cutoff - CT_SIGMA && after > cutoff - CT_SIGMA));
      } else {
        CHECK(counts && (before < cutoff + CT_SIGMA || after < cutoff + CT_SIGMA));
        CHECK(after > cutoff || fabs(found - after) < 1e-12);
        tally.changed++;
      }
    }
  }
}

/* ---- Trials ---- */

/* Draws one change or two: often of the rod, and often pure translations. Or displacements. */
static void drawTrial(const Scene* scene, const double (*box)[3], Trial* trial) {
  trial->count = 0;
  trial->displacementCount = 0;
  if (areFlexible && drawn() < 0.5) {
    trial->displacementCount = drawDisplacements(box, 3, trial->displacements);
    return;
  }
  trial->count = 1 + (drawn() < 0.3);
  const int first = drawn() < 0.2 ? LINKS - 1 : (int)(drawn() * LINKS);
  for (int c = 0; c < trial->count; c++) {
    ctChange* change = &trial->changes[c];
    change->link = c == 0 ? first : (first + 1 + (int)(drawn() * (LINKS - 1))) % LINKS;
    const bool isFree = scene->joints[change->link] == ctFreeJoint;
    const bool turns = !isFree || drawn() < 0.7;
    const double most = drawn() < 0.5 ? 0.2 : 3;
    for (int d = 0; d < 3; d++) {
      change->rotation[d] = turns ? drawnBetween(-most, most) : 0;
      change->translation[d] = drawnBetween(-most, most);
      change->pivot[d] = drawnBetween(0, 3);
    }
  }
}

static void propose(ctChainTree* tree, const Trial* trial) {
  if (trial->displacementCount > 0) {
    CHECK_SUCCESS(ctProposeDisplacements(tree, trial->displacementCount, trial->displacements));
  } else {
    CHECK_SUCCESS(ctPropose(tree, trial->count, trial->changes));
  }
}

/* Displaced particles are where they were, plus the shift; all others where they were. */
static void checkDisplacements(const Trial* trial) {
  double expected[3 * PARTICLES];
  memcpy(expected, trial->before, sizeof expected);
  for (int n = 0; n < trial->displacementCount; n++) {
    for (int d = 0; d < 3; d++) {
      expected[3 * trial->displacements[n].particle + d] += trial->displacements[n].shift[d];
    }
  }
  for (int i = 0; i < 3 * PARTICLES && trial->displacementCount > 0; i++) {
    CHECK(expected[i] == trial->before[i] ? trial->after[i] == expected[i]
                                          : fabs(trial->after[i] - expected[i]) < 1e-13);
  }
}

/* A scene that is made again and given the state has the bits of the one that trials have changed. */
static void checkRebuilt(const ctDefinition* definition, ctChainTree* tree, double cutoff) {
  static Listed listed[2];
  static double positions[2][3 * PARTICLES];
  ctChainTree* again = checkedCreate(definition);
  double* numbers = malloc(ctGetStateSize(tree) * sizeof *numbers);
  ctGetState(tree, numbers);
  CHECK_SUCCESS(ctSetState(again, numbers));
  memset(listed, 0, sizeof listed);
  ctChainTree* const both[2] = {tree, again};
  bool clash[2];
  double energy[2];
  for (int k = 0; k < 2; k++) {
    ctGetPositions(both[k], positions[k]);
    CHECK_SUCCESS(ctForEachNeighborPair(both[k], cutoff, list, &listed[k], NULL));
    CHECK_SUCCESS(ctHasClash(both[k], &clash[k], NULL, NULL));
    CHECK_SUCCESS(ctComputeEnergy(both[k], 1, &energy[k], NULL, NULL));
  }
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  CHECK(memcmp(listed[0].value, listed[1].value, sizeof listed[0].value) == 0);
  CHECK(clash[0] == clash[1] && energy[0] == energy[1]);
  free(numbers);
  ctDestroy(again);
}

static void checkState(const Scene* scene, const ctDefinition* definition, ctChainTree* tree, double tolerance) {
  static double positions[3 * PARTICLES];
  const double(*box)[3] = definition->box;
  const double width = fmin(fmin(box[0][0], box[1][1]), box[2][2]);
  const double cutoff = drawn() < 0.5 ? width / 2 : 0.3 * width;
  ctGetPositions(tree, positions);
  for (int i = 0; i < 3 * PARTICLES; i++) {
    note(positions[i]);
  }
  checkNeighbors(scene, tree, positions, box, cutoff);
  checkClashes(scene, tree, positions, box, tolerance);
  checkMinimumDistance(tree, positions, box);
  checkProbe(scene, tree, positions, box, tolerance);
  checkRebuilt(definition, tree, cutoff);
}

/* Trials in a box that changes from time to time. */
static void testBox(const double (*first)[3]) {
  static Scene scene;
  static Trial trial;
  static double accepted[3 * PARTICLES];
  const double tolerance = 0.1;
  double box[3][3];
  memcpy(box, first, sizeof box);
  ctDefinition definition = describeScene(&scene, (const double(*)[3])box, tolerance);
  ctChainTree* tree = checkedCreate(&definition);
  for (int t = 0; t < trialCount; t++) {
    if (t % 50 == 25) {
      const double scale = drawnBetween(1, 1.2);
      for (int k = 0; k < 9; k++) {
        box[k / 3][k % 3] = scale * first[k / 3][k % 3];
      }
      CHECK_SUCCESS(ctSetBox(tree, definition.box));
      tally.boxes++;
    }
    drawTrial(&scene, definition.box, &trial);
    bool clash;
    ctGetPositions(tree, trial.before);
    propose(tree, &trial);
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    CHECK_SUCCESS(ctGetTrialPositions(tree, trial.after));
    checkDisplacements(&trial);
    const Verdict verdict = judge(&scene, &trial, definition.box, tolerance);
    CHECK(clash == verdict.isClash || verdict.isDoubtful);
    note(clash);
    tally.trials++;
    tally.displacements += trial.displacementCount > 0;
    tally.clashes += verdict.isClash;
    tally.byImageAlone += verdict.isClash && !verdict.isClashHere;
    tally.doubtful += verdict.isDoubtful;
    if (t % 10 == 0) {
      checkChanged(&scene, tree, &trial, definition.box, 0.4 * fmin(fmin(box[0][0], box[1][1]), box[2][2]));
    }
    if (!clash || drawn() < 0.1) {
      CHECK_SUCCESS(ctAccept(tree, NULL));
      tally.accepted++;
      ctGetPositions(tree, accepted);
      CHECK(memcmp(accepted, trial.after, sizeof accepted) == 0);
    }
    if (t % 30 == 0) {
      checkState(&scene, &definition, tree, tolerance);
    }
  }
  CHECK(ctValidate(tree));
  ctDestroy(tree);
}

/* Beads on a cubic lattice with half a box between them, in ascending or descending order: of two images at the same
 * distance one is listed. */
static void testEquallyNear(bool descends) {
  enum { SIDE_COUNT = 2, COUNT = SIDE_COUNT * SIDE_COUNT * SIDE_COUNT };
  const double box[3][3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  double positions[3 * COUNT];
  double radii[COUNT];
  int links[COUNT];
  int parents[COUNT];
  uint8_t joints[COUNT];
  for (int i = 0; i < COUNT; i++) {
    for (int d = 0; d < 3; d++) {
      positions[3 * i + d] = ((i >> d & 1) != descends) + 0.3 + 2 * (i % 3);
    }
    radii[i] = 0.1;
    links[i] = i;
    parents[i] = CT_NULL;
    joints[i] = ctFreeJoint;
  }
  const ctDefinition definition = {.particleCount = COUNT,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = COUNT,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .box = box};
  ctChainTree* tree = checkedCreate(&definition);
  PairCount pairs = {0};
  CHECK_SUCCESS(ctForEachNeighborPair(tree, 1, countPair, &pairs, NULL));
  CHECK(pairs.count == 12); /* the edges of a cube */
  CHECK_NEAR(pairs.value, 1, 1e-15);
  CHECK_FAILURE(tree, ctInvalidArgument, "half the periodic box's width, 1 nm",
                ctForEachNeighborPair(tree, 1.0001, countPair, &pairs, NULL));
  ctDestroy(tree);
}

/* A displaced bead meets an image of a bead that stays, between it and another one that is displaced. */
static void testBetweenMovers(void) {
  enum { COUNT = 60, ROW = 6 };
  const double box[3][3] = {{7, 0, 0}, {0, 7, 0}, {0, 0, 7}};
  double positions[3 * COUNT];
  double radii[COUNT];
  const int links[COUNT] = {0};
  const int parent = CT_NULL;
  const uint8_t joint = ctFreeJoint;
  for (int i = 0; i < COUNT; i++) {
    const int place[3] = {i % ROW, i / ROW % ROW, i / ROW / ROW};
    radii[i] = 0.1;
    for (int d = 0; d < 3; d++) {
      positions[3 * i + d] = place[d];
    }
  }
  const ctDefinition definition = {.particleCount = COUNT,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .linkCount = 1,
                                   .linkParents = &parent,
                                   .linkJoints = &joint,
                                   .box = box,
                                   .isFlexible = true};
  ctChainTree* tree = checkedCreate(&definition);
  bool clash;
  for (int first = 0; first + 2 < COUNT; first += ROW) {
    const ctDisplacement displacements[2] = {{.particle = first, .shift = {1, 7, -14}},
                                             {.particle = first + 2, .shift = {0, 0.3, 0}}};
    CHECK_SUCCESS(ctProposeDisplacements(tree, 2, displacements));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    CHECK(clash);
    CHECK_SUCCESS(ctProposeDisplacements(tree, 1, displacements + 1));
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    CHECK(!clash);
  }
  ctDestroy(tree);
}

/* Molecules that are many boxes away meet the same images, also after trials, and in a scene that is given the state.
 */
static void testDrift(const double (*box)[3]) {
  static Scene scene;
  enum { AWAY = 10000 };
  state = 5;
  ctChainTree* near = makeScene(&scene, box, 0.1);
  double away[LINKS][3] = {{0}};
  double positions[2][3 * PARTICLES];
  ctGetPositions(near, positions[0]);
  for (int i = 0; i < PARTICLES; i++) {
    const int link = scene.links[i];
    const bool isHead = scene.joints[link] == ctFreeJoint && (link != LINKS - 1 || i == PARTICLES - RIGID);
    for (int k = 0; k < 3 && isHead; k++) {
      const int n = (int)drawnBetween(-AWAY, AWAY);
      for (int d = 0; d < 3; d++) {
        away[link][d] += n * box[k][d];
      }
    }
    if (scene.joints[link] == ctBallJoint) {
      memcpy(away[link], away[link - 1], sizeof away[link]);
    }
    for (int d = 0; d < 3; d++) {
      positions[1][3 * i + d] = positions[0][3 * i + d] + away[link][d];
    }
  }
  state = 5;
  ctChainTree* far = makeScene(&scene, box, 0.1);
  CHECK_SUCCESS(ctSetPositions(far, positions[1]));
  ctCounts counts[2] = {{0}};
  for (int t = 0; t < DRIFT_TRIALS; t++) {
    ctChange change[2] = {{.link = (int)(drawn() * LINKS)}};
    for (int d = 0; d < 3; d++) {
      change[0].rotation[d] = drawnBetween(-1, 1);
      change[0].translation[d] = drawnBetween(-3, 3);
      change[0].pivot[d] = drawnBetween(0, 3);
    }
    change[1] = change[0];
    for (int d = 0; d < 3; d++) {
      change[1].pivot[d] += away[change[0].link][d];
    }
    ctDisplacement displacements[MOST_DISPLACED];
    const int displaced = areFlexible && t % 2 == 1 ? drawDisplacements(box, 3, displacements) : 0;
    bool clash[2];
    ctChainTree* const both[2] = {near, far};
    for (int k = 0; k < 2; k++) {
      CHECK_SUCCESS(displaced > 0 ? ctProposeDisplacements(both[k], displaced, displacements)
                                  : ctPropose(both[k], 1, &change[k]));
      CHECK_SUCCESS(ctTestTrial(both[k], &clash[k], NULL, &counts[k]));
    }
    CHECK(clash[0] == clash[1]);
    for (int k = 0; k < 2 && !clash[0]; k++) {
      CHECK_SUCCESS(ctAccept(both[k], NULL));
    }
  }
  ctGetPositions(near, positions[0]);
  ctGetPositions(far, positions[1]);
  for (int i = 0; i < 3 * PARTICLES; i++) {
    CHECK_NEAR(positions[1][i], positions[0][i] + away[scene.links[i / 3]][i % 3], 1e-10);
  }
  CHECK(counts[1].volumeTests < 10 * counts[0].volumeTests);
  /* Molecules are wrapped into few boxes. */
  const ctLeafPositions* leaves = ctGetLeaves(far);
  int particles[CT_LEAF_WIDTH * PARTICLES];
  double low = INFINITY;
  double high = -INFINITY;
  ctGetLeafParticles(far, particles);
  for (int slot = 0; slot < ctGetLeafCount(far) * CT_LEAF_WIDTH; slot++) {
    if (particles[slot] != CT_NULL) {
      low = fmin(low, leaves[slot / CT_LEAF_WIDTH].x[slot % CT_LEAF_WIDTH]);
      high = fmax(high, leaves[slot / CT_LEAF_WIDTH].x[slot % CT_LEAF_WIDTH]);
    }
  }
  CHECK(high - low < (areFlexible ? 20 : 10) * box[0][0]);
  CHECK(ctValidate(far));
  double* numbers = malloc(ctGetStateSize(far) * sizeof *numbers);
  ctGetState(far, numbers);
  CHECK_SUCCESS(ctSetState(near, numbers));
  ctGetPositions(near, positions[0]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  double centroids[2][3];
  ctTransform between[2];
  CHECK_SUCCESS(ctGetCentroid(far, 0, centroids[0]));
  CHECK_SUCCESS(ctGetRelativeTransform(far, 0, LINKS - 1, &between[0]));
  CHECK_SUCCESS(ctGetRelativeTransform(near, 0, LINKS - 1, &between[1]));
  CHECK(memcmp(&between[0], &between[1], sizeof between[0]) == 0);
  /* A box that is no box changes nothing that callers see. */
  CHECK_SUCCESS(ctSetBox(far, NULL));
  CHECK_SUCCESS(ctGetCentroid(far, 0, centroids[1]));
  CHECK_SUCCESS(ctGetRelativeTransform(far, 0, LINKS - 1, &between[1]));
  ctGetPositions(far, positions[0]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  const double* head = positions[0]; /* the origin of its link, unless it has been displaced */
  const double* other = positions[0] + 3 * (PARTICLES - RIGID);
  for (int d = 0; d < 3; d++) {
    CHECK_NEAR(centroids[0][d], centroids[1][d], 1e-10);
    if (!areFlexible) {
      CHECK_NEAR(between[1].translation[d], other[d] - head[d], 1e-10); /* no link is turned against these positions */
    }
  }
  const double* r = between[0].translation;
  const double apart[3] = {other[0] - head[0], other[1] - head[1], other[2] - head[2]};
  if (!areFlexible) {
    CHECK_NEAR(r[0] * r[0] + r[1] * r[1] + r[2] * r[2], apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2],
               1e-6);
  }
  free(numbers);
  ctDestroy(near);
  ctDestroy(far);
}

static void testFaults(void) {
  static Scene scene;
  ctChainTree* tree = makeScene(&scene, boxes[0], 0.1);
  const double left[3][3] = {{5, 0, 0}, {0, 5, 1}, {0, 0, 5}};
  const double skewed[3][3] = {{5, 0, 0}, {3, 5, 0}, {0, 0, 5}};
  const double narrow[3][3] = {{5, 0, 0}, {0, 0.3, 0}, {0, 0, 5}};
  const double flat[3][3] = {{5, 0, 0}, {0, 0, 0}, {0, 0, 5}};
  CHECK_FAILURE(tree, ctInvalidArgument, "reduced form", ctSetBox(tree, left));
  CHECK_FAILURE(tree, ctInvalidArgument, "reduced form", ctSetBox(tree, skewed));
  CHECK_FAILURE(tree, ctInvalidArgument, "0.3 nm wide", ctSetBox(tree, narrow));
  CHECK_FAILURE(tree, ctInvalidArgument, "positive volume", ctSetBox(tree, flat));
  CHECK_FAILURE(tree, ctInvalidArgument, "the probe of radius 3 nm",
                ctForEachClashWith(tree, scene.positions, 3, noteParticle, NULL, NULL));
  CHECK_SUCCESS(ctSetBox(tree, NULL));
  CHECK_SUCCESS(ctSetBox(tree, boxes[6]));
  ctDestroy(tree);
}

int main(int argumentCount, char** arguments) {
  if (argumentCount > 1) {
    trialCount = atoi(arguments[1]);
  }
  const uint32_t seed = argumentCount > 2 ? (uint32_t)strtoul(arguments[2], NULL, 10) : 1;
  testEquallyNear(false);
  testEquallyNear(true);
  testFaults();
  testBetweenMovers();
  for (int box = 0; box < 2 * BOXES; box++) {
    areFlexible = box >= BOXES;
    testDrift(boxes[box % BOXES]);
    checkInstructionSets(testBox, boxes[box % BOXES], seed + (uint32_t)(box % BOXES));
  }
  printf(
      "%ld trials, %ld of them displacements, %ld accepted; %ld clashes, %ld by images alone, %ld within rounding; %ld "
      "changes of the box\n",
      tally.trials, tally.displacements, tally.accepted, tally.clashes, tally.byImageAlone, tally.doubtful,
      tally.boxes);
  printf("listed: %ld neighbors, %ld clashes, %ld changed pairs\n", tally.neighbors, tally.listedClashes,
         tally.changed);
  CHECK(tally.clashes > tally.trials / 20 && tally.clashes < tally.trials * 19 / 20);
  CHECK(tally.byImageAlone > tally.clashes / 10);
  return checkResult();
}
