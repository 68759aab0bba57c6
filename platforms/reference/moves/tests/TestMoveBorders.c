/* Each argument of each call of the library of moves at each value that it must not have: what comes back is what the
 * headers say, and what comes of right arguments afterwards has the same bits as before. */
#include "../../chaintree/tests/borders.h"
#include "../../chaintree/tests/check.h"
#include "ctclosure.h"
#include "ctdensity.h"
#include "ctlocal.h"
#include "ctvelocities.h"
#include "randomwindow.h"

static const double extremes[] = {NAN, INFINITY, -INFINITY, 1.7e308, -1.7e308, 1e160, 1e80, 1e-160, 5e-324, 0, -0.0};
static const int wrongInts[] = {INT_MIN, INT_MIN + 1, -2, -1, INT_MAX - 1, INT_MAX};

/* ---- Closures ---- */

typedef struct Closures {
  ctWindow turned;
  double logJacobian;
  double angles[CT_WINDOW_MOST];
  double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
  int count;
  bool isClosed;
} Closures;

static const double turns[CT_WINDOW_MOST] = {0, 0.01, 0, -0.02};

static void askClosures(const ctWindow* window, Closures* c) {
  memset(c, 0, sizeof *c);
  memcpy(c->angles, turns, sizeof turns);
  ctTurnWindow(window, turns, &c->turned);
  c->logJacobian = ctComputeLogJacobian(window);
  c->isClosed = ctCloseNear(window, c->angles);
  c->count = ctFindClosures(window, turns, c->solutions);
  callCount += 4;
}

static ctWindow right;
static Closures before;

static void checkRight(int line) {
  Closures now;
  askClosures(&right, &now);
  if (memcmp(&now, &before, sizeof now) != 0) {
    reportFailure("line %d: the window closes otherwise than before\n", line);
  }
}

/* A window with torsions out of order. */
static void checkNoWindow(int line, const ctWindow* window) {
  Closures c;
  askClosures(window, &c);
  if (c.isClosed || c.count != 0 || !isnan(c.logJacobian) || memcmp(c.angles, turns, sizeof turns) != 0) {
    reportFailure("line %d: a window that is none was closed\n", line);
  }
  checkRight(line);
}

static void testWindows(void) {
  ctWindow w;
  const int noCounts[] = {INT_MIN, -1, 0, CT_PIVOTS - 1, CT_WINDOW_MOST + 1, 1000, INT_MAX};
  for (EACH(i, noCounts)) {
    w = right;
    w.count = noCounts[i];
    checkNoWindow(__LINE__, &w);
  }
  for (EACH(i, wrongInts)) {
    for (int k = 0; k < CT_PIVOTS; k++) {
      w = right;
      w.pivots[k] = wrongInts[i];
      checkNoWindow(__LINE__, &w);
      if (k % 2 == 0) {
        w.pivots[k + 1] = wrongInts[i] == INT_MAX ? INT_MIN : wrongInts[i] + 1;
        checkNoWindow(__LINE__, &w);
      }
      w = right;
      w.pivots[k] = w.count;
      checkNoWindow(__LINE__, &w);
    }
    for (int k = 0; k < CT_PIVOTS; k++) {
      w.pivots[k] = wrongInts[i];
    }
    checkNoWindow(__LINE__, &w);
  }
  double angles[CT_WINDOW_MOST] = {0};
  double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
  CHECK(!ctCloseNear(NULL, angles) && !ctCloseNear(&right, NULL) && isnan(ctComputeLogJacobian(NULL)));
  CHECK(ctFindClosures(NULL, angles, solutions) == 0 && ctFindClosures(&right, NULL, solutions) == 0);
  CHECK(ctFindClosures(&right, angles, NULL) == 0);
  ctTurnWindow(NULL, angles, &w);
  ctTurnWindow(&right, NULL, &w);
  ctTurnWindow(&right, angles, NULL);
  checkRight(__LINE__);
}

