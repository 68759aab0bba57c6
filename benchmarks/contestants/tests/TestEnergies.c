/* The race of energies: what it counts is what happened, its energies are those of all pairs, and files are read. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chains.h"
#include "check.h"
#include "energyrace.h"

enum { SPHERES = 60, TRIALS = 300, BLOCK = 50 };

/* Beside the program, so that others that run at the same time have theirs. */
static char path[1000];

static void writeEnergy(const char* beginning, int particles, const char* end) {
  FILE* file = fopen(path, "w");
  CHECK(file != NULL && fputs(beginning, file) >= 0);
  for (int i = 0; i < particles; i++) {
    CHECK(fprintf(file, "%g 2.5 %g\n", i % 3 - 1.0, 0.1 * (i % 4)) > 0);
  }
  CHECK(fputs(end, file) >= 0 && fclose(file) == 0);
}

static Energy* readEnergy(const Scene* scene, char* error, size_t size) {
  Energy* energy = energyRead(path, scene, error, size);
  remove(path);
  return energy;
}

/* A chain with a cutoff, one pair excluded, and a bond across half of it. */
static Energy* makeEnergy(const Scene* scene) {
  char error[200] = "";
  writeEnergy("chaintree-energy 1\nparticles 60 exclusions 1 sets 1\n9 0 78.5\n", SPHERES,
              "0 1\n0 1 2 2\n3 33 4 0.25\n");
  Energy* energy = readEnergy(scene, error, sizeof error);
  CHECK(energy != NULL);
  return energy;
}

/* Of positions as they are, in double. */
static double sumOf(const Energy* energy, const Scene* scene, const double (*x)[3]) {
  const double cutoff = energy->nonbonded.cutoff;
  const double d = energy->nonbonded.dielectric;
  const double k = (d - 1) / (2 * d + 1) / pow(cutoff, 3);
  const double c = 3 * d / (2 * d + 1) / cutoff;
  double sum = 0;
  for (int i = 0; i < scene->particleCount; i++) {
    for (int j = 0; j < i; j++) {
      double r2 = 0;
      for (int axis = 0; axis < 3; axis++) {
        r2 += pow(x[i][axis] - x[j][axis], 2);
      }
      const int* excluded = energy->exclusions[0];
      const bool isExcluded = (i == excluded[0] && j == excluded[1]) || (i == excluded[1] && j == excluded[0]);
      if (r2 < cutoff * cutoff && !isExcluded) {
        const double s6 = pow((energy->sigmas[i] + energy->sigmas[j]) / 2, 6) / pow(r2, 3);
        sum += 4 * sqrt(energy->epsilons[i] * energy->epsilons[j]) * (s6 * s6 - s6);
        sum += CT_COULOMB * energy->charges[i] * energy->charges[j] * (1 / sqrt(r2) + k * r2 - c);
      }
    }
  }
  const int* bond = energy->sets[0].particles;
  double r2 = 0;
  for (int axis = 0; axis < 3; axis++) {
    r2 += pow(x[bond[0]][axis] - x[bond[1]][axis], 2);
  }
  return sum + 0.5 * 0.25 * pow(sqrt(r2) - 4, 2);
}

static void readPositions(FILE* file, int count, double (*x)[3]) {
  for (int i = 0; i < 3 * count; i++) {
    CHECK(fscanf(file, i == 0 ? "%lf" : ", %lf", &x[i / 3][i % 3]) == 1);
  }
  CHECK(fscanf(file, "]%*[}]%*[\n]") == 0);
}

/* The record has the energies that follow from its positions. */
static void checkRecord(FILE* file, const Energy* energy, const Scene* scene, int expected) {
  static double state[SPHERES][3];
  static double trial[SPHERES][3];
  char word[20];
  double value;
  double before = NAN;
  int trials = 0;
  rewind(file);
  CHECK(fscanf(file, "%*[^\n]\n") == 0); /* the names */
  while (fscanf(file, "{\"%19[a-z]\": %lf, \"%*[a-z]\": [", word, &value) == 2) {
    const bool isState = strcmp(word, "energy") == 0;
    readPositions(file, scene->particleCount, isState ? state : trial);
    const double sum = sumOf(energy, scene, (const double(*)[3])(isState ? state : trial));
    CHECK(fabs((isState ? value : before + value) - sum) < 1e-3);
    before = isState ? sum : before;
    trials += !isState;
  }
  CHECK(trials == expected);
}

