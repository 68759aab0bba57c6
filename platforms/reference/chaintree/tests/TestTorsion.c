/* The sign, the zero and the range of a torsion. */
#include "arm.h"

/* p1-p2-p3-p4, with the dihedral at an angle: seen from p2 to p3, along +z, p4 is that far clockwise of p1 (IUPAC).
 * Link 0 holds p1 and p2, or with rootAtP3 p3 and p4; particle 4, of the other link, stands beside the axis. */
static ctChainTree* makeDihedral(double angle, bool rootAtP3) {
  const double side = rootAtP3 ? 0 : 1;
  const double positions[] = {1, 0, 0, 0, 0, 0, 0, 0, 1, cos(angle), sin(angle), 1, cos(angle), sin(angle), 2 * side};
  const double radii[] = {0.1, 0.1, 0.1, 0.1, 0.1};
  const int atP2[] = {0, 0, 1, 1, 1};
  const int atP3[] = {1, 1, 0, 0, 1};
  const int parents[] = {CT_NULL, 0};
  const uint8_t joints[] = {ctFixedJoint, ctTorsionJoint};
  const int torsions[][4] = {{0}, {0, 1, 2, 3}};
  const ctDefinition definition = {.particleCount = 5,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = rootAtP3 ? atP3 : atP2,
                                   .linkCount = 2,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = torsions};
  return checkedCreate(&definition);
}

/* In (-pi, pi]. */
static double wrapped(double angle) {
  const double turned = remainder(angle, 2 * PI);
  return turned <= -PI ? turned + 2 * PI : turned;
}

/* The angle from p1 to p4 about +z. */
static double measuredDihedral(const double* positions) {
  return atan2(positions[0] * positions[10] - positions[1] * positions[9],
               positions[0] * positions[9] + positions[1] * positions[10]);
}

static void testSign(void) {
  for (int rootAtP3 = 0; rootAtP3 < 2; rootAtP3++) {
    for (int n = -7; n <= 8; n++) {
      const double start = n * PI / 8;
      ctChainTree* tree = makeDihedral(start, rootAtP3);
      double angle;
      double before[15];
      double after[15];
      CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
      CHECK_NEAR(angle, start, 1e-14);
      ctGetPositions(tree, before);
      CHECK_NEAR(remainder(measuredDihedral(before) - start, 2 * PI), 0, 1e-14);
      turnArm(tree, 1, 0.3);
      CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
      CHECK_NEAR(angle, wrapped(start + 0.3), 1e-14);
      ctGetPositions(tree, after);
      CHECK_NEAR(remainder(measuredDihedral(after) - start - 0.3, 2 * PI), 0, 1e-14);
      /* the root's side keeps its bits, and the axis its place */
      const int still = rootAtP3 ? 2 : 0;
      CHECK(memcmp(before + 3 * still, after + 3 * still, sizeof(double[6])) == 0);
      for (int i = 3; i < 9; i++) {
        CHECK_NEAR(after[i], before[i], 1e-15);
      }
      ctDestroy(tree);
    }
  }
}

/* Dihedrals lie in (-pi, pi], and what turns back to where it was has the reference's bits. */
static void testRange(void) {
  ctChainTree* tree = makeDihedral(0, false);
  double reference[15];
  double positions[15];
  double angle;
  ctGetPositions(tree, reference);
  turnArm(tree, 1, PI);
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
  CHECK_NEAR(angle, PI, 1e-15);
  turnArm(tree, 1, 3);
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
  CHECK_NEAR(angle, 3 - PI, 1e-14);
  turnArm(tree, 1, -3);
  turnArm(tree, 1, -PI);
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
  CHECK_NEAR(angle, 0, 1e-15);
  turnArm(tree, 1, 200 * PI);
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
  CHECK_NEAR(angle, 0, 1e-13);

  /* coordinates whose bits no arithmetic would reproduce */
  for (int i = 0; i < 15; i++) {
    reference[i] += (i % 3 + 1) / 7.0;
  }
  memcpy(reference + 12, (double[]){100.0 / 3, -1e-3 / 7, 1e4 / 9}, sizeof(double[3]));
  CHECK_SUCCESS(ctSetPositions(tree, reference));
  turnArm(tree, 1, 0.7);
  ctGetPositions(tree, positions);
  CHECK(memcmp(positions, reference, sizeof positions) != 0);
  turnArm(tree, 1, -0.7);
  ctGetPositions(tree, positions);
  CHECK(memcmp(positions, reference, sizeof positions) == 0);
  CHECK(ctValidate(tree));
  ctDestroy(tree);
}

