/* Flexible scenes at their borders: what is refused, what the state holds, and displacements of particles that are
 * special. */
#include "chain.h"

/* A wall; a free link; a link that turns about the bond 2-4 behind it, and on that one that turns about its particle 7.
 * Particle 6 has no radius and no slot. */
enum { WALL, HEAD, ARM, HAND, LINKS };
enum { PARTICLES = 9, COORDINATES = 3 * PARTICLES, PLACED = 10, SIZE = COORDINATES + 3 + 3 * PLACED };

static const double startPositions[COORDINATES] = {-1, 0,    0, -1, 1,    0, 0,   0, 0, 0,   0.5, 0, 0.5, 0,
                                                   0,  0.75, 0, 1,  0.75, 1, 0.5, 1, 0, 0.5, 1,   1, 0.5};
static const double radii[PARTICLES] = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0, 0.1, 0.1};
static const uint8_t roles[PARTICLES] = {0, 0, ctDonor, ctAcceptor, 0, 0, 0, 0, 0};
static const int particleLinks[PARTICLES] = {WALL, WALL, HEAD, HEAD, ARM, ARM, ARM, HAND, HAND};
static const int parents[LINKS] = {CT_NULL, CT_NULL, HEAD, ARM};
static const uint8_t joints[LINKS] = {ctFixedJoint, ctFreeJoint, ctTorsionJoint, ctBallJoint};
static const int torsions[LINKS][4] = {{0}, {0}, {3, 2, 4, 5}, {CT_NULL, 7, CT_NULL, CT_NULL}};
static const int exclusions[][2] = {{4, 5}};

static ctDefinition describe(void) {
  return (ctDefinition){.particleCount = PARTICLES,
                        .positions = startPositions,
                        .radii = radii,
                        .hydrogenBondRoles = roles,
                        .particleLinks = particleLinks,
                        .linkCount = LINKS,
                        .linkParents = parents,
                        .linkJoints = joints,
                        .linkTorsions = torsions,
                        .exclusionCount = 1,
                        .exclusions = exclusions,
                        .overlapTolerance = 0.01,
                        .hydrogenBondAllowance = 0.05,
                        .isFlexible = true};
}

static ctChainTree* makeScene(void) {
  const ctDefinition definition = describe();
  return checkedCreate(&definition);
}

static ctStatus displace(ctChainTree* tree, int particle, double x, double y, double z) {
  const ctDisplacement displacement = {.particle = particle, .shift = {x, y, z}};
  return ctProposeDisplacements(tree, 1, &displacement);
}

static void displaceFor(ctChainTree* tree, int particle, double x, double y, double z) {
  CHECK_SUCCESS(displace(tree, particle, x, y, z));
  CHECK_SUCCESS(ctAccept(tree, NULL));
}

static bool clashes(ctChainTree* tree) {
  bool clash = false;
  int pair[2] = {CT_NULL, CT_NULL};
  CHECK_SUCCESS(ctTestTrial(tree, &clash, pair, NULL));
  CHECK(clash == (pair[0] >= 0 && pair[0] < pair[1]));
  return clash;
}

/* ---- Calls that fail ---- */

