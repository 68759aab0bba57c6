/* The driver: asks contestants questions, and prints what it measures as lines of JSON. */
#include <string.h>

#include "chains.h"
#include "energyrace.h"
#include "options.h"
#include "pairrace.h"
#include "race.h"

enum { FAILED = 1, WRONG_USE = 2, TEXT_SIZE = 512 };

static Scene* makeScene(const Options* options, char* error, size_t size) {
  Random random = {(uint64_t)options->seed};
  if (strcmp(options->chain, "random") == 0) {
    return chainRandom(options->count, &random);
  }
  if (strcmp(options->chain, "hilbert") == 0) {
    return chainHilbert(options->count);
  }
  if (strcmp(options->chain, "serpentine") == 0) {
    return chainSerpentine(options->count);
  }
  return sceneRead(options->chain, error, size);
}

/* Writes the contestants that the user names to `chosen`, and their number to `count`. */
#define CHOOSE(find, chosen, count, most)                                         \
  char names[TEXT_SIZE];                                                          \
  snprintf(names, sizeof names, "%s", options->contestants);                      \
  for (char* name = strtok(names, ","); name != NULL; name = strtok(NULL, ",")) { \
    if ((count) == (most) || (find) == NULL) {                                    \
      snprintf(error, size, "there is no contestant %s for this measure", name);  \
      return WRONG_USE;                                                           \
    }                                                                             \
    (chosen)[(count)++] = (find);                                                 \
  }

/* ---- Rows ---- */

static void beginRow(const Scene* scene, const char* contestant, const char* instructionSet, double microseconds,
                     int trials) {
  printf("{\"particles\": %d, \"contestant\": \"%s\", \"isa\": \"%s\", \"microseconds\": %.6g, \"trials\": %d",
         scene->particleCount, contestant, instructionSet, microseconds, trials);
}

static void printEnergy(const EnergyResult* result) {
  static const char* const parts[CT_ENERGY_PARTS] = {"terms", "near", "other"};
  printf(", \"mean\": %.6g, \"free\": %d, \"accepted\": %d", result->mean, result->free, result->accepted);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    printf(", \"%s\": {\"microseconds\": %.6g, \"reached\": %d, \"refused\": %d}", parts[part], result->parts[part],
           result->reached[part], result->refused[part]);
  }
  printf(", \"drift\": %.4g}\n", result->drift);
}

static void printBuild(const InstructionSet* set) {
  printf("{\"compiler\": \"%s\", \"flags\": \"%s\", \"isa\": \"%s\"}\n", BUILD_COMPILER, BUILD_FLAGS, set->name);
}

/* ---- Measures: each returns an exit status ---- */

/* False if the file cannot be written. */
static bool beginRecord(const char* path, FILE** record, char* error, size_t size) {
  *record = path == NULL ? NULL : fopen(path, "w");
  if (path != NULL && *record == NULL) {
    snprintf(error, size, "%s cannot be written", path);
  }
  return path == NULL || *record != NULL;
}

static bool endRecord(const char* path, FILE* record, char* error, size_t size) {
  const bool damaged = record != NULL && ferror(record) != 0;
  if ((record != NULL && fclose(record) != 0) || damaged) {
    snprintf(error, size, "%s could not be written to its end", path);
    return false;
  }
  return true;
}

static int runTrials(const Options* options, const Scene* scene, char* error, size_t size) {
  Race race = {.scene = scene,
               .rule = options->rule,
               .seed = (uint64_t)options->seed,
               .trialCount = options->trialCount,
               .blockSize = options->blockSize,
               .judge = contestantFind(options->set, "lazygrid")};
  RaceResult results[MOST_LANES];
  CHOOSE(contestantFind(options->set, name), race.contestants, race.laneCount, MOST_LANES)
  if (!beginRecord(options->record, &race.record, error, size)) {
    return FAILED;
  }
  const bool success = raceRun(&race, results, error, size);
  if (!endRecord(options->record, race.record, error, size) || !success) {
    return FAILED;
  }
  for (int i = 0; i < race.laneCount; i++) {
    const RaceResult* result = &results[i];
    const char* set = result->instructionSet == NULL ? options->set->name : result->instructionSet;
    beginRow(scene, race.contestants[i]->name, set, result->microseconds, race.trialCount);
    printf(", \"accepted\": %.6g, \"volumeTests\": %.6g, \"particleTests\": %.6g}\n", result->accepted,
           result->volumeTests, result->particleTests);
  }
  return 0;
}

static int runPairs(const Options* options, const Scene* scene, char* error, size_t size) {
  PairRace race = {
      .scene = scene, .cutoff = options->cutoff, .seed = (uint64_t)options->seed, .repeats = options->trialCount};
  PairResult results[MOST_PAIR_FINDERS];
  CHOOSE(pairFinderFind(options->set, name), race.finders, race.finderCount, MOST_PAIR_FINDERS)
  if (!pairRaceRun(&race, results, error, size)) {
    return FAILED;
  }
  for (int i = 0; i < race.finderCount; i++) {
    beginRow(scene, race.finders[i]->name, options->set->name, results[i].microseconds, race.repeats);
    printf(", \"pairs\": %d}\n", results[i].pairCount);
  }
  return 0;
}

static int runEnergy(const Options* options, const Scene* scene, char* error, size_t size) {
  EnergyRace race = {.scene = scene,
                     .rule = options->rule,
                     .seed = (uint64_t)options->seed,
                     .temperature = options->temperature,
                     .trialCount = options->trialCount,
                     .blockSize = options->blockSize,
                     .recordCount = options->recordCount};
  EnergyResult results[MOST_ENERGY_LANES];
  CHOOSE(energyContestantFind(name), race.contestants, race.laneCount, MOST_ENERGY_LANES)
  if (options->energy == NULL) {
    snprintf(error, size, "energies are measured of a scene with an --energy");
    return WRONG_USE;
  }
  Energy* energy = energyRead(options->energy, scene, error, size);
  if (energy == NULL) {
    return WRONG_USE;
  }
  race.energy = energy;
  bool success = beginRecord(options->record, &race.record, error, size);
  if (success) {
    success = energyRaceRun(&race, results, error, size);
    success = endRecord(options->record, race.record, error, size) && success;
  }
  for (int i = 0; i < race.laneCount && success; i++) {
    beginRow(scene, race.contestants[i]->name, results[i].instructionSet, results[i].microseconds, race.trialCount);
    printEnergy(&results[i]);
  }
  energyFree(energy);
  return success ? 0 : FAILED;
}

static int fail(int status, const char* error) {
  fprintf(stderr, "openmm-chaintree-contestants: %s\n", error);
  return status;
}

int main(int argc, char** argv) {
  static int (*const measures[])(const Options*, const Scene*, char*, size_t) = {runTrials, runPairs, runEnergy};
  char error[TEXT_SIZE] = "";
  Options options;
  if (!optionsParse(argc, argv, &options, error, sizeof error)) {
    return fail(WRONG_USE, error);
  }
  if (options.help) {
    fputs(optionsUsage, stdout);
    return 0;
  }
  if (options.about) {
    printBuild(options.set);
    return 0;
  }
  Scene* scene = makeScene(&options, error, sizeof error);
  if (scene == NULL) {
    return fail(WRONG_USE, error);
  }
  const int status = measures[options.measure](&options, scene, error, sizeof error);
  sceneFree(scene);
  return status == 0 ? 0 : fail(status, error);
}
