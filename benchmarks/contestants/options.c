#include "options.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "random.h"

const char* const optionsUsage =
    "usage: openmm-chaintree-contestants [option value] ...\n"
    "\n"
    "Asks contestants the same questions, compares their answers, and prints a line of JSON for each contestant.\n"
    "\n"
    "--measure WHAT      trials: is the chain free of clashes after a change? The contestants take turns\n"
    "                    pairs: which particles are near each other, as they are?\n"
    "                    energy: by how much does a change alter the energy of --energy? [trials]\n"
    "--contestants LIST  names with commas between them [lazygrid,ours; cells,ours; ours,ours-stages]\n"
    "--chain NAME        random, hilbert or serpentine, or a file with a scene [random]\n"
    "--n COUNT           spheres of a chain that is not from a file [1000]\n"
    "--seed NUMBER       of the random chain and of the moves [1]\n"
    "--moves KIND        uniform, gaussian, biased, sidechain or sidechain-step [uniform]\n"
    "--angle DEGREES     standard deviation of Gaussian changes [5]\n"
    "--kappa COUNT       consecutive torsions that a trial turns [1]\n"
    "--trials COUNT      trials, or how often the question is asked [20000; 100; 2000]\n"
    "--block COUNT       trials of one contestant before the next has its turn [2000]\n"
    "--record FILE       write the scene and all trials there, as lines of JSON, for others to run them\n"
    "--recorded COUNT    of trials with their energies [16]\n"
    "--energy FILE       what a force field says of a scene from a file\n"
    "--temperature NUMBER  at which energies decide, K [300]\n"
    "--cutoff LENGTH     of pairs [0.8]\n"
    "--isa NAME          instruction set: avx512, avx2 or portable [the best that is here]\n"
    "--about             print a line of JSON about how the program was built instead\n"
    "--help\n";

/* Enough for a fast contestant to spend little of its turn refilling caches that slower ones emptied. */
enum { BLOCK_SIZE = 2000 };

/* By measure. */
static const char* const measureNames[] = {"trials", "pairs", "energy", NULL};
static const int defaultTrials[] = {20000, 100, 2000};
static const char* const defaultContestants[] = {"lazygrid,ours", "cells,ours", "ours,ours-stages"};

/* By MoveKind. */
static const char* const moveNames[] = {"uniform", "gaussian", "biased", "sidechain", "sidechain-step", NULL};

/* Where an option's value goes: one of the three, with its limits, or none for names. */
typedef struct Target {
  const char* option;
  int* integer;
  double* real;
  const char** text;
  double least;
  double most;
} Target;

/* Which of some names a text is; -1 if none. */
static int findName(const char* text, const char* const* names) {
  for (int i = 0; names[i] != NULL; i++) {
    if (strcmp(text, names[i]) == 0) {
      return i;
    }
  }
  return -1;
}

/* False if the value is no number within limits. */
static bool readNumber(const char* value, const Target* target) {
  char* end;
  const double parsed = strtod(value, &end);
  if (end == value || *end != '\0' || !(parsed >= target->least && parsed <= target->most)) {
    return false;
  }
  if (target->integer != NULL) {
    *target->integer = (int)parsed;
    return parsed == floor(parsed);
  }
  *target->real = parsed;
  return true;
}

static bool readValue(const char* option, const char* value, const Target* targets, Options* options) {
  int index = 0;
  if (strcmp(option, "--measure") == 0) {
    index = findName(value, measureNames);
    options->measure = index < 0 ? measureTrials : (Measure)index;
  } else if (strcmp(option, "--moves") == 0) {
    index = findName(value, moveNames);
    options->moves = value;
    options->rule.kind = index < 0 ? movesUniform : (MoveKind)index;
  } else if (strcmp(option, "--isa") == 0) {
    options->set = instructionSetFind(value);
    return options->set != NULL;
  } else {
    const Target* target = targets;
    while (target->option != NULL && strcmp(target->option, option) != 0) {
      target++;
    }
    if (target->text != NULL) {
      *target->text = value;
      return true;
    }
    return target->option != NULL && readNumber(value, target);
  }
  return index >= 0;
}

bool optionsParse(int argc, char** argv, Options* options, char* error, size_t size) {
  double degrees = 5;
  const double tiny = 1e-300;
  *options = (Options){.chain = "random",
                       .count = 1000,
                       .moves = "uniform",
                       .rule = {movesUniform, 0, 1},
                       .seed = 1,
                       .blockSize = BLOCK_SIZE,
                       .cutoff = 0.8,
                       .recordCount = 16,
                       .temperature = 300,
                       .set = instructionSetFind(NULL)};
  const Target targets[] = {
      {"--contestants", .text = &options->contestants},
      {"--chain", .text = &options->chain},
      {"--record", .text = &options->record},
      {"--energy", .text = &options->energy},
      {"--n", .integer = &options->count, .least = 4, .most = INT_MAX / 16},
      {"--seed", .integer = &options->seed, .least = 0, .most = INT_MAX},
      {"--kappa", .integer = &options->rule.kappa, .least = 1, .most = MOST_TURNS},
      {"--trials", .integer = &options->trialCount, .least = 1, .most = INT_MAX / 2},
      {"--block", .integer = &options->blockSize, .least = 1, .most = 1 << 20},
      {"--recorded", .integer = &options->recordCount, .least = 0, .most = INT_MAX},
      {"--angle", .real = &degrees, .least = tiny, .most = 180},
      {"--temperature", .real = &options->temperature, .least = tiny, .most = 1e6},
      {"--cutoff", .real = &options->cutoff, .least = tiny, .most = 1e6},
      {0},
  };
  for (int i = 1; i < argc; i += 2) {
    options->help = options->help || strcmp(argv[i], "--help") == 0;
    options->about = options->about || strcmp(argv[i], "--about") == 0;
    if (options->help || options->about) {
      return true;
    }
    if (i + 1 == argc || !readValue(argv[i], argv[i + 1], targets, options)) {
      snprintf(error, size, "%s %s: is no option with such a value; see --help", argv[i],
               i + 1 == argc ? "" : argv[i + 1]);
      return false;
    }
  }
  options->rule.angle = degrees * PI / 180;
  options->trialCount = options->trialCount > 0 ? options->trialCount : defaultTrials[options->measure];
  options->blockSize = options->blockSize < options->trialCount ? options->blockSize : options->trialCount;
  if (options->contestants == NULL) {
    options->contestants = defaultContestants[options->measure];
  }
  return true;
}