static void testRefused(void) {
  ctChainTree* tree = makeScene();
  double before[COORDINATES];
  double after[COORDINATES];
  CHECK_SUCCESS(displace(tree, 5, 0.125, 0, 0));
  CHECK_SUCCESS(ctGetTrialPositions(tree, before));
  const int64_t trials = ctGetTrialCount(tree);
  const ctDisplacement twice[] = {{.particle = 8}, {.particle = 4}, {.particle = 7}, {.particle = 4}};
  const ctDisplacement one = {.particle = 8};
  CHECK_FAILURE(tree, ctInvalidArgument, "particle 4 is displaced twice", ctProposeDisplacements(tree, 4, twice));
  CHECK_FAILURE(tree, ctInvalidArgument, "particle 1 is fixed", displace(tree, 1, 0, 0, 0));
  CHECK_FAILURE(tree, ctInvalidArgument, "no particle -1", displace(tree, -1, 0, 0, 0));
  CHECK_FAILURE(tree, ctInvalidArgument, "no particle 9", displace(tree, PARTICLES, 0, 0, 0));
  CHECK_FAILURE(tree, ctInvalidArgument, "0 particles", ctProposeDisplacements(tree, 0, &one));
  CHECK_FAILURE(tree, ctInvalidArgument, "-1 particles", ctProposeDisplacements(tree, -1, &one));
  CHECK_FAILURE(tree, ctInvalidArgument, "10 particles", ctProposeDisplacements(tree, PARTICLES + 1, &one));
  CHECK_FAILURE(tree, ctInvalidArgument, "displacements", ctProposeDisplacements(tree, 1, NULL));
  const double wrong[] = {NAN, INFINITY, -INFINITY, 1.1 * CT_MOST_LENGTH, -1e300};
  for (int i = 0; i < 15; i++) {
    double shift[3] = {0, 0, 0};
    shift[i % 3] = wrong[i / 3];
    CHECK_FAILURE(tree, ctInvalidArgument, "particle 8", displace(tree, 8, shift[0], shift[1], shift[2]));
  }
  CHECK(ctHasTrial(tree) && ctGetTrialCount(tree) == trials);
  CHECK_SUCCESS(ctGetTrialPositions(tree, after));
  CHECK(memcmp(before, after, sizeof before) == 0);
  CHECK(ctProposeDisplacements(NULL, 1, &one) == ctInvalidArgument);
  ctDestroy(tree);

  ctDefinition rigid = describe();
  rigid.isFlexible = false;
  tree = checkedCreate(&rigid);
  CHECK_FAILURE(tree, ctInvalidArgument, "flexible", displace(tree, 4, 0, 0, 0));
  CHECK(ctGetStateSize(tree) == COORDINATES + 7 + 1 + 4);
  CHECK(ctHasStructure(tree, &rigid));
  rigid.isFlexible = true;
  CHECK(!ctHasStructure(tree, &rigid));
  ctDestroy(tree);
}

/* No particle comes so far away by many displacements that the state could not be set. */
static void testFarAway(void) {
  ctChainTree* tree = makeScene();
  double state[SIZE];
  int moves = 0;
  while (moves < 30 && displace(tree, 8, 0.1 * CT_MOST_LENGTH, 0, 0) == ctSuccess) {
    CHECK(!clashes(tree));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    ctGetState(tree, state);
    CHECK_SUCCESS(ctSetState(tree, state));
    moves++;
  }
  CHECK(moves == 9 || moves == 10);
  CHECK(strstr(ctGetErrorText(tree), "particle 8 takes it too far away") != NULL);
  CHECK_FAILURE(tree, ctInvalidArgument, "too far", displace(tree, 8, 0, 0.5 * CT_MOST_LENGTH, 0));
  CHECK_SUCCESS(displace(tree, 4, 0, 0.5 * CT_MOST_LENGTH, 0));
  ctDestroy(tree);
}

/* ---- The trial ---- */

static void testTrialParticles(void) {
  ctChainTree* tree = makeScene();
  const int* particles;
  const int* links;
  CHECK(ctGetTrialParticles(tree, &particles) == 0);
  CHECK(ctGetTrialParticles(NULL, &particles) == 0 && ctGetTrialParticles(tree, NULL) == 0);
  const ctDisplacement three[] = {{.particle = 8, .shift = {0.5, 0, 0}},
                                  {.particle = 6, .shift = {0, 0.5, 0}},
                                  {.particle = 2, .shift = {0.5, 0, 0}}};
  CHECK_SUCCESS(ctProposeDisplacements(tree, 3, three));
  CHECK(ctGetTrialParticles(tree, &particles) == 3);
  CHECK(particles[0] + particles[1] + particles[2] == 16);
  CHECK(ctGetTrialLinks(tree, &links) == 0);
  /* Two pieces that move, as one body; particle 6 has no slot. */
  const ctPiece* pieces;
  const ctTransform* motions;
  const int pieceCount = ctGetTrialPieces(tree, &pieces, &motions);
  int moving = 0;
  for (int i = 0; i < pieceCount; i++) {
    CHECK(pieces[i].body == 0 || pieces[i].body == 1);
    moving += pieces[i].body == 1;
  }
  CHECK(moving == 2);
  CHECK(motions[1].translation[0] == 0.5 && motions[1].rotation[0] == 1 && motions[1].rotation[1] == 0);
  ctReject(tree);
  CHECK(ctGetTrialParticles(tree, &particles) == 0);
  CHECK_SUCCESS(ctProposeDisplacements(tree, 3, three));
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = ARM, .angle = 0.1}));
  CHECK(ctGetTrialParticles(tree, &particles) == 0 && ctGetTrialLinks(tree, &links) == 1);
  CHECK_SUCCESS(ctProposeDisplacements(tree, 3, three));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK(ctGetTrialParticles(tree, &particles) == 0);
  ctDestroy(tree);
}