/* Numbers of any size, one, two or many at a time, end in no time and write nowhere else. */
static void testNumbers(void) {
  const int numbers = CT_WINDOW_MOST * 3;
  uint32_t random = 1;
  for (int n = 0; n < 4000; n++) {
    ctWindow w = right;
    Closures c;
    const int changes = n % 3 == 2 ? 20 : 1 + n % 3;
    for (int i = 0; i < changes; i++) {
      random = random * 1664525u + 1013904223u;
      const int at = (int)(random >> 8) % numbers;
      double* array = (random >> 7 & 1) != 0 ? &w.points[0][0] : &w.axes[0][0];
      array[at] = extremes[(random >> 16) % (sizeof extremes / sizeof extremes[0])];
    }
    askClosures(&w, &c);
    CHECK(c.count >= 0 && c.count <= CT_CLOSURES_MOST);
    for (int i = 0; i < c.count; i++) {
      for (int k = 0; k < CT_PIVOTS; k++) {
        CHECK(fabs(c.solutions[i][k]) <= PI);
      }
    }
  }
  checkRight(__LINE__);
}

static void testAngles(void) {
  double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
  for (EACH(i, extremes)) {
    for (int k = 0; k < right.count; k++) {
      ctWindow w;
      double angles[CT_WINDOW_MOST] = {0};
      angles[k] = extremes[i];
      ctTurnWindow(&right, angles, &w);
      const int count = ctFindClosures(&right, angles, solutions);
      CHECK(count >= 0 && count <= CT_CLOSURES_MOST);
      ctCloseNear(&right, angles);
      callCount += 3;
    }
  }
  checkRight(__LINE__);
}

/* ---- Densities ---- */

static void testTables(void) {
  const int bins[CT_DENSITY_MOST + 1] = {2, 3, 1, 1, 1, 1, 1, 1, 1};
  const double values[6] = {1, 2, 0, 3, 4, 5};
  ctDensity* sound = ctCreateTable(2, bins, values, 0.1);
  const double angles[2] = {0.5, 1};
  const double density = ctGetDensity(sound, angles);
  CHECK(density > 0);
  CHECK(ctCreateTable(2, NULL, values, 0.1) == NULL && ctCreateTable(2, bins, NULL, 0.1) == NULL);
  const int noCounts[] = {INT_MIN, -1, 0, CT_DENSITY_MOST + 1, INT_MAX};
  for (EACH(i, noCounts)) {
    CHECK(ctCreateTable(noCounts[i], bins, values, 0.1) == NULL);
  }
  const int wrongBins[] = {INT_MIN, -1, 0, CT_BINS_MOST, INT_MAX, 1 << 30};
  for (EACH(i, wrongBins)) {
    for (int k = 0; k < 2; k++) {
      int wrong[2] = {2, 3};
      wrong[k] = wrongBins[i];
      CHECK(ctCreateTable(2, wrong, values, 0.1) == NULL);
    }
  }
  const int huge[CT_DENSITY_MOST] = {1 << 16, 1 << 16, 1 << 16, 1 << 16, 1 << 16, 1 << 16, 1 << 16, 1 << 16};
  CHECK(ctCreateTable(CT_DENSITY_MOST, huge, values, 0.1) == NULL); /* a product that no integer holds */
  CHECK(ctCreateTable(2, huge, values, 0.1) == NULL);
  const double wrongValues[] = {NAN, INFINITY, -INFINITY, -1, -5e-324};
  for (EACH(i, wrongValues)) {
    for (int k = 0; k < 6; k++) {
      double wrong[6];
      memcpy(wrong, values, sizeof wrong);
      wrong[k] = wrongValues[i];
      CHECK(ctCreateTable(2, bins, wrong, 0.1) == NULL);
    }
    CHECK(ctCreateTable(2, bins, values, wrongValues[i]) == NULL);
  }
  const double none[6] = {0};
  const double beyond[6] = {1.7e308, 1.7e308, 0, 0, 0, 0};
  CHECK(ctCreateTable(2, bins, none, 0.1) == NULL && ctCreateTable(2, bins, beyond, 0.1) == NULL);
  CHECK(ctCreateTable(2, bins, values, 1.1) == NULL);
  CHECK(ctGetDensity(sound, angles) == density);
  ctDestroyDensity(sound);
  callCount += 80;
}