static void testRace(void) {
  Random random = {3};
  Scene* scene = chainRandom(SPHERES, &random);
  Energy* energy = makeEnergy(scene);
  EnergyRace race = {.scene = scene,
                     .energy = energy,
                     .rule = {movesGaussian, 0.3, 1},
                     .seed = 5,
                     .temperature = 300,
                     .trialCount = TRIALS,
                     .blockSize = BLOCK,
                     .record = tmpfile(),
                     .recordCount = 7};
  EnergyResult results[MOST_ENERGY_LANES];
  char error[200] = "";
  for (const EnergyContestant* c = energyContestants; c->name != NULL; c++) {
    CHECK(energyContestantFind(c->name) == c);
    race.contestants[race.laneCount++] = c;
  }
  CHECK(race.record != NULL && energyRaceRun(&race, results, error, sizeof error));
  for (int i = 0; i < race.laneCount; i++) {
    const EnergyResult* result = &results[i];
    int refused = 0;
    CHECK(result->reached[0] == result->free);
    for (int part = 0; part < CT_ENERGY_PARTS; part++) {
      const int next = part + 1 < CT_ENERGY_PARTS ? result->reached[part + 1] : result->accepted;
      CHECK(result->reached[part] - result->refused[part] == next);
      refused += result->refused[part];
    }
    CHECK(0 < refused && 0 < result->accepted && refused + result->accepted == result->free && result->free < TRIALS);
    CHECK(result->energy == results[0].energy && fabs(result->drift) < 1e-3);
    CHECK(result->microseconds > 0 && result->mean > 0);
  }
  checkRecord(race.record, energy, scene, race.recordCount);
  fclose(race.record);
  energyFree(energy);
  sceneFree(scene);
}

/* Trials that all clash are no race. */
static void testNoFreeTrial(void) {
  Random random = {3};
  Scene* scene = chainRandom(SPHERES, &random);
  for (int i = 0; i < scene->particleCount; i++) {
    scene->spheres[i].radius = 3;
  }
  Energy* energy = makeEnergy(scene);
  EnergyRace race = {.scene = scene,
                     .energy = energy,
                     .rule = {movesGaussian, 0.3, 1},
                     .temperature = 300,
                     .trialCount = 20,
                     .blockSize = 10,
                     .laneCount = 1,
                     .contestants = {&energyContestants[0]}};
  EnergyResult result;
  char error[200] = "";
  CHECK(!energyRaceRun(&race, &result, error, sizeof error) && strstr(error, "each of 20 trials clashes") != NULL);
  energyFree(energy);
  sceneFree(scene);
}

static void checkRefused(const Scene* scene, const char* beginning, int particles, const char* end) {
  char error[200] = "";
  writeEnergy(beginning, particles, end);
  CHECK(readEnergy(scene, error, sizeof error) == NULL && strstr(error, "is no energy of this scene") != NULL);
}

static void testReading(void) {
  Random random = {3};
  Scene* scene = chainRandom(SPHERES, &random);
  char error[200] = "";
  CHECK(energyRead("nowhere.txt", scene, error, sizeof error) == NULL && strstr(error, "cannot be read") != NULL);
  checkRefused(scene, "chaintree-energy 2\nparticles 60 exclusions 0 sets 0\n0 0 78.5\n", SPHERES, "");
  checkRefused(scene, "chaintree-energy 1\nparticles 59 exclusions 0 sets 0\n0 0 78.5\n", 59, "");
  checkRefused(scene, "chaintree-energy 1\nparticles 60 exclusions 0 sets 0\n0 0 78.5\n", 59, "");
  checkRefused(scene, "chaintree-energy 1\nparticles 60 exclusions 1 sets 0\n0 0 78.5\n", SPHERES, "0 60\n");
  checkRefused(scene, "chaintree-energy 1\nparticles 60 exclusions 0 sets 1\n0 0 78.5\n", SPHERES,
               "0 2 2 2\n0 1 4 1\n");
  checkRefused(scene, "chaintree-energy 1\nparticles 60 exclusions 0 sets 1\n0 0 78.5\n", SPHERES, "4 0 8 1\n");
  writeEnergy("chaintree-energy 1\nparticles 60 exclusions 0 sets 0\n0 0 78.5\n", SPHERES, "");
  Energy* energy = readEnergy(scene, error, sizeof error);
  CHECK(energy != NULL && isinf(energy->nonbonded.cutoff) && energy->setCount == 0);
  for (int i = 0; i < SPHERES; i++) {
    CHECK(energy->charges[i] == scene->particleNames[i] % 3 - 1.0);
  }
  energyFree(energy);
  sceneFree(scene);
}

int main(int argumentCount, char** arguments) {
  (void)argumentCount;
  snprintf(path, sizeof path, "%s.txt", arguments[0]);
  testRace();
  testNoFreeTrial();
  testReading();
  return checkResult();
}
