/* Fixed particles: a static hierarchy that trials meet, and that is never tested against itself in a trial. */
#include "lattice.h"

/* A lattice of fixed beads, in two fixed links, and one free bead and one that turns about a bond to a fixed one. */
enum { FREE_BEAD = SITES, AXIS_BEAD, ARM_BEAD, PARTICLES };
enum { FREE_LINK = 2, TURNING_LINK };

static ctChainTree* makeCage(double radius) {
  static double positions[3 * PARTICLES];
  static double radii[PARTICLES];
  static int particleLinks[PARTICLES];
  for (int i = 0; i < SITES; i++) {
    int site[3];
    latticeSite(i, site);
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = site[k];
    }
    particleLinks[i] = i % 2;
  }
  for (int i = 0; i < PARTICLES; i++) {
    radii[i] = radius;
  }
  const double others[] = {-5, -5, -5, SIDE, 4, 4, SIDE, 4, 5};
  memcpy(positions + 3 * SITES, others, sizeof others);
  particleLinks[FREE_BEAD] = FREE_LINK;
  particleLinks[AXIS_BEAD] = TURNING_LINK;
  particleLinks[ARM_BEAD] = TURNING_LINK;
  /* the axis goes along x from the lattice's wall to the bead before it; link 0 or 1 holds that site */
  const int foot = siteIndex(SIDE - 1, 4, 4);
  const int parents[] = {CT_NULL, CT_NULL, CT_NULL, particleLinks[foot]};
  const uint8_t joints[] = {ctFixedJoint, ctFixedJoint, ctFreeJoint, ctTorsionJoint};
  const int torsions[][4] = {{0}, {0}, {0}, {siteIndex(SIDE - 1, 4, 5), foot, AXIS_BEAD, ARM_BEAD}};
  const ctDefinition definition = {.particleCount = PARTICLES,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = 4,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = torsions};
  return checkedCreate(&definition);
}

static double toNearestSite(const double* x) {
  double squared = 0;
  for (int k = 0; k < 3; k++) {
    const double site = fmin(fmax(round(x[k]), 0), SIDE - 1);
    squared += (x[k] - site) * (x[k] - site);
  }
  return sqrt(squared);
}

/* A bead among obstacles that just don't touch each other. */
static void testFreeBead(void) {
  const double radius = 0.45;
  ctChainTree* cage = makeCage(radius);
  ctCounts counts = {0};
  int clashing = 0;
  enum { TRIALS = 2000 };
  for (int n = 0; n < TRIALS; n++) {
    const double to[3] = {fmod(n * 0.7548776662, 1) * 12 - 1.5, fmod(n * 0.5698402909, 1) * 12 - 1.5,
                          fmod(n * 0.3141592653, 1) * 12 - 1.5};
    const ctChange change = {.link = FREE_LINK, .translation = {to[0] + 5, to[1] + 5, to[2] + 5}};
    bool clash;
    int pair[2];
    CHECK_SUCCESS(ctPropose(cage, 1, &change));
    CHECK_SUCCESS(ctTestTrial(cage, &clash, pair, &counts));
    const double toTurning =
        fmin(hypot(hypot(to[0] - SIDE, to[1] - 4), to[2] - 4), hypot(hypot(to[0] - SIDE, to[1] - 4), to[2] - 5));
    CHECK(clash == (fmin(toNearestSite(to), toTurning) < 2 * radius));
    CHECK(!clash || pair[0] == FREE_BEAD || pair[1] == FREE_BEAD);
    clashing += clash;
  }
  CHECK(clashing > TRIALS / 10 && clashing < TRIALS * 9 / 10);
  /* a hierarchy: a trial visits few of the 729 obstacles */
  CHECK(counts.particleTests < TRIALS * (int64_t)SITES / 4);
  ctDestroy(cage);
}

/* Obstacles that overlap each other: clashes of the state, but no trial's fault. */
static void testObstaclesAmongThemselves(void) {
  ctChainTree* cage = makeCage(0.55);
  PairCount pairs = {0};
  bool clash;
  CHECK_SUCCESS(ctForEachClash(cage, countPair, &pairs, NULL));
  CHECK(pairs.count == latticePairs(1) + 3);
  const ctChange away = {.link = FREE_LINK, .translation = {-1, 0, 0}};
  CHECK_SUCCESS(ctPropose(cage, 1, &away));
  CHECK_SUCCESS(ctTestTrial(cage, &clash, NULL, NULL));
  CHECK(!clash);
  /* the turning link's own bond to the wall is a changed pair, since it is not excluded */
  const ctChange turn = {.link = TURNING_LINK, .angle = 0.1};
  int pair[2];
  CHECK_SUCCESS(ctPropose(cage, 1, &turn));
  CHECK_SUCCESS(ctTestTrial(cage, &clash, pair, NULL));
  CHECK(clash && pair[1] >= AXIS_BEAD && pair[0] < SITES);
  ctDestroy(cage);
}

/* Fixed particles keep their bits, whatever happens to what hangs on them. */
static void testFixedBits(void) {
  ctChainTree* cage = makeCage(0.1);
  static double before[3 * PARTICLES];
  static double after[3 * PARTICLES];
  ctGetPositions(cage, before);
  for (int n = 0; n < 20; n++) {
    const ctChange changes[] = {{.link = TURNING_LINK, .angle = 0.1},
                                {.link = FREE_LINK, .rotation = {0.1, 0.2, 0.3}, .translation = {0.1, 0, 0}}};
    CHECK_SUCCESS(ctPropose(cage, 2, changes));
    CHECK_SUCCESS(ctAccept(cage, NULL));
  }
  ctGetPositions(cage, after);
  CHECK(memcmp(before, after, sizeof(double[3 * SITES])) == 0);
  CHECK_NEAR(after[3 * ARM_BEAD + 1], 4 - sin(2), 1e-14);
  CHECK_NEAR(after[3 * ARM_BEAD + 2], 4 + cos(2), 1e-14);
  double angle;
  CHECK_SUCCESS(ctGetTorsionAngle(cage, TURNING_LINK, &angle));
  CHECK_NEAR(angle, 2, 1e-14);
  const ctChange fixed = {.link = 1};
  CHECK_FAILURE(cage, ctInvalidArgument, "link 1", ctPropose(cage, 1, &fixed));
  double centroid[3];
  CHECK_FAILURE(cage, ctInvalidArgument, "link 0", ctGetCentroid(cage, 0, centroid));
  ctDestroy(cage);
}

int main(void) {
  testFreeBead();
  testObstaclesAmongThemselves();
  testFixedBits();
  return checkResult();
}