static void testRotamers(void) {
  const double weights[3] = {1, 0, 2};
  const double means[6] = {0, 1, 2, 3, -1, -2};
  const double widths[6] = {0.1, 0.2, 0.3, 0.1, 0.2, PI};
  ctDensity* sound = ctCreateRotamers(2, 3, weights, means, widths, 0.1);
  const double angles[2] = {0.5, 1};
  const double density = ctGetDensity(sound, angles);
  CHECK(density > 0);
  CHECK(ctCreateRotamers(2, 3, NULL, means, widths, 0.1) == NULL);
  CHECK(ctCreateRotamers(2, 3, weights, NULL, widths, 0.1) == NULL);
  CHECK(ctCreateRotamers(2, 3, weights, means, NULL, 0.1) == NULL);
  const int noCounts[] = {INT_MIN, -1, 0, CT_DENSITY_MOST + 1, INT_MAX};
  for (EACH(i, noCounts)) {
    CHECK(ctCreateRotamers(noCounts[i], 3, weights, means, widths, 0.1) == NULL);
    const bool isCount = noCounts[i] == CT_DENSITY_MOST + 1;
    CHECK(isCount || ctCreateRotamers(2, noCounts[i], weights, means, widths, 0.1) == NULL);
  }
  const double wrongNumbers[] = {NAN, INFINITY, -INFINITY, -1.1 * CT_MOST_ANGLE, 1e300};
  for (EACH(i, wrongNumbers)) {
    for (int k = 0; k < 6; k++) {
      double wrong[6];
      memcpy(wrong, means, sizeof wrong);
      wrong[k] = wrongNumbers[i];
      CHECK(ctCreateRotamers(2, 3, weights, wrong, widths, 0.1) == NULL);
      memcpy(wrong, widths, sizeof wrong);
      wrong[k] = wrongNumbers[i];
      CHECK(ctCreateRotamers(2, 3, weights, means, wrong, 0.1) == NULL);
      wrong[k] = 0;
      CHECK(ctCreateRotamers(2, 3, weights, means, wrong, 0.1) == NULL);
      wrong[k] = 5e-324;
      CHECK(ctCreateRotamers(2, 3, weights, means, wrong, 0.1) == NULL);
    }
    CHECK(ctCreateRotamers(2, 3, weights, means, widths, wrongNumbers[i]) == NULL);
    double wrong[3] = {1, wrongNumbers[i], 2};
    if (wrongNumbers[i] != 1e300) {
      CHECK(ctCreateRotamers(2, 3, wrong, means, widths, 0.1) == NULL);
    }
  }
  const double none[3] = {0};
  CHECK(ctCreateRotamers(2, 3, none, means, widths, 0.1) == NULL);
  CHECK(ctGetDensity(sound, angles) == density);
  ctDestroyDensity(sound);
  callCount += 150;
}

