/* The driver: runs contestants and prints what it measures as lines of JSON. */
#include <stdio.h>
#include <string.h>

#include "chains.h"
#include "options.h"
#include "race.h"
#include "scenefile.h"

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

static bool chooseContestants(const Options* options, Race* race, char* error, size_t size) {
  for (const char* name = options->contestants;;) {
    const size_t length = strcspn(name, ",");
    const Contestant* contestant = rosterFind(options->set, name, length);
    if (contestant == NULL) {
      snprintf(error, size, "there is no contestant %.*s", (int)length, name);
      return false;
    }
    if (race->laneCount == MOST_LANES) {
      snprintf(error, size, "more than %d contestants", MOST_LANES);
      return false;
    }
    race->contestants[race->laneCount++] = contestant;
    if (name[length] == '\0') {
      return true;
    }
    name += length + 1;
  }
}

static void printString(const char* text) {
  putchar('"');
  for (const char* c = text; *c != '\0'; c++) {
    if (*c == '"' || *c == '\\' || (unsigned char)*c < ' ') {
      printf("\\u%04x", (unsigned)*c);
    } else {
      putchar(*c);
    }
  }
  putchar('"');
}

static void printResult(const Options* options, const Race* race, const Contestant* contestant,
                        const RaceResult* result) {
  printf("{\"chain\": ");
  printString(options->chain);
  printf(", \"particles\": %d, \"torsions\": %d, \"moves\": \"%s\", \"angle\": %.10g, \"kappa\": %d",
         race->scene->particleCount, race->scene->torsionCount, options->moves, race->rule.angle * 180 / PI,
         race->rule.kappa);
  printf(", \"seed\": %llu, \"trials\": %d, \"block\": %d, \"isa\": \"%s\", \"contestant\": \"%s\"",
         (unsigned long long)race->seed, race->trialCount, race->blockSize, options->set->name, contestant->name);
  printf(", \"microseconds\": %.6g, \"quartiles\": [%.6g, %.6g], \"accepted\": %.6g", result->median,
         result->quartiles[0], result->quartiles[1], result->accepted);
  printf(", \"volumeTests\": %.6g, \"particleTests\": %.6g, \"updates\": %.6g}\n", result->volumeTests,
         result->particleTests, result->updates);
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
  Race race = {.rule = options.rule,
               .seed = options.seed,
               .trialCount = options.trialCount,
               .blockSize = options.blockSize,
               .judge = rosterFind(options.set, "lazygrid", strlen("lazygrid"))};
  if (!chooseContestants(&options, &race, error, sizeof error)) {
    return fail(WRONG_USE, error);
  }
  Scene* scene = makeScene(&options, error, sizeof error);
  if (scene == NULL) {
    return fail(WRONG_USE, error);
  }
  race.scene = scene;
  RaceResult results[MOST_LANES];
  const bool success = raceRun(&race, results, error, sizeof error);
  for (int i = 0; i < race.laneCount && success; i++) {
    printResult(&options, &race, race.contestants[i], &results[i]);
  }
  sceneFree(scene);
  return success ? 0 : fail(FAILED, error);
}
