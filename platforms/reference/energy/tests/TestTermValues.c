/* Values that are known in closed form, geometry without a value, and sets that have to be refused. */
#include "smallterms.h"

static SmallScene scene;

static void place(int particle, double x, double y, double z) {
  scene.positions[3 * particle] = x;
  scene.positions[3 * particle + 1] = y;
  scene.positions[3 * particle + 2] = z;
}

/* Particles 0 to 3, or 4 to 7, with a dihedral: seen along the axis, the last is that far clockwise from the first. */
static void placeDihedral(int first, double angle) {
  place(first, 0.1, 0, 0);
  place(first + 1, 0, 0, 0);
  place(first + 2, 0, 0, 0.2);
  place(first + 3, 0.1 * cos(angle), 0.1 * sin(angle), 0.3);
}

static const int ascending[] = {0, 1, 2, 3, 4, 5, 6, 7};

static ctTermSet makeSet(ctTermKind kind, int particles, int parameterCount, const double* parameters) {
  return (ctTermSet){.kind = kind,
                     .count = 1,
                     .particlesPerTerm = particles,
                     .particles = ascending,
                     .parametersPerTerm = parameterCount,
                     .parameters = parameters};
}

static double valueOf(ctTermKind kind, int particles, int parameterCount, const double* parameters) {
  const ctTermSet set = makeSet(kind, particles, parameterCount, parameters);
  return sumOfSet(&scene, &set);
}

static double torsion(double periodicity, double phase, double k) {
  const double parameters[] = {periodicity, phase, k};
  return valueOf(ctPeriodicTorsionTerm, 4, 3, parameters);
}

static void testTorsions(void) {
  const double bellemans[] = {1, 2, 4, 8, 16, 32};
  for (int step = -12; step <= 12; step++) {
    const double phi = step * PI / 12;
    placeDihedral(0, phi);
    for (int n = 0; n < 40; n++) {
      CHECK_NEAR(torsion(n, 0.3, 5), 5 * (1 + cos(n * phi - 0.3)), 1e-12);
    }
    const double c = -cos(phi);
    CHECK_NEAR(valueOf(ctRyckaertBellemansTerm, 4, 6, bellemans),
               1 + 2 * c + 4 * c * c + 8 * pow(c, 3) + 16 * pow(c, 4) + 32 * pow(c, 5), 1e-12);
  }
  placeDihedral(0, PI); /* trans */
  CHECK_NEAR(valueOf(ctRyckaertBellemansTerm, 4, 6, bellemans), 63, 1e-12);
  placeDihedral(0, PI / 3);
  CHECK_NEAR(torsion(1000000, 0, 1), 1 + cos(1000000 * PI / 3), 1e-8);
}

static void testOthers(void) {
  const double bond[] = {0.1, 1000};
  const double angle[] = {1, 50};
  const double exception[] = {0.25, 0.3, 0.7};
  place(0, 0.3, 0, 0);
  place(1, 0, 0, 0);
  CHECK_NEAR(valueOf(ctHarmonicBondTerm, 2, 2, bond), 500 * 0.2 * 0.2, 1e-12);
  CHECK_NEAR(valueOf(ctExceptionTerm, 2, 3, exception), 138.93545764438198 * 0.25 / 0.3, 1e-12);
  place(0, 0.6, 0, 0);
  CHECK_NEAR(valueOf(ctExceptionTerm, 2, 3, exception),
             4 * 0.7 * (pow(0.5, 12) - pow(0.5, 6)) + 138.93545764438198 * 0.25 / 0.6, 1e-12);
  const double bends[] = {0, 1e-9, 0.5, PI / 2, 3, PI - 1e-9, PI};
  for (int i = 0; i < 7; i++) {
    place(2, 0.2 * cos(bends[i]), 0.2 * sin(bends[i]), 0);
    CHECK_NEAR(valueOf(ctHarmonicAngleTerm, 3, 2, angle), 25 * (bends[i] - 1) * (bends[i] - 1), 1e-12);
  }
}

/* ---- Torsion maps ---- */

/* Patches on whose lower corner the map has the value 100 s + t, and which rise by 1 in u and 10 in v. */
static double mapValue(int size, double first, double second) {
  static double coefficients[16 * 24 * 24];
  for (int s = 0; s < size; s++) {
    for (int t = 0; t < size; t++) {
      double* c = coefficients + 16 * (s + size * t);
      memset(c, 0, 16 * sizeof *c);
      c[0] = 100 * s + t;
      c[4] = 1;
      c[1] = 10;
    }
  }
  const ctTorsionMap map = {size, coefficients};
  const double number = 0;
  ctTermSet set = makeSet(ctTorsionMapTerm, 8, 1, &number);
  set.mapCount = 1;
  set.maps = &map;
  placeDihedral(0, first);
  placeDihedral(4, second);
  return sumOfSet(&scene, &set);
}

