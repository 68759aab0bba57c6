/* Value energies of random expressions against all pairs in long double: with a cutoff and without, exclusions, values
 * of values, numbers that are no floats. The same bits by every instruction set, and of a trial as of the state that it
 * becomes. And descriptions that are refused. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "valuescene.h"

static double worst = 0; /* error, of what is allowed */

/* ---- The oracle ---- */

/* The energy, and how large the numbers are of which it is made. */
typedef struct Oracle {
  long double energy;
  long double size;
} Oracle;

static bool isExcluded(const ctValueEnergy* d, int i, int j) {
  for (int n = 0; n < d->exclusionCount; n++) {
    if ((d->exclusions[n][0] == i && d->exclusions[n][1] == j) ||
        (d->exclusions[n][0] == j && d->exclusions[n][1] == i)) {
      return true;
    }
  }
  return false;
}

static long double numbers[MOST_PARTICLES][MOST_NUMBERS];

/* What an expression of pairs is for i and j; 0 if they do not count. */
static long double oracleOfPair(const ctValueEnergy* d, const ctValueExpression* e, const double* positions, int i,
                                int j) {
  const long double r = oracleDistance(positions, i, j);
  if (!(r < d->cutoff) || (e->extent == ctOfPairs && isExcluded(d, i, j))) {
    return 0;
  }
  return oracleExpression(e, PARAMETERS + d->valueCount, r, numbers[i], numbers[j]);
}

static Oracle findOracle(const ValueScene* s, const double* positions) {
  const ctValueEnergy* d = &s->energy;
  const int count = s->particles.count;
  Oracle found = {0, 1};
  for (int i = 0; i < count; i++) {
    for (int p = 0; p < PARAMETERS; p++) {
      numbers[i][p] = s->parameters[PARAMETERS * i + p];
    }
    for (int k = 0; k < 3; k++) {
      numbers[i][PARAMETERS + d->valueCount + k] = positions[3 * i + k];
    }
  }
  for (int v = 0; v < d->valueCount; v++) {
    for (int i = 0; i < count; i++) {
      long double value = 0;
      for (int j = 0; j < count && d->values[v].extent != ctOfParticles; j++) {
        value += i == j ? 0 : oracleOfPair(d, &d->values[v], positions, i, j);
      }
      numbers[i][PARAMETERS + v] =
          d->values[v].extent == ctOfParticles ? oracleExpression(&d->values[v], 0, 0, numbers[i], NULL) : value;
    }
  }
  for (int t = 0; t < d->termCount; t++) {
    for (int i = 0; i < count; i++) {
      if (d->terms[t].extent == ctOfParticles) {
        const long double ofParticle = oracleExpression(&d->terms[t], 0, 0, numbers[i], NULL);
        found.energy += ofParticle;
        found.size += fabsl(ofParticle) + 1;
      }
      for (int j = i + 1; j < count && d->terms[t].extent != ctOfParticles; j++) {
        const long double ofPair = oracleOfPair(d, &d->terms[t], positions, i, j);
        found.energy += ofPair;
        found.size += fabsl(ofPair);
      }
    }
  }
  return found;
}

/* ---- Scenes ---- */

/* A scene and its energy by one instruction set. */
typedef struct Bench {
  ctChainTree* tree;
  ctEnergy* energy;
} Bench;

static Bench makeBench(const ValueScene* s, const char* instructions) {
  char text[200] = "";
  Bench bench;
  setenv("CHAINTREE_SIMD", instructions, 1);
  bench.tree = createTree(&s->particles);
  /* The first is twice there, so that the second needs another place. */
  const ctValueEnergy energies[2] = {s->energy, s->energy};
  const ctEnergyDefinition definition = {
      .scene = &s->particles.definition, .valueEnergyCount = 2, .valueEnergies = energies};
  if (ctCreateEnergy(bench.tree, &definition, &bench.energy, text, sizeof text) != ctSuccess) {
    printf("ctCreateEnergy: %s\n", text);
    exit(1);
  }
  return bench;
}

