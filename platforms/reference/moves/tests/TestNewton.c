/* Closing a window by Newton's method: the tail is where it was, in long double; the way back leads back; the Jacobian
 * is that of numerical derivatives; what is no window is refused. */
#include <float.h>

#include "randomwindow.h"

#define DEGREE (PI / 180)

/* Lever arms of a protein of 500 residues. */
#define LEVER 10.0

static void testCloses(int kind, double most, double leastShare, double gapAllowed) {
  const int trials = 4000;
  int closed = 0;
  int returned = 0;
  for (int n = 0; n < trials; n++) {
    ctWindow window, turned;
    if (kind == 0) {
      drawProteinWindow(&window, 2 + n % 3, 1);
    } else {
      drawArbitraryWindow(&window, n % 4);
    }
    double angles[CT_WINDOW_MOST], back[CT_WINDOW_MOST];
    drawDrivers(&window, most, angles);
    double drivers[CT_WINDOW_MOST];
    memcpy(drivers, angles, sizeof angles);
    if (!ctCloseNear(&window, angles)) {
      continue;
    }
    closed++;
    bool isPivot[CT_WINDOW_MOST] = {false};
    for (int k = 0; k < CT_PIVOTS; k++) {
      isPivot[window.pivots[k]] = true;
      CHECK(fabs(angles[window.pivots[k]]) <= PI);
    }
    for (int i = 0; i < window.count; i++) {
      CHECK(isPivot[i] || angles[i] == drivers[i]);
      back[i] = isPivot[i] ? 0 : -angles[i];
    }
    ctTurnWindow(&window, angles, &turned);
    /* Near a singularity, rounding of the window itself has long levers. */
    const double singular = exp(ctComputeLogJacobian(&turned));
    CHECK(gapOf(&window, angles, LEVER) < gapAllowed || singular < 1e-5);
    if (ctCloseNear(&turned, back)) {
      double most2 = 0;
      for (int i = 0; i < window.count; i++) {
        most2 = fmax(most2, fabs(back[i] + angles[i]));
      }
      returned += most2 < 1e-7 ? 1 : 0;
    }
  }
  printf("closed %.3f, returned %.3f of them\n", closed / (double)trials, returned / (double)closed);
  CHECK(closed > leastShare * trials);
  CHECK(returned > 0.9 * closed);
}

/* With no driver turned, nothing turns. */
static void testStays(void) {
  for (int n = 0; n < 1000; n++) {
    ctWindow window;
    double angles[CT_WINDOW_MOST] = {0};
    drawProteinWindow(&window, 2, 1);
    if (exp(ctComputeLogJacobian(&window)) < 1e-6) {
      continue;
    }
    CHECK(ctCloseNear(&window, angles));
    for (int i = 0; i < window.count; i++) {
      CHECK_NEAR(angles[i], 0, 1e-9);
    }
  }
}

