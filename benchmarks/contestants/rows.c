#include "rows.h"

#include <stdio.h>

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

void rowBegin(const char* measure, const Options* options, const Scene* scene, int trials) {
  printf("{\"measure\": \"%s\", \"chain\": ", measure);
  printString(options->chain);
  printf(", \"particles\": %d, \"torsions\": %d, \"seed\": %llu, \"trials\": %d", scene->particleCount,
         scene->torsionCount, (unsigned long long)options->seed, trials);
}

void rowTimes(const char* contestant, const char* instructionSet, const Quartiles* microseconds) {
  printf(", \"contestant\": \"%s\", \"isa\": \"%s\", \"microseconds\": %.6g, \"quartiles\": [%.6g, %.6g]", contestant,
         instructionSet, microseconds->median, microseconds->first, microseconds->third);
}

void rowCounts(double volumeTests, double particleTests, double updates) {
  printf(", \"volumeTests\": %.6g, \"particleTests\": %.6g, \"updates\": %.6g", volumeTests, particleTests, updates);
}

static void printError(const char* name, const Error* error) {
  printf("\"%s\": {\"largest\": %.4g, \"rms\": %.4g}", name, error->largest, error->rms);
}

static void printErrors(const char* name, const Errors* errors) {
  printf(", \"%s\": {", name);
  printError("distances", &errors->distances);
  printf(", ");
  printError("bonds", &errors->bonds);
  printf(", ");
  printError("angles", &errors->angles);
  printf(", ");
  printError("torsions", &errors->torsions);
  printf("}");
}

void rowDrift(const DriftResult* result) {
  printf(", \"stations\": [");
  for (int i = 0; i < result->stationCount; i++) {
    const Station* station = &result->stations[i];
    printf("%s{\"turns\": %d, \"size\": %.6g, \"bits\": \"%016llx\"", i == 0 ? "" : ", ", station->turns, station->size,
           (unsigned long long)station->bits);
    printErrors("ofTurns", &station->ofTurns);
    if (result->keepsAngles) {
      printErrors("ofAngles", &station->ofAngles);
    }
    printf("}");
  }
  printf("]}\n");
}

void rowTouch(const TouchResult* result) {
  printf(
      ", \"clashes\": %d, \"missed\": %d, \"largestMissed\": %.4g, \"gaps\": %d, \"invented\": %d, "
      "\"largestInvented\": %.4g}\n",
      result->clashes, result->missed, result->largestMissed, result->gaps, result->invented, result->largestInvented);
}

void rowEnergy(const EnergyResult* result) {
  static const char* const parts[CT_ENERGY_PARTS] = {"terms", "near", "other"};
  printf(", \"mean\": %.6g, \"free\": %d, \"accepted\": %d, \"acceptance\": %.6g, \"refresh\": %.6g", result->mean,
         result->free, result->accepted, result->acceptance, result->refresh);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    printf(", \"%s\": {\"microseconds\": %.6g, \"reached\": %d, \"refused\": %d}", parts[part], result->parts[part],
           result->reached[part], result->refused[part]);
  }
  printf(", \"drift\": %.4g, \"treeBytes\": %lld, \"bytes\": %lld}\n", result->drift, (long long)result->treeBytes,
         (long long)result->energyBytes);
}

static void printContestant(const char* measure, const char* name, const char* idea) {
  printf("{\"measure\": \"%s\", \"contestant\": \"%s\", \"idea\": ", measure, name);
  printString(idea);
}

void rowOfBuild(const InstructionSet* set) {
  printf("{\"compiler\": ");
  printString(BUILD_COMPILER);
  printf(", \"buildType\": ");
  printString(BUILD_TYPE);
  printf(", \"flags\": ");
  printString(BUILD_FLAGS);
  printf(", \"flagsAvx2\": ");
  printString(BUILD_FLAGS_AVX2);
  printf(", \"flagsAvx512\": ");
  printString(BUILD_FLAGS_AVX512);
  printf(", \"isa\": \"%s\", \"contestantsIsa\": \"%s\"}\n", set->name, set->contestantsName);
}

void rowsOfContestants(const InstructionSet* set) {
  for (const Contestant* const* c = set->contestants; *c != NULL; c++) {
    printContestant("trials", (*c)->name, (*c)->idea);
    printf(", \"whole\": %s}\n", (*c)->testAll == NULL ? "false" : "true");
  }
  for (const PairFinder* const* c = set->pairFinders; *c != NULL; c++) {
    printContestant("pairs", (*c)->name, (*c)->idea);
    printf(", \"sorted\": %s}\n", (*c)->order == pairsSorted ? "true" : "false");
  }
  for (const NearestFinder* const* c = set->nearestFinders; *c != NULL; c++) {
    printContestant("nearest", (*c)->name, (*c)->idea);
    printf("}\n");
  }
  for (const Kinematics* const* c = set->kinematics; *c != NULL; c++) {
    printContestant("drift", (*c)->name, (*c)->idea);
    printf("}\n");
  }
  for (const Contestant* const* c = set->precisions; *c != NULL; c++) {
    printContestant("touch", (*c)->name, (*c)->idea);
    printf("}\n");
  }
  for (const EnergyContestant* c = energyContestants; c->name != NULL; c++) {
    printContestant("energy", c->name, c->idea);
    printf("}\n");
  }
}