static void destroyBench(Bench* bench) {
  ctDestroyEnergy(bench->energy);
  ctDestroy(bench->tree);
}

static double compute(const Bench* bench, bool inTrial) {
  double found[2];
  CHECK(ctComputeValueEnergies(bench->energy, inTrial, found) == ctSuccess);
  CHECK(memcmp(&found[0], &found[1], sizeof(double)) == 0);
  return found[0];
}

/* Turns one body; false if there is none that can be. */
static bool propose(const Bench* bench, const ValueScene* s) {
  const ctChange change = {
      .link = drawInt(s->particles.linkCount),
      .rotation = {draw(-1, 1), draw(-1, 1), draw(-1, 1)},
      .translation = {draw(-0.1, 0.1), draw(-0.1, 0.1), draw(-0.1, 0.1)},
  };
  return ctPropose(bench->tree, 1, &change) == ctSuccess;
}

/* Numbers of random expressions are as large as 1 and were computed in some twenty steps from one another. */
static void checkEnergy(const ValueScene* s, const Bench* bench, double found) {
  static double positions[3 * MOST_PARTICLES];
  ctGetPositions(bench->tree, positions);
  const Oracle expected = findOracle(s, positions);
  const double error = (double)(fabsl(found - expected.energy) / expected.size / 1e-6L);
  if (!(error < 1)) {
    reportFailure("%d particles: the energy is %.9g, not %.9Lg of %.3Lg\n", s->particles.count, found, expected.energy,
                  expected.size);
  }
  worst = fmax(worst, error);
}

/* True if no distance is so near the cutoff that rounding decides. */
static bool isClear(const ValueScene* s, const double* positions) {
  for (int i = 0; i < s->particles.count; i++) {
    for (int j = 0; j < i; j++) {
      if (fabsl(oracleDistance(positions, i, j) - s->energy.cutoff) < 1e-6L) {
        return false;
      }
    }
  }
  return true;
}

/* What an instruction set makes of a state, a trial, and the state that it becomes. */
static void runBench(const ValueScene* s, const char* instructions, bool isFirst, uint64_t start, double found[2]) {
  static double positions[3 * MOST_PARTICLES];
  Bench bench = makeBench(s, instructions);
  chance = start;
  found[0] = compute(&bench, false);
  if (isFirst) {
    checkEnergy(s, &bench, found[0]);
  }
  double none[2];
  CHECK(ctComputeValueEnergies(bench.energy, true, none) == ctNoTrial);
  CHECK(strcmp(ctGetEnergyErrorText(bench.energy), "there is no open trial") == 0);
  CHECK(propose(&bench, s));
  found[1] = compute(&bench, true);
  const double again = compute(&bench, false);
  CHECK(memcmp(&again, &found[0], sizeof(double)) == 0);
  CHECK(ctAccept(bench.tree, NULL) == ctSuccess);
  const double after = compute(&bench, false);
  CHECK(memcmp(&after, &found[1], sizeof(double)) == 0);
  ctGetPositions(bench.tree, positions);
  if (isFirst && isClear(s, positions)) {
    checkEnergy(s, &bench, after);
  }
  destroyBench(&bench);
}

static void testScenes(int count) {
  static ValueScene s;
  int different = 0;
  for (int n = 0; n < count; n++) {
    do {
      drawValueScene(&s);
    } while (!isClear(&s, s.particles.positions));
    if (n % 5 == 0 && s.energy.termCount > 0) {
      s.parameters[drawInt(PARAMETERS * s.particles.count)] =
          0x1p-140; /* no float: the whole energy is computed in double */
    }
    const uint64_t start = chance;
    double found[3][2];
    const char* const sets[] = {"portable", "avx2", "avx512"};
    for (int i = 0; i < 3; i++) {
      runBench(&s, sets[i], i == 0, start, found[i]);
      CHECK(memcmp(found[i], found[0], sizeof found[0]) == 0);
    }
    different += found[0][0] != found[0][1];
  }
  CHECK(count < 20 || different > count / 2);
  printf("worst error %.3f of what is allowed\n", worst);
}

