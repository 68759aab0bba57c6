/* All ways to close a window: none missed and none invented, by brute force in long double; the present state is one of
 * them; there and back; degenerate windows are refused. The long version is examples/validation/closures.py. */
#include "comparison.h"

static void checkComparison(const Comparison* sum) {
  printf("%d windows: %d solutions, %d by brute force, %d missed, %d invented, %d not known, %.2g nm\n", sum->windows,
         sum->solutions, sum->known, sum->missed, sum->invented, sum->doubtful, sum->worstGap);
  CHECK(sum->missed == 0);
  CHECK(sum->invented == 0);
  CHECK(sum->doubtful == 0);
  CHECK(sum->solutions == sum->known);
}

static void testAgainstBruteForce(void) {
  Comparison proteins = {0}, others = {0};
  double angles[CT_WINDOW_MOST];
  ctWindow window;
  for (int n = 0; n < 40; n++) {
    drawProteinWindow(&window, 1 + n % 4, 1);
    drawDrivers(&window, n % 3 * 0.15, angles);
    compareClosures(&window, angles, 400, &proteins);
  }
  checkComparison(&proteins);
  for (int n = 0; n < 40; n++) {
    drawArbitraryWindow(&window, n % 5);
    drawDrivers(&window, n % 3 * 0.3, angles);
    compareClosures(&window, angles, 400, &others);
  }
  checkComparison(&others);
}

/* Of a window as it is, to turn nothing is a way to close it. */
static void testKnowsPresentState(void) {
  int lost = 0;
  int singular = 0; /* nearly */
  const int windows = 4000;
  for (int n = 0; n < windows; n++) {
    ctWindow window;
    if (n % 2) {
      drawProteinWindow(&window, 2, 1);
    } else {
      drawArbitraryWindow(&window, 2);
    }
    const double angles[CT_WINDOW_MOST] = {0};
    double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
    const int count = ctFindClosures(&window, angles, solutions);
    CHECK(count <= CT_CLOSURES_MOST && count % 2 == 0);
    double least = 1;
    for (int i = 0; i < count; i++) {
      least = fmin(least, farthest(solutions[i], angles));
    }
    lost += least > 1e-7 ? 1 : 0;
    singular += ctComputeLogJacobian(&window) < log(1e-3) ? 1 : 0;
  }
  CHECK(lost == 0);
  CHECK(singular > 100);
}

/* Windows that rounding makes difficult: the polynomial in the turn of a piece has two roots that are almost the same,
 * or it is smaller than rounding in one coefficient of an arc that has roots. */
static void testNearRoots(void) {
  const uint64_t proteins[] = {8723287385621352597u, 8839694166876283767u, 12327378728707669711u, 1985938926464924597u};
  const uint64_t others[] = {5299158327871293978u,  1245677412847254615u, 10731169760453925197u, 1264934582216476889u,
                             5961263560821056698u,  2654312196754200459u, 8869858072843282675u,  615133437816013239u,
                             17505898476080015285u, 5564951778258629903u};
  const uint64_t former = chance;
  const int proteinCount = sizeof proteins / sizeof proteins[0];
  const int windows = proteinCount + (int)(sizeof others / sizeof others[0]);
  for (int n = 0; n < windows; n++) {
    ctWindow window;
    if (n < proteinCount) {
      chance = proteins[n];
      drawProteinWindow(&window, 2, 1);
    } else {
      chance = others[n - proteinCount];
      drawArbitraryWindow(&window, 2);
    }
    const double angles[CT_WINDOW_MOST] = {0};
    double solutions[CT_CLOSURES_MOST][CT_PIVOTS], least = 1;
    const int found = ctFindClosures(&window, angles, solutions);
    for (int i = 0; i < found; i++) {
      least = fmin(least, farthest(solutions[i], angles));
    }
    CHECK(least < 1e-7);
    CHECK(found % 2 == 0);
  }
  chance = former;
}

/* From each solution, the solutions of the way back are what the present state has. */
static void testThereAndBack(void) {
  int compared = 0;
  for (int n = 0; n < 100; n++) {
    ctWindow window, turned;
    drawProteinWindow(&window, 3, 1);
    const double none[CT_WINDOW_MOST] = {0};
    double angles[CT_WINDOW_MOST], all[CT_WINDOW_MOST], back[CT_WINDOW_MOST];
    drawDrivers(&window, 0.2, angles);
    double here[CT_CLOSURES_MOST][CT_PIVOTS], there[CT_CLOSURES_MOST][CT_PIVOTS], again[CT_CLOSURES_MOST][CT_PIVOTS];
    const int countHere = ctFindClosures(&window, none, here);
    const int countThere = ctFindClosures(&window, angles, there);
    for (int i = 0; i < countThere; i++) {
      putTurns(&window, angles, there[i], all);
      ctTurnWindow(&window, all, &turned);
      for (int k = 0; k < window.count; k++) {
        back[k] = -angles[k];
      }
      const int countAgain = ctFindClosures(&turned, back, again);
      CHECK(countAgain == countHere);
      for (int j = 0; j < countHere; j++) {
        double least = 1;
        for (int m = 0; m < countAgain; m++) {
          double total[CT_PIVOTS];
          for (int k = 0; k < CT_PIVOTS; k++) {
            total[k] = there[i][k] + again[m][k];
          }
          least = fmin(least, farthest(total, here[j]));
        }
        CHECK(least < 1e-6);
        compared++;
      }
    }
  }
  CHECK(compared > 500);
}