/* New positions are a new reference: with their own dihedral. */
static void testNewReference(void) {
  ctChainTree* tree = makeDihedral(0.2, false);
  turnArm(tree, 1, 1);
  double positions[15];
  ctGetPositions(tree, positions);
  double angle;
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle)); /* of the old reference, which is forgotten */
  CHECK_NEAR(angle, 1.2, 1e-14);
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  CHECK_SUCCESS(ctGetTorsionAngle(tree, 1, &angle));
  CHECK_NEAR(angle, 1.2, 1e-14);
  turnArm(tree, 1, -1);
  ctGetPositions(tree, positions);
  CHECK_NEAR(measuredDihedral(positions), 0.2, 1e-14);
  ctDestroy(tree);
}

/* Inner turns don't show in outer dihedrals, nor outer in inner. */
static void testIndependence(void) {
  enum { LINKS = 40 };
  ctChainTree* arm = makeArm(LINKS, ctFreeJoint, 0.1);
  for (int link = LINKS - 1; link > 0; link--) {
    turnArm(arm, link, 0.01 * link);
  }
  for (int link = 1; link < LINKS; link++) {
    double angle;
    CHECK_SUCCESS(ctGetTorsionAngle(arm, link, &angle));
    CHECK_NEAR(angle, wrapped(PI + 0.01 * link), 1e-14);
  }
  ctDestroy(arm);
}

/* A straight p1-p2-p3 has no dihedral, but its bond can be turned. */
static void testCollinear(void) {
  ctChainTree* tree = makeDihedral(0.5, false);
  double positions[15];
  double turned[15];
  ctGetPositions(tree, positions);
  memcpy(positions, (double[]){0, 0, -1}, sizeof(double[3]));
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  double angle;
  CHECK_FAILURE(tree, ctInvalidArgument, "0, 1, 2 and 3", ctGetTorsionAngle(tree, 1, &angle));
  turnArm(tree, 1, 0.25);
  ctGetPositions(tree, turned);
  CHECK_NEAR(turned[9], cos(0.75), 1e-15);
  CHECK_NEAR(turned[10], sin(0.75), 1e-15);
  memcpy(positions, (double[]){1, 0, 0}, sizeof(double[3]));
  memcpy(positions + 9, (double[]){0, 0, 2}, sizeof(double[3])); /* nor has a straight p2-p3-p4 */
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  CHECK_FAILURE(tree, ctInvalidArgument, "0, 1, 2 and 3", ctGetTorsionAngle(tree, 1, &angle));
  CHECK_FAILURE(tree, ctInvalidArgument, "link 0", ctGetTorsionAngle(tree, 0, &angle));
  CHECK_FAILURE(tree, ctInvalidArgument, "link 2", ctGetTorsionAngle(tree, 2, &angle));
  CHECK_FAILURE(tree, ctInvalidArgument, "link -1", ctGetTorsionAngle(tree, -1, &angle));
  ctDestroy(tree);
}

/* There is no axis between two particles at one place. */
static void testNoAxis(void) {
  ctChainTree* tree = makeDihedral(0.5, false);
  double positions[15];
  ctGetPositions(tree, positions);
  memcpy(positions + 6, positions + 3, sizeof(double[3]));
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  const ctChange change = {.link = 1, .angle = 0.1};
  CHECK_FAILURE(tree, ctInvalidArgument, "particles 1 and 2", ctPropose(tree, 1, &change));
  CHECK(!ctHasTrial(tree));
  ctDestroy(tree);
}

int main(void) {
  testSign();
  testRange();
  testNewReference();
  testIndependence();
  testCollinear();
  testNoAxis();
  return checkResult();
}
