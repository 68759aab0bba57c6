/* The driver: asks contestants questions, and prints what it measures as lines of JSON. */
#include <stdio.h>
#include <string.h>

#include "chains.h"
#include "options.h"
#include "race.h"
#include "scenefile.h"
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

typedef struct Choice {
  int count;
  const Contestant* contestants[MOST_LANES];
} Choice;

static bool choose(const Options* options, Choice* choice, char* error, size_t size) {
  choice->count = 0;
  for (const char* name = options->contestants;;) {
    const size_t length = strcspn(name, ",");
    const Contestant* contestant = rosterFind(options->set, name, length);
    if (contestant == NULL) {
      snprintf(error, size, "there is no contestant %.*s", (int)length, name);
      return false;
    }
    if (options->measure == measureWhole && contestant->testAll == NULL) {
      snprintf(error, size, "%s does not test whole chains", contestant->name);
      return false;
    }
    if (choice->count == MOST_LANES) {
      snprintf(error, size, "there are more than %d contestants", MOST_LANES);
      return false;
    }
    choice->contestants[choice->count++] = contestant;
    if (name[length] == '\0') {
      return true;
    }
    name += length + 1;
  }
}

/* ---- Rows ---- */

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

/* What all rows begin with. */
static void printScene(const char* measure, const Options* options, const Scene* scene, int trials) {
  printf("{\"measure\": \"%s\", \"chain\": ", measure);
  printString(options->chain);
  printf(", \"particles\": %d, \"torsions\": %d, \"seed\": %llu, \"trials\": %d", scene->particleCount,
         scene->torsionCount, (unsigned long long)options->seed, trials);
}

static void printTimes(const char* contestant, const char* instructionSet, const Quartiles* microseconds) {
  printf(", \"contestant\": \"%s\", \"isa\": \"%s\", \"microseconds\": %.6g, \"quartiles\": [%.6g, %.6g]", contestant,
         instructionSet, microseconds->median, microseconds->first, microseconds->third);
}

static void printCounts(double volumeTests, double particleTests, double updates) {
  printf(", \"volumeTests\": %.6g, \"particleTests\": %.6g, \"updates\": %.6g", volumeTests, particleTests, updates);
}

/* Of a contestant that chooses none, it is the one that all are compiled for. */
static const char* setName(const Options* options, const char* chosen) {
  return chosen == NULL ? options->set->name : chosen;
}

/* ---- Measures ---- */

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

static bool runTrials(const Options* options, const Choice* choice, const Scene* scene, char* error, size_t size) {
  Race race = {.scene = scene,
               .rule = options->rule,
               .seed = options->seed,
               .trialCount = options->trialCount,
               .blockSize = options->blockSize,
               .seconds = options->seconds,
               .laneCount = choice->count,
               .judge = rosterFind(options->set, "lazygrid", strlen("lazygrid"))};
  memcpy(race.contestants, choice->contestants, sizeof race.contestants);
  RaceResult results[MOST_LANES];
  if (!beginRecord(options->record, &race.record, error, size)) {
    return false;
  }
  const bool success = raceRun(&race, results, error, size);
  if (!endRecord(options->record, race.record, error, size) || !success) {
    return false;
  }
  for (int i = 0; i < race.laneCount; i++) {
    printScene("trials", options, scene, results[i].trials);
    printf(", \"block\": %d, \"moves\": \"%s\", \"angle\": %.10g, \"kappa\": %d", race.blockSize, options->moves,
           race.rule.angle * 180 / PI, race.rule.kappa);
    printTimes(race.contestants[i]->name, setName(options, results[i].instructionSet), &results[i].microseconds);
    printCounts(results[i].volumeTests, results[i].particleTests, results[i].updates);
    printf(", \"accepted\": %.6g}\n", results[i].accepted);
  }
  return true;
}

static bool runWhole(const Options* options, const Choice* choice, const Scene* scene, char* error, size_t size) {
  WholeResult results[MOST_LANES];
  for (int i = 0; i < choice->count; i++) {
    if (!wholeRun(scene, choice->contestants[i], options->trialCount, &results[i])) {
      snprintf(error, size, "not enough memory for %s", choice->contestants[i]->name);
      return false;
    }
    if (results[i].clash != results[0].clash) {
      snprintf(error, size, "%s finds %s, %s does not", choice->contestants[i]->name,
               results[i].clash ? "a clash" : "no clash", choice->contestants[0]->name);
      return false;
    }
  }
  for (int i = 0; i < choice->count; i++) {
    const Counts* counts = &results[i].counts;
    printScene("whole", options, scene, options->trialCount);
    printTimes(choice->contestants[i]->name, setName(options, results[i].instructionSet), &results[i].microseconds);
    printCounts((double)counts->volumeTests, (double)counts->particleTests, (double)counts->updates);
    printf(", \"clash\": %s}\n", results[i].clash ? "true" : "false");
  }
  return true;
}

static void printContestants(const InstructionSet* set) {
  for (const Contestant* const* contestant = set->roster; *contestant != NULL; contestant++) {
    printf("{\"contestant\": \"%s\", \"idea\": ", (*contestant)->name);
    printString((*contestant)->idea);
    printf(", \"whole\": %s}\n", (*contestant)->testAll == NULL ? "false" : "true");
  }
}

static int fail(int status, const char* error) {
  fprintf(stderr, "openmm-chaintree-contestants: %s\n", error);
  return status;
}

int main(int argc, char** argv) {
  char error[TEXT_SIZE] = "";
  Options options;
  Choice choice;
  if (!optionsParse(argc, argv, &options, error, sizeof error)) {
    return fail(WRONG_USE, error);
  }
  if (options.help) {
    fputs(optionsUsage, stdout);
    return 0;
  }
  if (options.list) {
    printContestants(options.set);
    return 0;
  }
  if (!choose(&options, &choice, error, sizeof error)) {
    return fail(WRONG_USE, error);
  }
  Scene* scene = makeScene(&options, error, sizeof error);
  if (scene == NULL) {
    return fail(WRONG_USE, error);
  }
  const bool success = options.measure == measureWhole ? runWhole(&options, &choice, scene, error, sizeof error)
                                                       : runTrials(&options, &choice, scene, error, sizeof error);
  sceneFree(scene);
  return success ? 0 : fail(FAILED, error);
}
