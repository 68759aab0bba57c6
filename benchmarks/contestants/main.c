/* The driver: asks contestants questions, and prints what it measures as lines of JSON. */
#include <stdio.h>
#include <string.h>

#include "chains.h"
#include "driftrace.h"
#include "energyrace.h"
#include "nearestrace.h"
#include "options.h"
#include "pairrace.h"
#include "race.h"
#include "rows.h"
#include "scenefile.h"
#include "touchrace.h"
#include "whole.h"

enum { FAILED = 1, WRONG_USE = 2, TEXT_SIZE = 512 };

static Scene* makeScene(const Options* options, char* error, size_t size) {
  Random random = {options->seed};
  Scene* scene;
  if (strcmp(options->chain, "random") == 0) {
    scene = chainRandom(options->count, &random);
  } else if (strcmp(options->chain, "hilbert") == 0) {
    scene = chainHilbert(options->count);
  } else if (strcmp(options->chain, "serpentine") == 0) {
    scene = chainSerpentine(options->count);
  } else if (strcmp(options->chain, "worst") == 0) {
    scene = chainWorstCase(options->count);
  } else {
    return sceneRead(options->chain, error, size);
  }
  if (scene == NULL) {
    snprintf(error, size, "the chain %s of %d spheres cannot be made: too short, or not enough memory", options->chain,
             options->count);
  }
  return scene;
}

/* The next of some names with commas between them; `list` is what is left, NULL behind the last. */
static const char* nextName(const char** list, size_t* length) {
  const char* name = *list;
  *length = strcspn(name, ",");
  *list = name[*length] == '\0' ? NULL : name + *length + 1;
  return name;
}

static bool isPossible(bool found, int count, int most, const char* name, size_t length, char* error, size_t size) {
  if (!found) {
    snprintf(error, size, "there is no contestant %.*s for this measure", (int)length, name);
  } else if (count == most) {
    snprintf(error, size, "there are more than %d contestants", most);
  }
  return found && count < most;
}

/* Takes those that the user names, found by `find`, or ends a measure. */
#define CHOOSE(find, chosen, count, most)                                 \
  for (const char* list = options->contestants; list != NULL;) {          \
    size_t length;                                                        \
    const char* name = nextName(&list, &length);                          \
    const bool found = (find)(options->set, name, length) != NULL;        \
    if (!isPossible(found, (count), (most), name, length, error, size)) { \
      return WRONG_USE;                                                   \
    }                                                                     \
    (chosen)[(count)++] = (find)(options->set, name, length);             \
  }

/* ---- Measures: each returns an exit status ---- */

/* The one that a contestant has chosen, or, if it chooses none, is compiled for. */
static const char* setName(const Options* options, const char* chosen) {
  return chosen == NULL ? options->set->contestantsName : chosen;
}

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
               .seed = options->seed,
               .trialCount = options->trialCount,
               .blockSize = options->blockSize,
               .seconds = options->seconds,
               .readsPositions = options->readsPositions,
               .judge = contestantFind(options->set, "lazygrid", strlen("lazygrid"))};
  RaceResult results[MOST_LANES];
  CHOOSE(contestantFind, race.contestants, race.laneCount, MOST_LANES)
  if (!beginRecord(options->record, &race.record, error, size)) {
    return FAILED;
  }
  const bool success = raceRun(&race, results, error, size);
  if (!endRecord(options->record, race.record, error, size) || !success) {
    return FAILED;
  }
  for (int i = 0; i < race.laneCount; i++) {
    rowBegin("trials", options, scene, results[i].trials);
    printf(", \"asked\": %d, \"complete\": %s, \"block\": %d, \"moves\": \"%s\", \"angle\": %.10g, \"kappa\": %d",
           race.trialCount, results[i].trials == race.trialCount ? "true" : "false", race.blockSize, options->moves,
           race.rule.angle * 180 / PI, race.rule.kappa);
    printf(", \"positions\": \"%s\", \"rgOfScene\": %.6g, \"rg\": [%.6g, %.6g]", race.readsPositions ? "each" : "none",
           results[i].gyration[0], results[i].gyration[1], results[i].gyration[2]);
    rowTimes(race.contestants[i]->name, setName(options, results[i].instructionSet), &results[i].microseconds);
    rowCounts(results[i].volumeTests, results[i].particleTests, results[i].updates);
    printf(", \"accepted\": %.6g, \"bytes\": %lld}\n", results[i].accepted, (long long)results[i].bytes);
  }
  return 0;
}