/* Numbers that are no uniform ones, and angles that are none. */
static void testDraws(void) {
  const int bins[2] = {5, 7};
  double values[35];
  for (int i = 0; i < 35; i++) {
    values[i] = i % 4;
  }
  const double means[6] = {0, 1, 2, 3, -1, -2};
  const double widths[6] = {0.1, 0.2, 0.3, 0.1, 0.2, PI};
  ctDensity* densities[2] = {ctCreateTable(2, bins, values, 0.1),
                             ctCreateRotamers(2, 3, values + 1, means, widths, 0.1)};
  CHECK(ctCountUniforms(NULL) == 0 && ctCountUniforms(densities[0]) == 3 && ctCountUniforms(densities[1]) == 9);
  for (int d = 0; d < 2; d++) {
    double uniforms[CT_UNIFORMS_MOST];
    double angles[2] = {0, 0};
    for (EACH(i, extremes)) {
      for (int k = 0; k < ctCountUniforms(densities[d]); k++) {
        for (int n = 0; n < CT_UNIFORMS_MOST; n++) {
          uniforms[n] = 0.3;
        }
        uniforms[k] = extremes[i];
        ctDrawAngles(densities[d], uniforms, angles);
        ctGetDensity(densities[d], angles);
      }
      for (int k = 0; k < 2; k++) {
        angles[0] = angles[1] = 0.5;
        angles[k] = extremes[i];
        ctGetDensity(densities[d], angles);
      }
      callCount += 20;
    }
    ctDrawAngles(NULL, uniforms, angles);
    ctDrawAngles(densities[d], NULL, angles);
    ctDrawAngles(densities[d], uniforms, NULL);
    CHECK(isnan(ctGetDensity(NULL, angles)) && isnan(ctGetDensity(densities[d], NULL)));
    ctDestroyDensity(densities[d]);
  }
  ctDestroyDensity(NULL);
}

/* ---- Local steps ---- */

static ctLocalWindow localWindow(void) {
  ctLocalWindow w = {.count = 5};
  for (int i = 0; i < 5; i++) {
    w.points[i][0] = 0.1 * i;
    w.points[i][1] = 0.1 * (i % 2);
    w.axes[i][i % 3] = 1;
  }
  for (int k = 0; k < CT_LOCAL_ENDS; k++) {
    w.ends[k][0] = 0.6;
    w.ends[k][k] += 0.1;
  }
  return w;
}

static void testLocalSteps(void) {
  const ctLocalWindow sound = localWindow();
  ctLocalWindow w = sound;
  ctLocalWindow turned = sound;
  ctLocalSteps steps;
  ctLocalSteps soundSteps;
  double x[CT_LOCAL_MOST] = {0.1, 0.2};
  double y[CT_LOCAL_MOST] = {0};
  memset(&soundSteps, 0, sizeof soundSteps);
  CHECK(ctFindLocalSteps(&sound, 0.1, 300, &soundSteps));
  CHECK(!ctFindLocalSteps(NULL, 0.1, 300, &steps) && steps.count == 0 && !ctFindLocalSteps(&sound, 0.1, 300, NULL));
  const int noCounts[] = {INT_MIN, -1, 0, CT_LOCAL_MOST + 1, 1000000, INT_MAX};
  for (EACH(i, noCounts)) {
    w.count = noCounts[i];
    CHECK(!ctFindLocalSteps(&w, 0.1, 300, &steps) && steps.count == 0);
    ctTurnLocalWindow(&w, x, &turned);
    CHECK(memcmp(&turned, &sound, sizeof turned) == 0);
    steps = soundSteps;
    steps.count = noCounts[i];
    ctDrawLocalStep(&steps, x, y);
    CHECK(y[0] == 0 && isnan(ctComputeLocalLogDensity(&steps, x)));
  }
  const double wrongSigmas[] = {NAN, INFINITY, -INFINITY, -1, 0, -0.0};
  for (EACH(i, wrongSigmas)) {
    CHECK(!ctFindLocalSteps(&sound, wrongSigmas[i], 300, &steps));
  }
  const double wrongStiffnesses[] = {NAN, INFINITY, -INFINITY, -1, -5e-324};
  for (EACH(i, wrongStiffnesses)) {
    CHECK(!ctFindLocalSteps(&sound, 0.1, wrongStiffnesses[i], &steps));
  }
  for (EACH(i, extremes)) {
    for (int k = 0; k < 5 * 3; k++) {
      for (int which = 0; which < 3; which++) {
        w = sound;
        double* arrays[] = {&w.points[0][0], &w.axes[0][0], &w.ends[0][0]};
        arrays[which][which == 2 ? k % 9 : k] = extremes[i];
        const bool isFound = ctFindLocalSteps(&w, 0.1, 300, &steps);
        CHECK(!isFound || isfinite(extremes[i]));
        ctTurnLocalWindow(&w, x, &turned);
        callCount += 2;
      }
    }
  }
  ctDrawLocalStep(NULL, x, y);
  ctDrawLocalStep(&soundSteps, NULL, y);
  ctDrawLocalStep(&soundSteps, x, NULL);
  CHECK(isnan(ctComputeLocalLogDensity(NULL, x)) && isnan(ctComputeLocalLogDensity(&soundSteps, NULL)));
  ctTurnLocalWindow(NULL, x, &turned);
  ctTurnLocalWindow(&sound, NULL, &turned);
  ctTurnLocalWindow(&sound, x, NULL);
  memset(&steps, 0, sizeof steps);
  CHECK(ctFindLocalSteps(&sound, 0.1, 300, &steps) && memcmp(&steps, &soundSteps, sizeof steps) == 0);
}