/* Pairs that clash, by their tolerance, hydrogen bond, limit and exclusion, and within one link. */
static void testVerdicts(void) {
  ctChainTree* tree = makeScene();
  /* 2 and 3, of one link, 0.5 apart, may overlap by 0.06. */
  CHECK_SUCCESS(displace(tree, 3, 0, -0.355, 0));
  CHECK(!clashes(tree));
  CHECK_SUCCESS(displace(tree, 3, 0, -0.365, 0));
  CHECK(clashes(tree));
  /* Both by one shift are one body, whatever they overlap. */
  displaceFor(tree, 3, 0, -0.4, 0);
  const ctDisplacement both[] = {{.particle = 2, .shift = {-0.25, 0, 0}}, {.particle = 3, .shift = {-0.25, 0, 0}}};
  CHECK_SUCCESS(ctProposeDisplacements(tree, 2, both));
  CHECK(!clashes(tree));
  const ctDisplacement apart[] = {{.particle = 2, .shift = {-0.25, 0, 0}}, {.particle = 3, .shift = {-0.25, 0.01, 0}}};
  CHECK_SUCCESS(ctProposeDisplacements(tree, 2, apart));
  CHECK(clashes(tree));
  /* 4 and 5 are excluded. */
  CHECK_SUCCESS(displace(tree, 5, -0.25, 0, -1));
  CHECK(!clashes(tree));
  /* 7 and 8, 1 apart, may overlap by 0.01, or by their own limit. */
  const int pair[][2] = {{7, 8}};
  const double limit = 0.1;
  CHECK_SUCCESS(displace(tree, 8, 0, -0.805, 0));
  CHECK(!clashes(tree));
  CHECK_SUCCESS(displace(tree, 8, 0, -0.82, 0));
  CHECK(clashes(tree));
  CHECK_SUCCESS(ctSetLimits(tree, 1, pair, &limit));
  CHECK(!clashes(tree));
  CHECK_SUCCESS(displace(tree, 8, 0, -0.91, 0));
  CHECK(clashes(tree));
  /* Particle 4 against the wall, and a particle without a radius against anything. */
  CHECK_SUCCESS(displace(tree, 4, -1.5, 0.05, 0));
  CHECK(clashes(tree));
  CHECK_SUCCESS(displace(tree, 6, -1.75, -1, 0));
  CHECK(!clashes(tree));
  ctDestroy(tree);
}

/* A bead of a long row is displaced far out of all bounds around it, and at once another onto it: nothing that would
 * compute bounds again is asked between. */
static void testFarOut(void) {
  enum { BEADS = 600, OUT = 311 };
  for (int other = 5; other < BEADS; other += 45) {
    const Chain chain = allocateChain(BEADS, BEADS, ctFreeJoint);
    for (int i = 0; i < BEADS; i++) {
      const double position[3] = {0.3 * i, 0.1 * (i % 2), 0};
      setBead(&chain, i, position, 0.1);
    }
    chainsAreFlexible = true;
    ctChainTree* tree = createChain(&chain);
    CHECK_SUCCESS(displace(tree, OUT, 0, 7, 0));
    CHECK(!clashes(tree));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    CHECK_SUCCESS(displace(tree, other, 0.3 * (OUT - other), 6.9, 0));
    CHECK(clashes(tree));
    CHECK_SUCCESS(displace(tree, other, 0.3 * (OUT - other), 6.5, 0));
    CHECK(!clashes(tree));
    ctDestroy(tree);
  }
}

/* ---- Particles without a slot ---- */