/* A contestant that tests whole chains. */
static const Contestant* wholeFind(const InstructionSet* set, const char* name, size_t length) {
  const Contestant* found = contestantFind(set, name, length);
  return found == NULL || found->testAll == NULL ? NULL : found;
}

static int runWhole(const Options* options, const Scene* scene, char* error, size_t size) {
  const Contestant* contestants[MOST_LANES];
  WholeResult results[MOST_LANES];
  int count = 0;
  CHOOSE(wholeFind, contestants, count, MOST_LANES)
  for (int i = 0; i < count; i++) {
    if (!wholeRun(scene, contestants[i], options->trialCount, &results[i])) {
      snprintf(error, size, "not enough memory for %s", contestants[i]->name);
      return FAILED;
    }
    if (results[i].clash != results[0].clash) {
      snprintf(error, size, "%s finds %s, %s does not", contestants[i]->name, results[i].clash ? "a clash" : "no clash",
               contestants[0]->name);
      return FAILED;
    }
  }
  for (int i = 0; i < count; i++) {
    const Counts* counts = &results[i].counts;
    rowBegin("whole", options, scene, options->trialCount);
    rowTimes(contestants[i]->name, setName(options, results[i].instructionSet), &results[i].microseconds);
    rowCounts((double)counts->volumeTests, (double)counts->particleTests, (double)counts->updates);
    printf(", \"clash\": %s}\n", results[i].clash ? "true" : "false");
  }
  return 0;
}

static int runPairs(const Options* options, const Scene* scene, char* error, size_t size) {
  PairRace race = {.scene = scene, .cutoff = options->cutoff, .seed = options->seed, .repeats = options->trialCount};
  PairResult results[MOST_PAIR_FINDERS];
  CHOOSE(pairFinderFind, race.finders, race.finderCount, MOST_PAIR_FINDERS)
  if (!pairRaceRun(&race, results, error, size)) {
    return FAILED;
  }
  for (int i = 0; i < race.finderCount; i++) {
    rowBegin("pairs", options, scene, options->trialCount);
    rowTimes(race.finders[i]->name, options->set->name, &results[i].microseconds);
    printf(", \"sorted\": %s, \"cutoff\": %.10g, \"pairs\": %d}\n",
           race.finders[i]->order == pairsSorted ? "true" : "false", race.cutoff, results[i].pairCount);
  }
  return 0;
}

static int runNearest(const Options* options, const Scene* scene, char* error, size_t size) {
  NearestRace race = {
      .scene = scene, .obstacleCount = options->obstacleCount, .seed = options->seed, .repeats = options->trialCount};
  Quartiles microseconds[MOST_NEAREST_FINDERS];
  CHOOSE(nearestFinderFind, race.finders, race.finderCount, MOST_NEAREST_FINDERS)
  if (!nearestRaceRun(&race, microseconds, error, size)) {
    return FAILED;
  }
  for (int i = 0; i < race.finderCount; i++) {
    rowBegin("nearest", options, scene, options->trialCount);
    rowTimes(race.finders[i]->name, options->set->name, &microseconds[i]);
    printf(", \"obstacles\": %d}\n", race.obstacleCount);
  }
  return 0;
}