/* ---- Where floats overflow ---- */

/* Two particles of one body this far apart. */
static void drawPair(ValueScene* s, double distance) {
  do {
    drawWholeScene(&s->particles);
  } while (s->particles.count < 2);
  s->particles.count = s->particles.definition.particleCount = 2;
  const double positions[] = {0, 0, 0, 0, distance, 0};
  memcpy(s->particles.positions, positions, sizeof positions);
  s->particles.links[1] = 0;
  s->particles.definition.linkCount = 1;
}

/* Two particles 2^-13 nm apart of sum r^-12, whose value is beyond floats, and the energy of its logarithm. */
static void testOverflow(void) {
  static ValueScene s;
  drawPair(&s, 0x1p-13);
  const ctOperation power[] = {{ctInputOperator, {0}, 0}, {ctPowerConstantOperator, {0}, -12}};
  const ctOperation logarithm[] = {{ctParameterOperator, {0}, 0}, {ctLogOperator, {0}, 0}};
  const ctOperation product[] = {
      {ctParameterOperator, {0}, 0}, {ctParameterOperator, {1}, 0}, {ctMultiplyOperator, {0, 1}, 0}};
  const ctValueExpression values[] = {{ctOfPairs, 2, power, 0, NULL}};
  const ctValueExpression terms[] = {{ctOfParticles, 2, logarithm, 0, NULL}, {ctOfPairs, 3, product, 0, NULL}};
  s.energy = (ctValueEnergy){.valueCount = 1, .values = values, .termCount = 1, .terms = terms, .cutoff = INFINITY};
  const char* const sets[] = {"portable", "avx2", "avx512"};
  for (int i = 0; i < 3; i++) {
    for (int termCount = 1; termCount <= 2; termCount++) {
      s.energy.termCount = termCount;
      Bench bench = makeBench(&s, sets[i]);
      const double expected = 2 * 156 * log(2) + (termCount == 2 ? 0x1p312 : 0);
      CHECK_NEAR(compute(&bench, false) / expected, 1, 1e-12);
      destroyBench(&bench);
    }
  }
}

/* The root of a product is that of roots only if no value can be below 0, as both are here. */
static void testRoots(void) {
  static ValueScene s;
  drawPair(&s, 0.25);
  const ctOperation negative[] = {{ctInputOperator, {0}, 0}, {ctNegateOperator, {0}, 0}};
  const ctOperation root[] = {{ctConstantOperator, {0}, 2},  {ctParameterOperator, {0}, 0},
                              {ctParameterOperator, {1}, 0}, {ctMultiplyOperator, {1, 2}, 0},
                              {ctSqrtOperator, {3}, 0},      {ctMinOperator, {0, 4}, 0}};
  const ctValueExpression value = {ctOfPairs, 2, negative, 0, NULL};
  const ctValueExpression term = {ctOfPairs, 6, root, 0, NULL};
  s.energy = (ctValueEnergy){.valueCount = 1, .values = &value, .termCount = 1, .terms = &term, .cutoff = INFINITY};
  Bench bench = makeBench(&s, "portable");
  CHECK_NEAR(compute(&bench, false), 0.25, 1e-6);
  destroyBench(&bench);
}

/* ---- Refusals ---- */

static void checkRefused(const ValueScene* s, const ctValueEnergy* energy, int count, const char* expected) {
  char text[200] = "";
  ctEnergy* made;
  ctChainTree* tree = createTree(&s->particles);
  const ctValueEnergy energies[2] = {s->energy, *energy};
  const ctEnergyDefinition definition = {
      .scene = &s->particles.definition, .valueEnergyCount = count, .valueEnergies = energies};
  CHECK(ctCreateEnergy(tree, &definition, &made, text, sizeof text) == ctInvalidArgument && made == NULL);
  if (strcmp(text, expected) != 0) {
    reportFailure("\"%s\", not \"%s\"\n", text, expected);
  }
  ctDestroy(tree);
}

