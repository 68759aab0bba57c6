/* Biased Gaussian steps: what turns do against turns one by one, derivatives against differences, densities against
 * determinants and inverses computed another way, and the draws against their own distribution. */
#include "ctlocal.h"

#include <stdint.h>

#include "../../chaintree/tests/check.h"

static uint64_t chance = 88172645463325252u;

static double draw(void) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return (double)(chance >> 11) * 0x1p-53;
}

static double drawNormal(void) {
  return sqrt(-2 * log(1 - draw())) * cos(2 * PI * draw());
}

/* A random walk of bonds of 0.15 nm, each of which is an axis; the ends are two of them and one more. */
static ctLocalWindow drawWindow(int count) {
  ctLocalWindow window = {.count = count};
  double x[3] = {draw(), draw(), draw()};
  for (int i = 0; i < count + 1; i++) {
    double u[3] = {drawNormal(), drawNormal(), drawNormal()};
    const double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int k = 0; k < 3; k++) {
      if (i < count) {
        window.points[i][k] = x[k];
        window.axes[i][k] = u[k] / length;
      }
      if (i >= count - 1) {
        window.ends[i - count + 1][k] = x[k];
      }
      x[k] += 0.15 * u[k] / length;
    }
  }
  memcpy(window.ends[2], x, sizeof x);
  return window;
}

/* Rodrigues' formula. */
static void turnAbout(const double point[3], const double axis[3], double angle, bool isPoint, double x[3]) {
  double v[3], along = 0;
  for (int k = 0; k < 3; k++) {
    v[k] = x[k] - (isPoint ? point[k] : 0);
    along += axis[k] * v[k];
  }
  for (int k = 0; k < 3; k++) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    x[k] = v[k] * cos(angle) + (axis[l] * v[m] - axis[m] * v[l]) * sin(angle) + axis[k] * along * (1 - cos(angle)) +
           (isPoint ? point[k] : 0);
  }
}

/* Turns one torsion after another, each about its axis as it lies by then. */
static ctLocalWindow turnOneByOne(ctLocalWindow window, const double* changes) {
  for (int i = 0; i < window.count; i++) {
    double* axis = window.axes[i];
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    for (int k = 0; k < 3; k++) {
      axis[k] /= length; /* or errors would grow from turn to turn */
    }
    for (int j = i + 1; j < window.count; j++) {
      turnAbout(window.points[i], window.axes[i], changes[i], true, window.points[j]);
      turnAbout(window.points[i], window.axes[i], changes[i], false, window.axes[j]);
    }
    for (int k = 0; k < CT_LOCAL_ENDS; k++) {
      turnAbout(window.points[i], window.axes[i], changes[i], true, window.ends[k]);
    }
  }
  return window;
}

static void testTurns(void) {
  for (int round = 0; round < 200; round++) {
    const int count = 1 + (int)(CT_LOCAL_MOST * draw());
    const ctLocalWindow window = drawWindow(count);
    double changes[CT_LOCAL_MOST];
    for (int i = 0; i < count; i++) {
      changes[i] = 2 * PI * (draw() - 0.5);
    }
    ctLocalWindow turned;
    ctTurnLocalWindow(&window, changes, &turned);
    const ctLocalWindow expected = turnOneByOne(window, changes);
    for (int k = 0; k < 3; k++) {
      for (int i = 0; i < count; i++) {
        CHECK_NEAR(turned.points[i][k], expected.points[i][k], 1e-13);
        CHECK_NEAR(turned.axes[i][k], expected.axes[i][k], 1e-13);
      }
      for (int j = 0; j < CT_LOCAL_ENDS; j++) {
        CHECK_NEAR(turned.ends[j][k], expected.ends[j][k], 1e-13);
      }
    }
    /* And back. */
    for (int i = 0; i < count; i++) {
      changes[i] = -changes[i];
    }
    ctLocalWindow back;
    ctTurnLocalWindow(&turned, changes, &back);
    CHECK_NEAR(back.ends[2][0], window.ends[2][0], 1e-13);
  }
}

/* A = (I + stiffness G) / sigma^2, with derivatives from differences. */
static void computeBias(const ctLocalWindow* window, double sigma, double stiffness,
                        double a[CT_LOCAL_MOST][CT_LOCAL_MOST]) {
  const double step = 1e-5;
  static double derivatives[CT_LOCAL_MOST][CT_LOCAL_ENDS * 3];
  for (int i = 0; i < window->count; i++) {
    double changes[CT_LOCAL_MOST] = {0};
    changes[i] = step;
    const ctLocalWindow up = turnOneByOne(*window, changes);
    changes[i] = -step;
    const ctLocalWindow down = turnOneByOne(*window, changes);
    for (int k = 0; k < CT_LOCAL_ENDS * 3; k++) {
      derivatives[i][k] = (up.ends[k / 3][k % 3] - down.ends[k / 3][k % 3]) / (2 * step);
    }
  }
  for (int i = 0; i < window->count; i++) {
    for (int j = 0; j < window->count; j++) {
      a[i][j] = i == j ? 1 : 0;
      for (int k = 0; k < CT_LOCAL_ENDS * 3; k++) {
        a[i][j] += stiffness * derivatives[i][k] * derivatives[j][k];
      }
      a[i][j] /= sigma * sigma;
    }
  }
}