static int runDrift(const Options* options, const Scene* scene, char* error, size_t size) {
  DriftRace race = {.scene = scene,
                    .rule = options->rule,
                    .seed = options->seed,
                    .turnCount = options->trialCount,
                    .seconds = options->seconds};
  DriftResult results[MOST_DRIFT_LANES];
  if (race.rule.kappa != 1 || race.rule.kind == movesBiased) {
    snprintf(error, size, "drift is measured of moves that turn one torsion, not biased");
    return WRONG_USE;
  }
  CHOOSE(kinematicsFind, race.paths, race.laneCount, MOST_DRIFT_LANES)
  if (!driftRaceRun(&race, results, error, size)) {
    return FAILED;
  }
  for (int i = 0; i < race.laneCount; i++) {
    rowBegin("drift", options, scene, results[i].stations[results[i].stationCount - 1].turns);
    printf(", \"moves\": \"%s\", \"angle\": %.10g", options->moves, race.rule.angle * 180 / PI);
    rowTimes(race.paths[i]->name, setName(options, results[i].instructionSet), &results[i].microseconds);
    rowDrift(&results[i]);
  }
  return 0;
}

static int runTouch(const Options* options, const Scene* scene, char* error, size_t size) {
  TouchRace race = {.scene = scene,
                    .seed = options->seed,
                    .trialCount = options->trialCount,
                    .seconds = options->seconds,
                    .judge = contestantFind(options->set, "lazygrid", strlen("lazygrid"))};
  TouchResult results[MOST_TOUCH_LANES];
  CHOOSE(precisionFind, race.contestants, race.laneCount, MOST_TOUCH_LANES)
  if (!touchRaceRun(&race, results, error, size)) {
    return FAILED;
  }
  for (int i = 0; i < race.laneCount; i++) {
    rowBegin("touch", options, scene, results[i].clashes + results[i].gaps);
    rowTimes(race.contestants[i]->name, setName(options, results[i].instructionSet), &results[i].microseconds);
    rowTouch(&results[i]);
  }
  return 0;
}

/* Any set: a contestant chooses its own. */
static const EnergyContestant* energyFind(const InstructionSet* set, const char* name, size_t length) {
  (void)set;
  return energyContestantFind(name, length);
}

static int runEnergy(const Options* options, const Scene* scene, char* error, size_t size) {
  EnergyRace race = {.scene = scene,
                     .rule = options->rule,
                     .seed = options->seed,
                     .temperature = options->temperature,
                     .trialCount = options->trialCount,
                     .blockSize = options->blockSize,
                     .recordCount = options->recordCount};
  EnergyResult results[MOST_ENERGY_LANES];
  CHOOSE(energyFind, race.contestants, race.laneCount, MOST_ENERGY_LANES)
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
    rowBegin("energy", options, scene, options->trialCount);
    printf(", \"moves\": \"%s\", \"angle\": %.10g, \"kappa\": %d, \"block\": %d", options->moves,
           race.rule.angle * 180 / PI, race.rule.kappa, race.blockSize);
    rowTimes(race.contestants[i]->name, results[i].instructionSet, &results[i].microseconds);
    rowEnergy(&results[i]);
  }
  energyFree(energy);
  return success ? 0 : FAILED;
}

static int run(const Options* options, const Scene* scene, char* error, size_t size) {
  switch (options->measure) {
    case measureWhole:
      return runWhole(options, scene, error, size);
    case measurePairs:
      return runPairs(options, scene, error, size);
    case measureNearest:
      return runNearest(options, scene, error, size);
    case measureDrift:
      return runDrift(options, scene, error, size);
    case measureTouch:
      return runTouch(options, scene, error, size);
    case measureEnergy:
      return runEnergy(options, scene, error, size);
    default:
      return runTrials(options, scene, error, size);
  }
}

static int fail(int status, const char* error) {
  fprintf(stderr, "openmm-chaintree-contestants: %s\n", error);
  return status;
}

int main(int argc, char** argv) {
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
    rowOfBuild(options.set);
    return 0;
  }
  if (options.list) {
    rowsOfContestants(options.set);
    return 0;
  }
  Scene* scene = makeScene(&options, error, sizeof error);
  if (scene == NULL) {
    return fail(WRONG_USE, error);
  }
  const int status = run(&options, scene, error, sizeof error);
  sceneFree(scene);
  return status == 0 ? 0 : fail(status, error);
}
