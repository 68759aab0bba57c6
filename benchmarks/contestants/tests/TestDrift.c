/* Errors of positions are measured as they are, those of weak paths among them. */
#include <string.h>

#include "branches.h"
#include "chains.h"
#include "driftrace.h"
#include "reference.h"
#include "sets.h"

/* ---- Errors ---- */

static void testErrors(void) {
  /* One corner, and a fourth point out of its plane. */
  const Place expected[4] = {{1, 0, 0}, {0, 0, 0}, {0, 2, 0}, {0, 2, 1}};
  double positions[12];
  PairSample sample;
  Random random = {1};
  for (int i = 0; i < 12; i++) {
    positions[i] = (double)expected[i / 3][i % 3];
  }
  CHECK(pairSampleInit(&sample, 4, &random) && sample.count == 6);
  Errors errors = errorsOf(&sample, 4, positions, expected);
  CHECK(errors.distances.largest == 0 && errors.bonds.largest == 0);
  CHECK(errors.angles.largest == 0 && errors.torsions.largest == 0);

  positions[0] += 0.25; /* along its bond: that, and its distances to the third and the fourth */
  errors = errorsOf(&sample, 4, positions, expected);
  CHECK_NEAR(errors.bonds.largest, 0.25, 1e-18);
  CHECK_NEAR(errors.bonds.rms, 0.25 / sqrt(3), 1e-15);
  CHECK_NEAR(errors.distances.largest, 0.25, 1e-18);
  const double third = sqrt(1.25 * 1.25 + 4) - sqrt(5);
  const double fourth = sqrt(1.25 * 1.25 + 5) - sqrt(6);
  CHECK_NEAR(errors.distances.rms, sqrt((0.25 * 0.25 + third * third + fourth * fourth) / 6), 1e-15);
  CHECK_NEAR(errors.angles.largest, 0, 1e-18);
  CHECK_NEAR(errors.torsions.largest, 0, 1e-18);

  positions[0] = cos(0.1); /* about the second bond, which turns the torsion */
  positions[2] = sin(0.1);
  errors = errorsOf(&sample, 4, positions, expected);
  CHECK_NEAR(errors.torsions.largest, 0.1, 1e-15);
  CHECK_NEAR(errors.angles.largest, 0, 1e-15);
  positions[0] = cos(0.1); /* in the plane of the corner */
  positions[1] = sin(0.1);
  positions[2] = 0;
  errors = errorsOf(&sample, 4, positions, expected);
  CHECK_NEAR(errors.angles.largest, 0.1, 1e-15);
  CHECK_NEAR(errors.torsions.largest, 0, 1e-15);
  pairSampleFree(&sample);

  const Place ends[2] = {{-3, 0, 0}, {5, 0, 0}};
  CHECK_NEAR(sizeOf(2, ends), 8, 1e-15);
}

static void testSample(void) {
  PairSample sample;
  Random random = {1};
  CHECK(pairSampleInit(&sample, 1000, &random) && sample.count == 100000);
  for (int p = 0; p < sample.count; p++) {
    CHECK(sample.pairs[p][0] != sample.pairs[p][1]);
    CHECK(sample.pairs[p][0] >= 0 && sample.pairs[p][0] < 1000);
  }
  pairSampleFree(&sample);
}

/* ---- Paths ---- */

static const DriftResult* resultOf(const DriftRace* race, const DriftResult* results, const char* name) {
  for (int i = 0; i < race->laneCount; i++) {
    if (strcmp(race->paths[i]->name, name) == 0) {
      return &results[i];
    }
  }
  printf("there is no path %s\n", name);
  exit(1);
}

/* After 1,000 turns, and after 10,000. */
static double errorAt(const DriftRace* race, const DriftResult* results, const char* name, int station) {
  const DriftResult* result = resultOf(race, results, name);
  const Station* s = &result->stations[station];
  const Errors* errors = result->keepsAngles ? &s->ofAngles : &s->ofTurns;
  return errors->distances.rms / s->size;
}