static void testSlotless(void) {
  ctChainTree* tree = makeScene();
  double positions[COORDINATES];
  double expected[COORDINATES];
  double centroid[2][3];
  const int six = 6;
  double single[3];
  const int64_t changes = ctGetChangeCount(tree);
  memcpy(expected, startPositions, sizeof expected);
  CHECK_SUCCESS(ctGetCentroid(tree, ARM, centroid[0]));
  expected[3 * 6 + 1] += 0.25;
  CHECK_SUCCESS(displace(tree, 6, 0, 0.25, 0));
  CHECK(!clashes(tree));
  CHECK_SUCCESS(ctGetTrialPositions(tree, positions));
  CHECK(memcmp(positions, expected, sizeof expected) == 0);
  CHECK_SUCCESS(ctGetPositionsOf(tree, true, 1, &six, single));
  CHECK(memcmp(single, expected + 18, sizeof single) == 0);
  CHECK_SUCCESS(ctGetPositionsOf(tree, false, 1, &six, single));
  CHECK(memcmp(single, startPositions + 18, sizeof single) == 0);
  CHECK_SUCCESS(ctAccept(tree, NULL));
  CHECK(ctGetChangeCount(tree) > changes);
  ctGetPositions(tree, positions);
  CHECK(memcmp(positions, expected, sizeof expected) == 0);
  CHECK_SUCCESS(ctGetCentroid(tree, ARM, centroid[1]));
  CHECK_NEAR(centroid[1][1], centroid[0][1] + 0.25 / 5, 1e-15);
  CHECK(ctValidate(tree));
  /* It turns with its link from where it is: by half a turn about the x axis, on which 2 and 4 lie. */
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = ARM, .angle = PI}));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  ctGetPositions(tree, positions);
  CHECK_NEAR(positions[18], 0.75, 1e-15);
  CHECK_NEAR(positions[19], -1.25, 1e-15);
  CHECK_NEAR(positions[20], -0.5, 1e-15);
  ctDestroy(tree);
}

/* ---- Axes and pivots ---- */

/* A torsion whose axis particles come to lie at one place cannot turn, until they are apart again. */
static void testAxisOfNoLength(void) {
  ctChainTree* tree = makeScene();
  double angle;
  double state[SIZE];
  CHECK_SUCCESS(ctGetTorsionAngle(tree, ARM, &angle));
  CHECK_NEAR(fabs(angle), PI / 2, 1e-15);
  displaceFor(tree, 4, -0.5, 0, 0);
  CHECK_FAILURE(tree, ctInvalidArgument, "link 2 cannot turn: its axis particles 2 and 4 are at one place",
                ctPropose(tree, 1, &(ctChange){.link = ARM, .angle = 0.1}));
  CHECK_FAILURE(tree, ctInvalidArgument, "undefined", ctGetTorsionAngle(tree, ARM, &angle));
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = HAND, .rotation = {0.1, 0, 0}}));
  ctGetState(tree, state);
  CHECK_SUCCESS(ctSetState(tree, state));
  CHECK(ctValidate(tree));
  /* Now 4 is behind 2, and the axis points the other way. */
  displaceFor(tree, 4, -0.5, 0, 0);
  CHECK_SUCCESS(ctGetTorsionAngle(tree, ARM, &angle));
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = ARM, .angle = PI / 2}));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  double turned;
  CHECK_SUCCESS(ctGetTorsionAngle(tree, ARM, &turned));
  CHECK_NEAR(remainder(turned - angle - PI / 2, 2 * PI), 0, 1e-14);
  double positions[COORDINATES];
  ctGetPositions(tree, positions);
  CHECK_NEAR(positions[15], 0.75, 1e-14); /* 5 was at z = 1 */
  CHECK_NEAR(positions[16], 1, 1e-14);
  CHECK_NEAR(positions[17], 0, 1e-14);
  ctDestroy(tree);
}

/* A ball joint turns about its particle where that is now. The frame of its link stays where it was. */
static void testPivot(void) {
  ctChainTree* tree = makeScene();
  double positions[COORDINATES];
  ctTransform before;
  ctTransform after;
  CHECK_SUCCESS(ctGetRelativeTransform(tree, HEAD, HAND, &before));
  displaceFor(tree, 7, 0.5, 0, 0);
  CHECK_SUCCESS(ctGetRelativeTransform(tree, HEAD, HAND, &after));
  CHECK(memcmp(&before, &after, sizeof before) == 0);
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = HAND, .rotation = {0, 0, PI}}));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  ctGetPositions(tree, positions);
  CHECK_NEAR(positions[21], 1.5, 1e-15);
  CHECK_NEAR(positions[22], 0, 1e-15);
  CHECK_NEAR(positions[24], 2, 1e-15); /* 8 was at x = 1, y = 1 */
  CHECK_NEAR(positions[25], -1, 1e-15);
  CHECK_NEAR(positions[26], 0.5, 1e-15);
  ctDestroy(tree);
}