static void testRefusals(void) {
  static ValueScene s;
  do {
    drawValueScene(&s);
  } while (s.particles.count < 20 || s.energy.valueCount != 2 || s.energy.termCount < 1);
  checkRefused(&s, &s.energy, -1, "there are -1 value energies");
  ctValueEnergy wrong = s.energy;
  wrong.termCount = -2;
  char text[200];
  snprintf(text, sizeof text, "value energy 1 has 3 parameters a particle, 2 values, -2 terms and %d exclusions",
           wrong.exclusionCount);
  checkRefused(&s, &wrong, 2, text);
  wrong = s.energy;
  wrong.cutoff = 0;
  checkRefused(&s, &wrong, 2, "the cutoff of value energy 1 is 0 nm, but has to be above 0");
  wrong = s.energy;
  const int exclusions[][2] = {{0, s.particles.count}};
  wrong.exclusions = exclusions;
  wrong.exclusionCount = 1;
  snprintf(text, sizeof text, "exclusion 0 of value energy 1 names particle %d, but there are %d particles",
           s.particles.count, s.particles.count);
  checkRefused(&s, &wrong, 2, text);

  ctOperation operation = {ctParameterOperator, {3, 0, 0}, 0};
  ctValueExpression values[] = {s.energy.values[0], {ctOfPairs, 1, &operation, 0, NULL}};
  wrong = s.energy;
  wrong.values = values;
  const struct {
    ctExtent extent;
    ctOperation operation;
    const char* expected;
  } cases[] = {
      {(ctExtent)3, {ctParameterOperator, {0}, 0}, "value 1 of value energy 1 has the unknown extent 3"},
      {ctOfPairs,
       {ctParameterOperator, {4}, 0},
       "operation 0 of value 1 of value energy 1 reads value 1, which is not an earlier one"},
      {ctOfPairs,
       {ctParameterOperator, {9}, 0},
       "operation 0 of value 1 of value energy 1 reads value 1, which is not an earlier one"},
      {ctOfAllPairs,
       {ctParameterOperator, {10}, 0},
       "operation 0 of value 1 of value energy 1 reads parameter 10; there are 10"},
      {ctOfParticles,
       {ctParameterOperator, {8}, 0},
       "operation 0 of value 1 of value energy 1 reads parameter 8; there are 8"},
      {ctOfParticles, {ctInputOperator, {0}, 0}, "operation 0 of value 1 of value energy 1 reads input 0; there are 0"},
      {ctOfPairs, {ctInputOperator, {1}, 0}, "operation 0 of value 1 of value energy 1 reads input 1; there are 1"},
      {ctOfPairs, {ctTableOperator, {0}, 0}, "operation 0 of value 1 of value energy 1 reads table 0; there are 0"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    values[1].extent = cases[i].extent;
    operation = cases[i].operation;
    checkRefused(&s, &wrong, 2, cases[i].expected);
  }
  values[1].operationCount = 0;
  values[1].extent = ctOfPairs;
  checkRefused(&s, &wrong, 2, "value 1 of value energy 1 has 0 operations and 0 tables");
  wrong = s.energy;
  double parameters[PARAMETERS * MOST_PARTICLES];
  memcpy(parameters, s.parameters, sizeof parameters);
  parameters[PARAMETERS * 7 + 1] = NAN;
  wrong.parameters = parameters;
  checkRefused(&s, &wrong, 2, "parameter 1 of particle 7 of value energy 1 is nan");
}

int main(int argumentCount, char** arguments) {
  testScenes(argumentCount > 1 ? atoi(arguments[1]) : 100);
  testOverflow();
  testRoots();
  setenv("CHAINTREE_SIMD", "portable", 1);
  testRefusals();
  return checkResult();
}