static void checkPaths(const DriftRace* race, const DriftResult* results) {
  static const char* const steady[] = {"ours-avx512", "ours-avx2", "ours-portable", "shortcuts", "sequential"};
  for (int i = 0; i < race->laneCount; i++) {
    CHECK(results[i].stationCount == 2);
    CHECK(results[i].stations[0].turns == 1000 && results[i].stations[1].turns == 10000);
    CHECK(results[i].microseconds.first > 0 && results[i].microseconds.first <= results[i].microseconds.third);
    for (int s = 0; s < 2; s++) {
      const Station* station = &results[i].stations[s];
      const bool isSingle = strstr(race->paths[i]->name, "single") != NULL;
      /* All are somewhere near; single precision is not taken for better than it is. */
      CHECK(station->ofTurns.distances.largest < (isSingle ? 0.01 : 1e-10) * station->size);
      CHECK(station->ofTurns.distances.largest > (isSingle ? 1e-8 : 0) * station->size);
      CHECK(station->ofTurns.distances.rms <= station->ofTurns.distances.largest);
    }
  }
  for (int k = 0; k < 5; k++) {
    CHECK(errorAt(race, results, steady[k], 1) < 1e-15);
  }
  for (int station = 0; station < 2; station++) {
    const uint64_t bits = resultOf(race, results, "ours-portable")->stations[station].bits;
    CHECK(resultOf(race, results, "ours-avx2")->stations[station].bits == bits);
    CHECK(resultOf(race, results, "ours-avx512")->stations[station].bits == bits);
  }
  /* What is multiplied on what was there before drifts. */
  CHECK(errorAt(race, results, "multiplied", 1) > 4 * errorAt(race, results, "multiplied", 0));
  CHECK(errorAt(race, results, "multiplied", 1) > 4 * errorAt(race, results, "shortcuts", 1));
  CHECK(errorAt(race, results, "cartesian", 1) > errorAt(race, results, "multiplied", 1));
  CHECK(errorAt(race, results, "cartesian-single", 1) > errorAt(race, results, "shortcuts-single", 1));
}

static void testPaths(void) {
  const InstructionSet* sets[MOST_SETS];
  const int setCount = setsHere(sets);
  Scene* scene = chainHilbert(100);
  for (int i = 0; i < setCount; i++) {
    DriftRace race = {.scene = scene, .rule = {movesUniform, 0, 1}, .seed = 1, .turnCount = 10000, .seconds = 1e9};
    DriftResult results[MOST_DRIFT_LANES];
    char error[200] = "";
    for (const Kinematics* const* k = sets[i]->kinematics; *k != NULL; k++) {
      race.paths[race.laneCount++] = *k;
    }
    CHECK(race.laneCount == 11);
    if (!driftRaceRun(&race, results, error, sizeof error)) {
      reportFailure("%s: %s\n", sets[i]->name, error);
      continue;
    }
    checkPaths(&race, results);
  }
  sceneFree(scene);
}

/* A path goes as far as its time allows, but always to the first station. */
static void testTime(void) {
  const InstructionSet* set = instructionSetFind(NULL);
  Scene* scene = chainHilbert(50);
  DriftRace race = {.scene = scene,
                    .rule = {movesUniform, 0, 1},
                    .seed = 1,
                    .turnCount = 1000000,
                    .seconds = 1e-9,
                    .laneCount = 1,
                    .paths = {kinematicsFind(set, "cartesian", strlen("cartesian"))}};
  DriftResult result;
  char error[200] = "";
  CHECK(driftRaceRun(&race, &result, error, sizeof error));
  CHECK(result.stationCount == 1 && result.stations[0].turns == 1000);
  race.turnCount = 30;
  CHECK(driftRaceRun(&race, &result, error, sizeof error));
  CHECK(result.stationCount == 1 && result.stations[0].turns == 30);
  sceneFree(scene);

  scene = makeBranches(40, 4, 1);
  race.scene = scene;
  CHECK(!driftRaceRun(&race, &result, error, sizeof error) && strstr(error, "chains without branches") != NULL);
  sceneFree(scene);
}

int main(void) {
  if (!referenceIsExact()) {
    return 77;
  }
  testErrors();
  testSample();
  testPaths();
  testTime();
  return checkResult();
}
