/* What the calls on an energy promise: what a refresh computes, in which order parts are asked for, and what is
 * refused. */
#include "beadenergy.h"

/* ---- The state ---- */

static double distance(const double* x, int i, int j) {
  return sqrt(pow(x[3 * i] - x[3 * j], 2) + pow(x[3 * i + 1] - x[3 * j + 1], 2) + pow(x[3 * i + 2] - x[3 * j + 2], 2));
}

/* The energy of all torsions, by vectors. */
static double torsionEnergy(const double* x) {
  double sum = 0;
  for (int i = 0; i < LINKS; i++) {
    double b[3][3];
    double n[2][3];
    for (int k = 0; k < 3; k++) {
      for (int d = 0; d < 3; d++) {
        b[k][d] = x[3 * (i + k + 1) + d] - x[3 * (i + k) + d];
      }
    }
    for (int k = 0; k < 2; k++) {
      for (int d = 0; d < 3; d++) {
        n[k][d] = b[k][(d + 1) % 3] * b[k + 1][(d + 2) % 3] - b[k][(d + 2) % 3] * b[k + 1][(d + 1) % 3];
      }
    }
    const double cosine = n[0][0] * n[1][0] + n[0][1] * n[1][1] + n[0][2] * n[1][2];
    const double sine = distance(x, i + 1, i + 2) * (b[0][0] * n[1][0] + b[0][1] * n[1][1] + b[0][2] * n[1][2]);
    sum += 3 * (1 + cos(atan2(sine, cosine)));
  }
  return sum;
}

/* A refresh does not depend on earlier states. */
static void testRefresh(void) {
  static double now[3 * BEADS];
  Bench bench = makeBench();
  for (int i = 0; i < 3; i++) {
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    ctGetPositions(bench.tree, now);
    CHECK(fabs(ctGetTermEnergy(bench.energy, 0) - torsionEnergy(now)) < 1e-8);
    propose(&bench);
    CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
  }
  const double before = ctGetPairEnergy(bench.energy);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  CHECK(ctGetPairEnergy(bench.energy) != before);
  destroyBench(&bench);
}

/* ---- Parts ---- */

static ctStatus askFor(const Bench* bench, ctEnergyPart part) {
  double change;
  return ctComputeEnergyChange(bench->energy, part, &change, NULL);
}

static void checkRefused(const Bench* bench, ctStatus status, ctStatus expected, const char* text) {
  CHECK(status == expected);
  CHECK(strstr(ctGetEnergyErrorText(bench->energy), text) != NULL);
}

static const char* const outOfOrder = "in their order";

static void testOrder(void) {
  Bench bench = makeBench();
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  checkRefused(&bench, askFor(&bench, ctTermsPart), ctNoTrial, "no open trial");
  propose(&bench);
  checkRefused(&bench, askFor(&bench, ctNearPairsPart), ctInvalidArgument, outOfOrder);
  CHECK(askFor(&bench, ctTermsPart) == ctSuccess);
  checkRefused(&bench, askFor(&bench, ctOtherPairsPart), ctInvalidArgument, outOfOrder);
  CHECK(askFor(&bench, ctNearPairsPart) == ctSuccess);
  checkRefused(&bench, askFor(&bench, ctNearPairsPart), ctInvalidArgument, outOfOrder);
  /* What was asked of one trial is nothing to the next. */
  ctReject(bench.tree);
  propose(&bench);
  checkRefused(&bench, askFor(&bench, ctOtherPairsPart), ctInvalidArgument, outOfOrder);
  CHECK(askFor(&bench, ctTermsPart) == ctSuccess);
  CHECK(askFor(&bench, ctNearPairsPart) == ctSuccess);
  CHECK(askFor(&bench, ctOtherPairsPart) == ctSuccess);
  checkRefused(&bench, askFor(&bench, (ctEnergyPart)CT_ENERGY_PARTS), ctInvalidArgument, outOfOrder);
  destroyBench(&bench);
}

static void testAcceptance(void) {
  const char* const text = "not all parts";
  Bench bench = makeBench();
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  const double start = total(&bench);
  checkRefused(&bench, ctAcceptEnergyChange(bench.energy), ctInvalidArgument, text);
  propose(&bench);
  CHECK(askFor(&bench, ctTermsPart) == ctSuccess);
  checkRefused(&bench, ctAcceptEnergyChange(bench.energy), ctInvalidArgument, text);
  CHECK(total(&bench) == start);
  double change;
  CHECK(computeChange(&bench, &change) == ctSuccess); /* from the first part on */
  CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
  CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
  CHECK(fabs(change) > 1 && fabs(total(&bench) - start - change) < 1e-9);
  /* Once. */
  checkRefused(&bench, ctAcceptEnergyChange(bench.energy), ctInvalidArgument, text);
  destroyBench(&bench);
}

/* ---- Pairs beyond single precision ---- */

/* Two beads on top of each other that are excluded, and two that are not and nearly so. */
static void testOverflow(void) {
  static double now[3 * BEADS];
  Bench bench = makeBench();
  ctGetPositions(bench.tree, now);
  for (int d = 0; d < 3; d++) {
    now[3 * 302 + d] = now[3 * 300 + d];
    now[3 * 303 + d] = now[3 * 305 + d] + (d == 0 ? 1e-5 : 0);
    now[3 * 301 + d] += 0.03;
    now[3 * 304 + d] -= 0.03;
  }
  now[3 * 309] = now[3 * 305] + 2e-5;
  now[3 * 309 + 1] = now[3 * 305 + 1];
  now[3 * 309 + 2] = now[3 * 305 + 2];
  CHECK(ctSetPositions(bench.tree, now) == ctSuccess);
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  ctGetPositions(bench.tree, now);
  const double expected =
      4 * 0.2 * pow(0.1 / distance(now, 305, 309), 12) + 4 * 0.2 * pow(0.1 / distance(now, 303, 309), 12);
  CHECK(expected > 1e41 && fabs(ctGetPairEnergy(bench.energy) / expected - 1) < 0.1);
  destroyBench(&bench);
}

int main(void) {
  describe();
  testRefresh();
  testOrder();
  testAcceptance();
  testOverflow();
  return checkResult();
}
