/* Densities of torsions: what is drawn has the density that is evaluated, by chi squared on grids of cells; each is
 * normalized; edges of the circle and of uniform numbers; no memory. */
#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "../../chaintree/tests/failingallocator.h"
#include "ctdensity.h"

#define TORSIONS_MOST 4

static uint64_t chance = 88172645463325252u;

static double draw(void) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return (double)(chance >> 11) * 0x1p-53;
}

static void drawAngles(const ctDensity* density, double* angles) {
  double uniforms[CT_UNIFORMS_MOST];
  const int count = ctCountUniforms(density);
  for (int i = 0; i < count; i++) {
    uniforms[i] = draw();
  }
  ctDrawAngles(density, uniforms, angles);
}

/* The angles in the middle of cell `index` of a grid that cuts each circle into `cells`. */
static void middleOf(int index, int torsions, int cells, double* angles) {
  for (int k = torsions - 1; k >= 0; k--) {
    angles[k] = (index % cells + 0.5) * (2 * PI / cells) - PI;
    index /= cells;
  }
}

static int power(int base, int exponent) {
  int result = 1;
  for (int i = 0; i < exponent; i++) {
    result *= base;
  }
  return result;
}

/* The probability of each cell, from `fine` points along each side of it. */
static void integrate(const ctDensity* density, int torsions, int cells, int fine, double* expected) {
  const int sides = cells * fine, points = power(sides, torsions);
  const double volume = pow(2 * PI / sides, torsions);
  memset(expected, 0, (size_t)power(cells, torsions) * sizeof *expected);
  for (int point = 0; point < points; point++) {
    double angles[TORSIONS_MOST];
    middleOf(point, torsions, sides, angles);
    int cell = 0;
    for (int k = 0, rest = points; k < torsions; k++) {
      rest /= sides;
      cell = cell * cells + point / rest % sides / fine;
    }
    expected[cell] += volume * ctGetDensity(density, angles);
  }
}

/* By how many standard deviations the chi squared of draws from one density is above that of a right one, by Wilson and
 * Hilferty; cells with less than 5 expected draws are thrown together. */
static double excess(const ctDensity* drawn, const double* expected, int torsions, int cells, int draws) {
  const int count = power(cells, torsions);
  int* found = calloc((size_t)count, sizeof *found);
  for (int i = 0; i < draws; i++) {
    double angles[TORSIONS_MOST];
    drawAngles(drawn, angles);
    int cell = 0;
    for (int k = 0; k < torsions; k++) {
      CHECK(angles[k] >= -PI && angles[k] <= PI);
      const int side = (int)((angles[k] + PI) / (2 * PI) * cells);
      cell = cell * cells + (side < cells ? side : cells - 1);
    }
    found[cell]++;
  }
  double chiSquared = 0, restExpected = 0, restFound = 0;
  int terms = 0;
  for (int i = 0; i < count; i++) {
    const double mean = draws * expected[i];
    if (mean < 5) {
      restExpected += mean;
      restFound += found[i];
      continue;
    }
    chiSquared += (found[i] - mean) * (found[i] - mean) / mean;
    terms++;
  }
  if (restExpected >= 5) {
    chiSquared += (restFound - restExpected) * (restFound - restExpected) / restExpected;
    terms++;
  }
  free(found);
  const double freedom = terms - 1, spread = 2 / (9 * freedom);
  return (cbrt(chiSquared / freedom) - (1 - spread)) / sqrt(spread);
}

/* Ten comparisons by chi squared: 4.5 standard deviations are a significance of 3e-5 for all of them. */
#define MOST_EXCESS 4.5

static void checkDraws(const char* name, const ctDensity* density, int torsions, int cells, int fine, int draws) {
  CHECK(density != NULL);
  double* expected = malloc((size_t)power(cells, torsions) * sizeof *expected);
  integrate(density, torsions, cells, fine, expected);
  double sum = 0;
  for (int i = 0; i < power(cells, torsions); i++) {
    sum += expected[i];
  }
  CHECK_NEAR(sum, 1, 1e-6);
  const double found = excess(density, expected, torsions, cells, draws);
  if (!(found < MOST_EXCESS)) {
    reportFailure("%s: chi squared is %g standard deviations too large\n", name, found);
  }
  free(expected);
}