/* log det A by Gauss' elimination. */
static double computeLogDeterminant(int count, double a[CT_LOCAL_MOST][CT_LOCAL_MOST]) {
  double logarithm = 0;
  for (int i = 0; i < count; i++) {
    logarithm += log(a[i][i]);
    for (int j = i + 1; j < count; j++) {
      const double f = a[j][i] / a[i][i];
      for (int k = i; k < count; k++) {
        a[j][k] -= f * a[i][k];
      }
    }
  }
  return logarithm;
}

static void testDensity(void) {
  for (int round = 0; round < 200; round++) {
    const int count = 1 + (int)(12 * draw());
    const ctLocalWindow window = drawWindow(count);
    const double sigma = 0.05 + draw(), stiffness = round % 4 == 0 ? 0 : pow(10, 4 * draw());
    ctLocalSteps steps;
    CHECK(ctFindLocalSteps(&window, sigma, stiffness, &steps));
    double changes[CT_LOCAL_MOST];
    static double a[CT_LOCAL_MOST][CT_LOCAL_MOST];
    computeBias(&window, sigma, stiffness, a);
    double form = 0;
    for (int i = 0; i < count; i++) {
      changes[i] = 0.2 * (draw() - 0.5);
    }
    for (int i = 0; i < count; i++) {
      for (int j = 0; j < count; j++) {
        form += changes[i] * a[i][j] * changes[j];
      }
    }
    const double expected = 0.5 * computeLogDeterminant(count, a) - 0.5 * form;
    CHECK_NEAR(ctComputeLocalLogDensity(&steps, changes), expected, 1e-7 * (1 + form));
    /* What is drawn has its own density: d A d is the sum of the squares that it was drawn from. */
    double normals[CT_LOCAL_MOST], squares = 0;
    for (int i = 0; i < count; i++) {
      normals[i] = drawNormal();
      squares += normals[i] * normals[i];
    }
    ctDrawLocalStep(&steps, normals, changes);
    const double none[CT_LOCAL_MOST] = {0};
    const double most = ctComputeLocalLogDensity(&steps, none);
    CHECK_NEAR(ctComputeLocalLogDensity(&steps, changes), most - 0.5 * squares, 1e-9 * (1 + squares));
  }
}

/* The covariance of what is drawn is the inverse of A. */
static void testDraws(void) {
  enum { COUNT = 5, SAMPLES = 100000 };
  const ctLocalWindow window = drawWindow(COUNT);
  ctLocalSteps steps;
  CHECK(ctFindLocalSteps(&window, 0.3, 50, &steps));
  double covariance[COUNT][COUNT] = {{0}};
  for (int sample = 0; sample < SAMPLES; sample++) {
    double normals[COUNT], changes[COUNT];
    for (int i = 0; i < COUNT; i++) {
      normals[i] = drawNormal();
    }
    ctDrawLocalStep(&steps, normals, changes);
    for (int i = 0; i < COUNT; i++) {
      for (int j = 0; j < COUNT; j++) {
        covariance[i][j] += changes[i] * changes[j] / SAMPLES;
      }
    }
  }
  static double a[CT_LOCAL_MOST][CT_LOCAL_MOST];
  computeBias(&window, 0.3, 50, a);
  for (int i = 0; i < COUNT; i++) {
    for (int j = 0; j < COUNT; j++) {
      double product = 0, error = 0;
      for (int k = 0; k < COUNT; k++) {
        product += covariance[i][k] * a[k][j];
        error += 2 * covariance[i][i] * covariance[k][k] * a[k][j] * a[k][j] / SAMPLES;
      }
      CHECK_NEAR(product, i == j ? 1 : 0, 5 * sqrt(error)); /* of 25, by chance in less than one of 10^5 */
    }
  }
}

/* A window of one torsion that shifts an end by r for each radian: 1/sqrt(1 + stiffness r^2). */
static void testOneTorsion(void) {
  ctLocalWindow window = {.count = 1, .points = {{0, 0, 0}}, .axes = {{0, 0, 1}}};
  window.ends[1][2] = 0.1;
  window.ends[2][0] = 0.2;
  ctLocalSteps steps;
  CHECK(ctFindLocalSteps(&window, 0.5, 100, &steps));
  double change;
  ctDrawLocalStep(&steps, (double[]){1}, &change);
  CHECK_NEAR(change, 0.5 / sqrt(5), 1e-15);
}

static void testHopelessNumbers(void) {
  ctLocalWindow window = drawWindow(8);
  ctLocalSteps steps;
  CHECK(ctFindLocalSteps(&window, 0.1, 1e6, &steps));
  CHECK(!ctFindLocalSteps(&window, 0.1, 1e300, &steps));
  CHECK(!ctFindLocalSteps(&window, 0.1, INFINITY, &steps));
  window.axes[3][0] = NAN;
  CHECK(!ctFindLocalSteps(&window, 0.1, 10, &steps));
}

int main(void) {
  testTurns();
  testDensity();
  testDraws();
  testOneTorsion();
  testHopelessNumbers();
  return checkResult();
}