static void testMaps(void) {
  const double step = 2 * PI / 24;
  CHECK_NEAR(mapValue(24, 3.25 * step, 5.5 * step), 305 + 0.25 + 5, 1e-9);
  CHECK_NEAR(mapValue(24, -0.75 * step, 0.5 * step), 2300 + 0.25 + 5, 1e-9);
  CHECK_NEAR(mapValue(24, 0.5 * step, -PI + 0.5 * step), 12 + 0.5 + 5, 1e-9);
  CHECK_NEAR(mapValue(24, 0.5 * step, PI - 0.5 * step), 11 + 0.5 + 5, 1e-9);
  CHECK_NEAR(mapValue(1, 1.5, -1.5), 1.5 / (2 * PI) + 10 * (1 - 1.5 / (2 * PI)), 1e-9);
  /* At 0, from either side, and by less than the rounding of 2 pi. */
  CHECK_NEAR(mapValue(24, 0, 0), 0, 1e-9);
  CHECK(isfinite(mapValue(24, -1e-300, -1e-17)));
  CHECK(isfinite(mapValue(24, PI, -PI)));
  CHECK(isnan(mapValue(24, NAN, 1)));
  CHECK(isnan(mapValue(24, 1, NAN)));
  CHECK(isnan(mapValue(24, INFINITY, 1)));
}

/* ---- Geometry without a value ---- */

static void testDegenerate(void) {
  const double bond[] = {0.1, 1000};
  const double angle[] = {1, 50};
  const double bellemans[] = {1, 2, 4, 8, 16, 32};
  const double charged[] = {0.25, 0.3, 0.7};
  const double like[] = {0.25, 0.3, 0};
  const double opposite[] = {-0.25, 0.3, 0};
  place(0, 1, 2, 3);
  place(1, 1, 2, 3);
  CHECK_NEAR(valueOf(ctHarmonicBondTerm, 2, 2, bond), 5, 1e-12);
  CHECK(isnan(valueOf(ctHarmonicAngleTerm, 3, 2, angle)));
  CHECK(valueOf(ctExceptionTerm, 2, 3, charged) == INFINITY);
  CHECK(isnan(valueOf(ctExceptionTerm, 2, 3, like))); /* as OpenMM: 0 times infinity */
  CHECK(isnan(valueOf(ctExceptionTerm, 2, 3, opposite)));
  /* Three particles in a line: OpenMM's cosine is 0 then. */
  place(2, 1, 2, 4);
  place(3, 1, 5, 6);
  CHECK_NEAR(torsion(1, 0, 5), 5, 1e-12);
  CHECK_NEAR(torsion(1, PI / 2, 5), 10, 1e-12);
  CHECK_NEAR(torsion(2, 0, 5), 0, 1e-12);
  CHECK_NEAR(valueOf(ctRyckaertBellemansTerm, 4, 6, bellemans), 1, 1e-12);
  place(0, NAN, 0, 0);
  CHECK(isnan(torsion(3, 0, 5)) && isnan(valueOf(ctHarmonicBondTerm, 2, 2, bond)));
  CHECK(isnan(valueOf(ctRyckaertBellemansTerm, 4, 6, bellemans)));
  CHECK(isnan(valueOf(ctHarmonicAngleTerm, 3, 2, angle)) && isnan(valueOf(ctExceptionTerm, 2, 3, charged)));
}

/* A trial of particle 1 of an exception, along x; the change that is found. */
static double moveSecond(Terms* terms, double shift) {
  const ctPiece pieces[] = {{0, 0}, {1, 1}};
  const ctTransform motions[] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}},
                                 {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {shift, 0, 0}}};
  const int links[] = {1};
  const TrialView view = {.state = smallLeaf(&scene),
                          .pieceCount = 2,
                          .pieces = pieces,
                          .motions = motions,
                          .linkCount = 1,
                          .links = links};
  return ctTermsChange(terms, &view);
}

/* Particles that lie on each other before the trial, in it, or both. */
static void testInfiniteChanges(void) {
  const double parameters[] = {0.5, 0.3, 1};
  const double near = CT_COULOMB * 0.5 / 0.3;
  const double far = 4 * (pow(0.5, 12) - pow(0.5, 6)) + CT_COULOMB * 0.5 / 0.6;
  const ctTermSet set = makeSet(ctExceptionTerm, 2, 3, parameters);
  char text[200] = "";
  Terms* terms;
  scene.joints[1] = ctFreeJoint;
  CHECK_SUCCESS(ctTermsCreate(&scene.definition, 1, &set, scene.slotOf, &terms, text, sizeof text));
  place(0, 0, 0, 0);
  place(1, 0, 0, 0);
  ctTermsRefresh(terms, NULL, smallLeaf(&scene));
  CHECK(moveSecond(terms, 0) == 0); /* infinite as before */
  CHECK(moveSecond(terms, 0.3) == -INFINITY);
  ctTermsAccept(terms);
  CHECK_NEAR(ctTermsSum(terms, 0), near, 1e-12);
  place(1, 0.3, 0, 0);
  CHECK(moveSecond(terms, -0.3) == INFINITY);
  CHECK(isnan(moveSecond(terms, NAN)));
  CHECK_NEAR(moveSecond(terms, 0.3), far - near, 1e-12);
  CHECK_NEAR(ctTermsSum(terms, 0), near, 1e-12);
  ctTermsDestroy(terms);
  scene.joints[1] = ctTorsionJoint;
}