/* ---- Velocities ---- */

static void testVelocities(void) {
  const double before[2][9] = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  double turns[2][9] = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, -1, 0, 1, 0, 0, 0, 0, 1}};
  const int bodies[3] = {0, 1, 1};
  const double masses[3] = {1, 2, 0};
  const double sound[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  double v[9];
  memcpy(v, sound, sizeof v);
  CHECK(!ctFindTurns(2, NULL, turns) && !ctFindTurns(2, before, NULL));
  CHECK(!ctFindTurns(INT_MIN, before, turns) && !ctFindTurns(0, NULL, NULL));
  ctTurnVelocities(3, NULL, (const double(*)[9])turns, v);
  ctTurnVelocities(3, bodies, NULL, v);
  ctTurnVelocities(3, bodies, (const double(*)[9])turns, NULL);
  ctTurnVelocities(INT_MIN, bodies, (const double(*)[9])turns, v);
  ctTurnVelocitiesKeepingMomentum(3, NULL, (const double(*)[9])turns, masses, v);
  ctTurnVelocitiesKeepingMomentum(3, bodies, NULL, masses, v);
  ctTurnVelocitiesKeepingMomentum(3, bodies, (const double(*)[9])turns, NULL, v);
  ctTurnVelocitiesKeepingMomentum(3, bodies, (const double(*)[9])turns, masses, NULL);
  ctTurnVelocitiesKeepingMomentum(INT_MIN, bodies, (const double(*)[9])turns, masses, v);
  ctRotateVelocities(3, NULL, sound, &turns[0][0], v);
  ctRotateVelocities(3, masses, NULL, &turns[0][0], v);
  ctRotateVelocities(3, masses, sound, NULL, v);
  ctRotateVelocities(3, masses, sound, &turns[0][0], NULL);
  ctRotateVelocities(INT_MIN, masses, sound, &turns[0][0], v);
  CHECK(memcmp(v, sound, sizeof v) == 0);
  for (EACH(i, extremes)) {
    for (int k = 0; k < 9 + 18 + 3; k++) {
      double wrong[3] = {1, 2, 0};
      double wrongTurns[2][9];
      memcpy(wrongTurns, turns, sizeof turns);
      memcpy(v, sound, sizeof v);
      *(k < 9 ? &v[k] : k < 27 ? &wrongTurns[(k - 9) / 9][(k - 9) % 9] : &wrong[k - 27]) = extremes[i];
      ctTurnVelocitiesKeepingMomentum(3, bodies, (const double(*)[9])wrongTurns, wrong, v);
      ctTurnVelocities(3, bodies, (const double(*)[9])wrongTurns, v);
      ctFindTurns(2, before, wrongTurns);
      callCount += 3;
    }
  }
}

int main(void) {
  drawProteinWindow(&right, 3, 1);
  askClosures(&right, &before);
  CHECK(before.isClosed && before.count > 0 && isfinite(before.logJacobian));
  testWindows();
  testNumbers();
  testAngles();
  testTables();
  testRotamers();
  testDraws();
  testLocalSteps();
  testVelocities();
  printf("%d calls\n", callCount);
  return checkResult();
}