/* Newton's method leads to one of them. */
static void testKnowsNear(void) {
  int compared = 0;
  for (int n = 0; n < 2000; n++) {
    ctWindow window;
    double angles[CT_WINDOW_MOST];
    drawProteinWindow(&window, 3, 1);
    drawDrivers(&window, 0.2, angles);
    double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
    const int count = ctFindClosures(&window, angles, solutions);
    if (ctCloseNear(&window, angles)) {
      double turns[CT_PIVOTS], least = 1;
      for (int k = 0; k < CT_PIVOTS; k++) {
        turns[k] = angles[window.pivots[k]];
      }
      for (int i = 0; i < count; i++) {
        least = fmin(least, farthest(solutions[i], turns));
      }
      CHECK(least < 1e-7);
      compared++;
    }
  }
  CHECK(compared > 1000);
}

static void testRefuses(void) {
  ctWindow good, bad;
  const double none[CT_WINDOW_MOST] = {0};
  double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
  drawProteinWindow(&good, 2, 1);
  CHECK(ctFindClosures(&good, none, solutions) > 0);
  bad = good;
  memcpy(bad.axes[bad.pivots[1]], bad.axes[bad.pivots[0]], sizeof bad.axes[0]);
  CHECK(ctFindClosures(&bad, none, solutions) == 0);
  bad = good;
  memcpy(bad.points[bad.pivots[2]], bad.points[bad.pivots[0]], sizeof bad.points[0]);
  CHECK(ctFindClosures(&bad, none, solutions) == 0);
  bad = good;
  bad.points[bad.pivots[2]][1] = NAN;
  CHECK(ctFindClosures(&bad, none, solutions) == 0);
  /* A piece that is straight: its turn changes nothing, and solutions are no points. */
  bad = good;
  double* axis = bad.axes[bad.pivots[1]];
  double square = 0;
  for (int k = 0; k < 3; k++) {
    axis[k] = bad.points[bad.pivots[2]][k] - bad.points[bad.pivots[0]][k];
    square += axis[k] * axis[k];
  }
  for (int k = 0; k < 3; k++) {
    axis[k] /= sqrt(square);
    bad.axes[bad.pivots[2]][k] = axis[k];
  }
  CHECK(!(ctComputeLogJacobian(&bad) > -20));
  const int count = ctFindClosures(&bad, none, solutions);
  CHECK(count >= 0 && count <= CT_CLOSURES_MOST);
}

/* Whatever is given, there are no more solutions than there can be, and they are angles. */
static void testAnyNumbers(void) {
  const double numbers[] = {NAN, INFINITY, 0, 1e200, -1e-200, 5e-324, 1, -1, 1e5};
  for (int n = 0; n < 5000; n++) {
    ctWindow window;
    drawProteinWindow(&window, 2, 1);
    double angles[CT_WINDOW_MOST], solutions[CT_CLOSURES_MOST][CT_PIVOTS];
    drawDrivers(&window, 0.2, angles);
    for (int i = 0; i < 1 + n % 5; i++) {
      const double number = numbers[(int)uniform(0, 9)];
      const int torsion = (int)uniform(0, window.count);
      double* const places[] = {window.axes[torsion], window.points[torsion], &angles[torsion]};
      const int place = (int)uniform(0, 3);
      places[place][place < 2 ? (int)uniform(0, 3) : 0] = number;
    }
    const int count = ctFindClosures(&window, angles, solutions);
    CHECK(count >= 0 && count <= CT_CLOSURES_MOST);
    for (int i = 0; i < count; i++) {
      for (int k = 0; k < CT_PIVOTS; k++) {
        CHECK(fabs(solutions[i][k]) <= PI);
      }
    }
    if (ctCloseNear(&window, angles)) {
      for (int k = 0; k < CT_PIVOTS; k++) {
        CHECK(fabs(angles[window.pivots[k]]) <= PI);
      }
    }
  }
}

int main(void) {
  testAgainstBruteForce();
  testKnowsPresentState();
  testNearRoots();
  testThereAndBack();
  testKnowsNear();
  testRefuses();
  testAnyNumbers();
  return checkResult();
}