/* The tail's motion as rotation vector and translation, of small turns. */
static void motionOf(const ctWindow* window, const double* angles, Real motion[6]) {
  Real x[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  for (int k = 0; k < 4; k++) {
    for (int i = window->count - 1; i >= 0; i--) {
      turnPointReal(window->points[i], window->axes[i], angles[i], x[k]);
    }
  }
  motion[0] = ((x[1][2] - x[3][2]) - (x[2][1] - x[3][1])) / 2;
  motion[1] = ((x[2][0] - x[3][0]) - (x[0][2] - x[3][2])) / 2;
  motion[2] = ((x[0][1] - x[3][1]) - (x[1][0] - x[3][0])) / 2;
  memcpy(motion + 3, x[3], sizeof x[3]);
}

static Real determinantOf(Real m[6][6]) {
  Real product = 1;
  for (int i = 0; i < 6; i++) {
    int best = i;
    for (int r = i + 1; r < 6; r++) {
      best = fabsl(m[r][i]) > fabsl(m[best][i]) ? r : best;
    }
    for (int c = 0; c < 6; c++) {
      const Real swapped = m[i][c];
      m[i][c] = m[best][c];
      m[best][c] = swapped;
    }
    product *= m[i][i];
    for (int r = i + 1; r < 6; r++) {
      const Real factor = m[r][i] / m[i][i];
      for (int c = i; c < 6; c++) {
        m[r][c] -= factor * m[i][c];
      }
    }
  }
  return fabsl(product);
}

static void testJacobian(void) {
  const double h = 0x1p-12;
  for (int n = 0; n < 500; n++) {
    ctWindow window;
    if (n % 2) {
      drawProteinWindow(&window, n % 5, 1);
    } else {
      drawArbitraryWindow(&window, n % 5);
    }
    Real m[6][6];
    for (int k = 0; k < CT_PIVOTS; k++) {
      double angles[CT_WINDOW_MOST] = {0};
      Real ahead[6], behind[6];
      angles[window.pivots[k]] = h;
      motionOf(&window, angles, ahead);
      angles[window.pivots[k]] = -h;
      motionOf(&window, angles, behind);
      for (int i = 0; i < 6; i++) {
        m[k][i] = (ahead[i] - behind[i]) / (2 * h);
      }
    }
    const double expected = (double)determinantOf(m);
    CHECK_NEAR(exp(ctComputeLogJacobian(&window)), expected, 1e-6 * expected + 1e-10);
  }
}

/* Axes after turns, one after the other from the last. */
static void testTurnsWindow(void) {
  for (int n = 0; n < 200; n++) {
    ctWindow window, turned;
    drawArbitraryWindow(&window, n % 11);
    double angles[CT_WINDOW_MOST];
    for (int i = 0; i < window.count; i++) {
      angles[i] = uniform(-4, 4);
    }
    ctTurnWindow(&window, angles, &turned);
    CHECK(turned.count == window.count && !memcmp(turned.pivots, window.pivots, sizeof window.pivots));
    for (int i = 0; i < window.count; i++) {
      const double* p = window.points[i];
      const double* u = window.axes[i];
      Real point[3] = {p[0], p[1], p[2]};
      Real end[3] = {(Real)p[0] + u[0], (Real)p[1] + u[1], (Real)p[2] + u[2]};
      for (int j = i - 1; j >= 0; j--) {
        turnPointReal(window.points[j], window.axes[j], angles[j], point);
        turnPointReal(window.points[j], window.axes[j], angles[j], end);
      }
      for (int k = 0; k < 3; k++) {
        CHECK_NEAR(turned.points[i][k], (double)point[k], 1e-14);
        CHECK_NEAR(turned.axes[i][k], (double)(end[k] - point[k]), 1e-14);
      }
    }
    /* The window may be turned in place. */
    ctWindow same = window;
    ctTurnWindow(&same, angles, &same);
    CHECK(!memcmp(same.points, turned.points, (size_t)same.count * sizeof same.points[0]));
    CHECK(!memcmp(same.axes, turned.axes, (size_t)same.count * sizeof same.axes[0]));
  }
}

static void checkRefused(const ctWindow* window) {
  double angles[CT_WINDOW_MOST] = {0};
  CHECK(!ctCloseNear(window, angles));
}

static void testRefuses(void) {
  ctWindow good, bad;
  drawProteinWindow(&good, 2, 1);
  double angles[CT_WINDOW_MOST] = {0};
  CHECK(ctCloseNear(&good, angles));
  for (int corner = 0; corner < 3; corner++) {
    /* Parallel axes in a point. */
    bad = good;
    memcpy(bad.axes[bad.pivots[2 * corner + 1]], bad.axes[bad.pivots[2 * corner]], sizeof bad.axes[0]);
    checkRefused(&bad);
    /* Two of the points are one; the three lie on a line. */
    for (int k = 0; k < 2; k++) {
      bad = good;
      const double* p = bad.points[bad.pivots[(2 * corner + 2) % 6]];
      const double* q = bad.points[bad.pivots[(2 * corner + 4) % 6]];
      for (int i = 0; i < 3; i++) {
        const double middle = k == 0 ? p[i] : 0.5 * (p[i] + q[i]);
        bad.points[bad.pivots[2 * corner]][i] = middle;
        bad.points[bad.pivots[2 * corner + 1]][i] = middle;
      }
      checkRefused(&bad);
    }
  }
  /* Pivots that are no pairs. */
  bad = good;
  bad.pivots[1]++;
  checkRefused(&bad);
  bad = good;
  bad.pivots[5] = bad.count;
  checkRefused(&bad);
  bad = good;
  bad.count = CT_WINDOW_MOST + 1;
  checkRefused(&bad);
  bad = good;
  bad.points[bad.pivots[2]][0] = NAN;
  checkRefused(&bad);
  bad = good;
  bad.axes[bad.pivots[2]][0] = INFINITY;
  checkRefused(&bad);
  /* Points that drivers take out of reach: no closure, no angle that is not a number. */
  for (int n = 0; n < 200; n++) {
    drawArbitraryWindow(&bad, 3);
    drawDrivers(&bad, PI, angles);
    if (ctCloseNear(&bad, angles)) {
      for (int i = 0; i < bad.count; i++) {
        CHECK(fabs(angles[i]) <= PI);
      }
    }
  }
}

int main(void) {
  testCloses(0, 2 * DEGREE, 0.8, 2e-13);
  testCloses(0, 12 * DEGREE, 0.6, 2e-13);
  testCloses(1, 10 * DEGREE, 0.5, 1e-11);
  testStays();
  testJacobian();
  testTurnsWindow();
  testRefuses();
  return checkResult();
}