static void testTables(void) {
  double values[12 * 8];
  for (int i = 0; i < 12 * 8; i++) {
    values[i] = i % 7 == 0 ? 0 : exp(6 * draw());
  }
  const int twelve[] = {12}, grid[] = {12, 8}, cube[] = {4, 3, 8};
  ctDensity* line = ctCreateTable(1, twelve, values, 0.01);
  checkDraws("table of one torsion", line, 1, 24, 4, 400000);
  ctDensity* plane = ctCreateTable(2, grid, values, 0.1);
  checkDraws("table of two torsions", plane, 2, 24, 2, 1000000);
  ctDensity* space = ctCreateTable(3, cube, values, 0);
  checkDraws("table of three torsions", space, 3, 24, 1, 1000000);

  /* The last torsion's index runs fastest, and the first bin begins at -pi. */
  const double angles[] = {-PI + 3.5 * 2 * PI / 12, -PI + 1.5 * 2 * PI / 8};
  double sum = 0;
  for (int i = 0; i < 12 * 8; i++) {
    sum += values[i];
  }
  const double uniform = 1 / (4 * PI * PI);
  CHECK_NEAR(ctGetDensity(plane, angles), (0.9 * values[3 * 8 + 1] / sum * 96 + 0.1) * uniform, 1e-15);

  /* One bin is uniform, and so is a floor of 1; a bin of no value is never drawn without a floor. */
  const int one[] = {1}, two[] = {2};
  const double half[] = {0, 1};
  ctDensity* flat = ctCreateTable(1, one, values + 1, 0);
  checkDraws("one bin", flat, 1, 50, 1, 100000);
  ctDensity* floor = ctCreateTable(2, grid, values, 1);
  checkDraws("a floor of 1", floor, 2, 24, 1, 100000);
  ctDensity* right = ctCreateTable(1, two, half, 0);
  for (int i = 0; i < 1000; i++) {
    double angle;
    drawAngles(right, &angle);
    CHECK(angle >= 0 && angle <= PI);
  }
  ctDestroyDensity(line);
  ctDestroyDensity(plane);
  ctDestroyDensity(space);
  ctDestroyDensity(flat);
  ctDestroyDensity(floor);
  ctDestroyDensity(right);
}

static void testRotamers(void) {
  /* Bells that are narrow, that cross the end of the circle, and that are wider than it. */
  const double weights[] = {2, 1, 0, 4, 0.5};
  const double means[] = {-1, 3.1, 2, PI, -PI, 0.5, 0.2, -2.5, 2.2};
  const double widths[] = {0.15, 0.2, 0.3, 0.9, 1.1, 3, 2, 0.25, 0.4};
  ctDensity* one = ctCreateRotamers(1, 5, weights, means, widths, 0.05);
  checkDraws("rotamers of one torsion", one, 1, 90, 200, 1000000);
  ctDensity* wide = ctCreateRotamers(1, 1, weights, means + 5, widths + 5, 0.05);
  checkDraws("a bell wider than the circle", wide, 1, 90, 200, 300000);
  ctDensity* two = ctCreateRotamers(2, 4, weights, means, widths, 0.1);
  checkDraws("rotamers of two torsions", two, 2, 36, 20, 1000000);
  ctDensity* three = ctCreateRotamers(3, 3, weights, means, widths, 0.2);
  checkDraws("rotamers of three torsions", three, 3, 12, 12, 1000000);

  /* A density of 17 rotamers fills more than two batches: it is that of one, since all of them are the same. */
  double manyWeights[17], manyMeans[17], manyWidths[17];
  for (int i = 0; i < 17; i++) {
    manyWeights[i] = 1 + i;
    manyMeans[i] = 1;
    manyWidths[i] = 0.3;
  }
  ctDensity* many = ctCreateRotamers(1, 17, manyWeights, manyMeans, manyWidths, 0.1);
  ctDensity* single = ctCreateRotamers(1, 1, manyWeights, manyMeans, manyWidths, 0.1);
  for (int i = 0; i < 1000; i++) {
    const double angle = 2 * PI * draw() - PI;
    CHECK_NEAR(ctGetDensity(many, &angle), ctGetDensity(single, &angle), 1e-14);
  }

  /* The bell is what it is said to be: this mean, this deviation, and 2/3 over its reach in the middle. */
  double sum = 0, squares = 0;
  const int draws = 400000;
  ctDensity* bell = ctCreateRotamers(1, 1, manyWeights, manyMeans, manyWidths, 0);
  for (int i = 0; i < draws; i++) {
    double angle;
    drawAngles(bell, &angle);
    sum += angle - 1;
    squares += (angle - 1) * (angle - 1);
  }
  CHECK_NEAR(sum / draws, 0, 5 * 0.3 / sqrt(draws));
  CHECK_NEAR(sqrt(squares / draws), 0.3, 5 * 0.3 / sqrt(2.0 * draws));
  CHECK_NEAR(ctGetDensity(bell, manyMeans), 2 / (3 * sqrt(3) * 0.3), 1e-14);
  double most = 0;
  for (double x = -2; x < 2; x += 1e-3) {
    const double angle = 1 + x;
    const double normal = exp(-x * x / 0.18) / (0.3 * sqrt(2 * PI));
    most = fmax(most, fabs(ctGetDensity(bell, &angle) - normal));
  }
  CHECK(most < 0.015 / 0.3);
  ctDestroyDensity(one);
  ctDestroyDensity(wide);
  ctDestroyDensity(two);
  ctDestroyDensity(three);
  ctDestroyDensity(many);
  ctDestroyDensity(single);
  ctDestroyDensity(bell);
}