/* A ball joint about a particle of the parent that has no slot: the trial moves slots about where it is now. */
static void testSlotlessPivot(void) {
  static const int aboutSix[LINKS][4] = {{0}, {0}, {3, 2, 4, 5}, {CT_NULL, 6, CT_NULL, CT_NULL}};
  ctDefinition definition = describe();
  definition.linkTorsions = aboutSix;
  ctChainTree* tree = checkedCreate(&definition);
  double before[COORDINATES];
  double after[COORDINATES];
  for (int turn = 0; turn < 3; turn++) {
    displaceFor(tree, 6, 0.25, 0.5, -0.125);
    CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = HAND, .rotation = {0.3, -0.7, 0.5}}));
    const ctPiece* pieces;
    const ctTransform* motions;
    ctGetTrialPieces(tree, &pieces, &motions);
    ctGetPositions(tree, before);
    CHECK_SUCCESS(ctGetTrialPositions(tree, after));
    for (int i = 3 * 7; i < COORDINATES; i++) {
      const double* r = motions[1].rotation + 3 * (i % 3);
      const double* x = before + i - i % 3;
      CHECK_NEAR(after[i], r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + motions[1].translation[i % 3], 1e-14);
    }
    CHECK_SUCCESS(ctAccept(tree, NULL));
  }
  ctDestroy(tree);
}

/* ---- The state ---- */

static void testState(void) {
  ctChainTree* tree = makeScene();
  ctChainTree* other = makeScene();
  double state[SIZE];
  double again[SIZE];
  double positions[2][COORDINATES];
  CHECK(ctGetStateSize(tree) == SIZE);
  displaceFor(tree, 4, 0.1, 0.2, -0.1);
  displaceFor(tree, 2, 0, 0.2, -0.1);
  displaceFor(tree, 7, 0.3, 0, 0);
  CHECK_SUCCESS(ctPropose(tree, 2, (ctChange[]){{.link = ARM, .angle = 1}, {.link = HAND, .rotation = {0, 1, 0}}}));
  CHECK_SUCCESS(ctAccept(tree, NULL));
  ctGetState(tree, state);
  ctGetPositions(tree, positions[0]);
  CHECK_SUCCESS(ctSetState(other, state));
  ctGetPositions(other, positions[1]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  ctGetState(other, again);
  CHECK(memcmp(state, again, sizeof state) == 0);
  /* The origins of links are those of the start, not of displaced particles. */
  const double* ofArm = state + COORDINATES + 3 + PLACED + 7;
  CHECK(ofArm[0] == 0.5 && ofArm[1] == 0 && ofArm[2] == 0);
  CHECK(state[3 * 4] != 0.5);
  /* New reference positions have their own. */
  CHECK_SUCCESS(ctSetPositions(other, positions[0]));
  ctGetState(other, again);
  CHECK(memcmp(again, positions[0], sizeof positions[0]) == 0);
  CHECK(memcmp(again + COORDINATES + 3 + PLACED + 7, positions[0] + 3 * 4, sizeof(double[3])) == 0);
  ctGetPositions(other, positions[1]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  /* Each number at values that are none. */
  const double none[] = {NAN, INFINITY, 20 * CT_MOST_LENGTH};
  CHECK_SUCCESS(displace(tree, 5, 0.1, 0, 0));
  for (int i = 0; i < SIZE; i++) {
    const char* culprit = i < COORDINATES ? "particle" : i < COORDINATES + 3 ? "the origin of the world" : "link";
    for (int n = 0; n < 3; n++) {
      memcpy(again, state, sizeof again);
      again[i] = none[n];
      CHECK_FAILURE(tree, ctInvalidArgument, culprit, ctSetState(tree, again));
    }
  }
  CHECK(ctHasTrial(tree));
  ctGetPositions(tree, positions[1]);
  CHECK(memcmp(positions[0], positions[1], sizeof positions[0]) == 0);
  ctDestroy(tree);
  ctDestroy(other);
}

int main(void) {
  testRefused();
  testFarAway();
  testTrialParticles();
  testVerdicts();
  testFarOut();
  testSlotless();
  testAxisOfNoLength();
  testPivot();
  testSlotlessPivot();
  testState();
  return checkResult();
}