/* ---- Sets that have to be refused ---- */

static void testRefusals(void) {
  const int far[] = {0, 1, 2, 8};
  const int negative[] = {0, -1, 2, 3};
  const int three[] = {0, 1, 2, 3};
  const double good[] = {2, 0, 1};
  const double half[] = {1.5, 0, 1};
  const double below[] = {-1, 0, 1};
  const double none[] = {NAN, 0, 1};
  const double huge[] = {1e10, 0, 1};
  const double coefficients[16] = {0};
  const ctTorsionMap map = {1, coefficients};
  const ctTorsionMap empty = {0, coefficients};
  const ctTermSet right = makeSet(ctPeriodicTorsionTerm, 4, 3, good);
  ctTermSet sets[] = {right, right};
  sets[1].particles = far;
  checkRefused(&scene, 2, sets, "term 0 of term set 1 names particle 8; there are 8 particles");
  sets[1].particles = negative;
  checkRefused(&scene, 2, sets, "particle -1");
  sets[1] = right;
  sets[1].parameters = half;
  checkRefused(&scene, 2, sets, "term 0 of term set 1 has the periodicity 1.5");
  sets[1].parameters = below;
  checkRefused(&scene, 2, sets, "periodicity -1");
  sets[1].parameters = none;
  checkRefused(&scene, 2, sets, "periodicity nan");
  sets[1].parameters = huge;
  checkRefused(&scene, 2, sets, "periodicity 1e+10");
  sets[1] = right;
  sets[1].particlesPerTerm = 3;
  checkRefused(&scene, 2, sets, "term set 1 (periodic torsions) has 3 particles a term; it needs 4");
  sets[1] = right;
  sets[1].parametersPerTerm = 2;
  checkRefused(&scene, 2, sets, "2 parameters a term; it needs 3");
  sets[1] = right;
  sets[1].count = -1;
  checkRefused(&scene, 2, sets, "negative count: -1 terms");
  sets[1].kind = (ctTermKind)(ctCentroidTerm + 1);
  checkRefused(&scene, 2, sets, "unknown kind 8");
  sets[1].kind = (ctTermKind)-1;
  checkRefused(&scene, 2, sets, "unknown kind -1");
  checkRefused(&scene, -1, sets, "there are -1 term sets");
  sets[0] = makeSet(ctTorsionMapTerm, 8, 1, good);
  sets[0].mapCount = 1;
  sets[0].maps = &map;
  checkRefused(&scene, 1, sets, "term 0 of term set 0 has map 2; there are 1 maps");
  sets[0].parameters = none;
  checkRefused(&scene, 1, sets, "map nan");
  sets[0].parameters = below;
  checkRefused(&scene, 1, sets, "map -1");
  sets[0].maps = &empty;
  checkRefused(&scene, 1, sets, "map 0 of term set 0 has size 0");
  SmallScene bare;
  makeSmallScene(&bare, 2);
  sets[0] = right;
  sets[0].particles = three;
  checkRefused(&bare, 1, sets, "term 0 of term set 0 names particle 2, which is not listed");
}

/* No sets, and sets without terms, are none. */
static void testNothing(void) {
  const ctTermSet sets[] = {{.kind = ctHarmonicBondTerm, .particlesPerTerm = 2, .parametersPerTerm = 2},
                            {.kind = ctTorsionMapTerm, .particlesPerTerm = 8, .parametersPerTerm = 1}};
  char text[200] = "";
  Terms* terms;
  for (int count = 0; count <= 2; count++) {
    CHECK_SUCCESS(ctTermsCreate(&scene.definition, count, sets, scene.slotOf, &terms, text, sizeof text));
    ctTermsRefresh(terms, NULL, smallLeaf(&scene));
    CHECK(moveSecond(terms, 1) == 0);
    ctTermsAccept(terms);
    for (int s = 0; s < count; s++) {
      CHECK(ctTermsSum(terms, s) == 0 && ctTermsCountChangeable(terms, s) == 0);
    }
    ctTermsDestroy(terms);
  }
  ctTermsDestroy(NULL);
}

int main(void) {
  makeSmallScene(&scene, CT_NULL);
  testTorsions();
  testOthers();
  testMaps();
  testDegenerate();
  testInfiniteChanges();
  testRefusals();
  testNothing();
  return checkResult();
}