/* Chi squared sees a floor, a mean, a width and a weight that are a little off. */
static void testThatFaultsAreSeen(void) {
  const double weights[] = {2, 1, 1}, offWeights[] = {2, 1, 1.05};
  const double means[] = {-1, 1.1, 3}, offMeans[] = {-1, 1.12, 3};
  const double widths[] = {0.15, 0.2, 0.3}, offWidths[] = {0.15, 0.21, 0.3};
  ctDensity* right = ctCreateRotamers(1, 3, weights, means, widths, 0.05);
  ctDensity* off[] = {
      ctCreateRotamers(1, 3, weights, means, widths, 0.04), ctCreateRotamers(1, 3, offWeights, means, widths, 0.05),
      ctCreateRotamers(1, 3, weights, offMeans, widths, 0.05), ctCreateRotamers(1, 3, weights, means, offWidths, 0.05)};
  for (int i = 0; i < 4; i++) {
    double expected[90];
    integrate(off[i], 1, 90, 200, expected);
    CHECK(excess(right, expected, 1, 90, 1000000) > 2 * MOST_EXCESS);
    ctDestroyDensity(off[i]);
  }
  ctDestroyDensity(right);
}

/* Uniform numbers at their ends, and angles at the circle's. */
static void testEdges(void) {
  const int bins[] = {7, 9};
  double values[63];
  for (int i = 0; i < 63; i++) {
    values[i] = 1 + i;
  }
  const double means[] = {PI, -PI}, widths[] = {3.1, 0.5};
  ctDensity* densities[] = {ctCreateTable(2, bins, values, 0), ctCreateRotamers(2, 1, values, means, widths, 0.1),
                            ctCreateRotamers(2, 1, values, means, widths, 0)};
  const double ends[] = {0, 0x1p-53, 0.1, 0.5, 1 - 0x1p-53};
  for (int i = 0; i < 3; i++) {
    const int count = ctCountUniforms(densities[i]);
    CHECK(count <= CT_UNIFORMS_MOST);
    for (int trial = 0; trial < 2000; trial++) {
      double uniforms[CT_UNIFORMS_MOST], angles[2];
      for (int j = 0; j < count; j++) {
        uniforms[j] = ends[(int)(5 * draw())];
      }
      ctDrawAngles(densities[i], uniforms, angles);
      for (int k = 0; k < 2; k++) {
        CHECK(angles[k] >= -PI && angles[k] <= PI);
      }
      CHECK(ctGetDensity(densities[i], angles) >= 0);
    }
    const double left[] = {-PI, -PI}, right[] = {PI, PI};
    CHECK(ctGetDensity(densities[i], left) > 0 && ctGetDensity(densities[i], right) > 0);
    ctDestroyDensity(densities[i]);
  }
  ctDestroyDensity(NULL);
}

static void testNoMemory(void) {
#ifdef HAS_GLIBC_ALLOCATOR
  const int bins[] = {3, 4};
  const double values[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3};
  for (int kind = 0; kind < 2; kind++) {
    for (int number = 0;; number++) {
      const int before = live;
      failAllocation(number);
      ctDensity* density =
          kind == 0 ? ctCreateTable(2, bins, values, 0) : ctCreateRotamers(3, 4, values, values, values, 0);
      failAllocation(-1);
      CHECK((density == NULL) == (live == before));
      ctDestroyDensity(density);
      CHECK(live == before);
      if (density != NULL) {
        CHECK(number >= 5);
        break;
      }
    }
  }
#endif
}

int main(void) {
  testTables();
  testRotamers();
  testThatFaultsAreSeen();
  testEdges();
  testNoMemory();
  return checkResult();
}
