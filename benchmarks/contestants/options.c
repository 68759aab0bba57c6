#include "options.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* So many that a fast contestant spends little of its turn refilling the caches that slower ones have emptied. */
enum { BLOCK_SIZE = 2000 };

/* By measure. */
static const int defaultTrials[] = {20000, 5, 100, 100, 100000, 1400, 2000};
static const char* const defaultContestants[] = {"lazygrid,ours",   "published,ours",          "cells,ours",
                                                 "brute,ours",      "cartesian,ours-portable", "volumes-single,ours",
                                                 "ours,ours-stages"};

const char* const optionsUsage =
    "usage: openmm-chaintree-contestants [option value] ...\n"
    "\n"
    "Asks contestants the same questions, compares their answers, and prints a line of JSON for each contestant.\n"
    "\n"
    "--measure WHAT      trials: is the chain free of clashes after a change? The contestants take turns\n"
    "                    whole: is it free of clashes as it is?\n"
    "                    pairs: which particles are near each other, as they are?\n"
    "                    nearest: how near do obstacles come?\n"
    "                    drift: how wrong have positions become after so many turns?\n"
    "                    touch: is the chain free of clashes where particles all but touch?\n"
    "                    energy: by how much does a change alter the energy of --energy?\n"
    "                    [trials]\n"
    "--contestants LIST  names with commas between them\n"
    "                    [lazygrid,ours; published,ours; cells,ours; brute,ours; cartesian,ours-portable;\n"
    "                    volumes-single,ours; ours,ours-stages]\n"
    "--chain NAME        random, hilbert, serpentine or worst, or a file with a scene, - for the standard input\n"
    "                    [random]\n"
    "--n COUNT           spheres of a chain that is not from a file [1000]\n"
    "--seed NUMBER       of the random chain and of the moves [1]\n"
    "--moves KIND        uniform, gaussian, biased, sidechain or sidechain-step [uniform]\n"
    "--angle DEGREES     standard deviation of Gaussian changes [5]\n"
    "--kappa COUNT       consecutive torsions that a trial turns [1]\n"
    "--trials COUNT      trials, or how often the question is asked, or turns [20000, 5, 100, 100, 100000, 1400,\n"
    "                    2000]\n"
    "--block COUNT       trials of one contestant before the next has its turn [2000]\n"
    "--positions WHEN    each: all positions are read after each trial that is taken over, which counts; where a\n"
    "                    contestant keeps them, up to a motion of them all, they cost nothing. none: they are not\n"
    "                    read [none]\n"
    "--seconds NUMBER    ends trials sooner, with the block in which contestants have taken that long together: the\n"
    "                    rows are then marked incomplete;\n"
    "                    drift, where the next ten times as many turns would take a contestant more than its share;\n"
    "                    and touch, with what is searched for\n"
    "--record FILE       write the scene and all trials there, as lines of JSON, for others to run them\n"
    "--recorded COUNT    of trials with their energies [16]\n"
    "--energy FILE       what a force field says of a scene from a file\n"
    "--temperature NUMBER  at which energies decide, K [300]\n"
    "--cutoff LENGTH     of pairs [0.8]\n"
    "--obstacles COUNT   [1000]\n"
    "--isa NAME          instruction set: avx512, avx2 or portable [the best that is here]\n"
    "--list              print a line of JSON about each contestant instead\n"
    "--about             print a line of JSON about how the program was built instead\n"
    "--help\n";

static bool fail(char* error, size_t size, const char* option, const char* value, const char* expected) {
  snprintf(error, size, "%s %s: expected %s", option, value, expected);
  return false;
}

static bool parseInt(const char* text, int least, int most, int* value) {
  char* end;
  errno = 0;
  const long parsed = strtol(text, &end, 10);
  if (end == text || *end != '\0' || errno != 0 || parsed < least || parsed > most) {
    return false;
  }
  *value = (int)parsed;
  return true;
}

static bool parseSeed(const char* text, uint64_t* value) {
  char* end;
  errno = 0;
  const unsigned long long parsed = strtoull(text, &end, 10);
  *value = parsed;
  return end != text && *end == '\0' && errno == 0 && *text != '-';
}

static bool parseReal(const char* text, double most, double* value) {
  char* end;
  *value = strtod(text, &end);
  return end != text && *end == '\0' && *value > 0 && *value <= most;
}

/* Which of some names a text is; -1 if none. */
static int parseName(const char* text, const char* const* names, int count) {
  for (int i = 0; i < count; i++) {
    if (strcmp(text, names[i]) == 0) {
      return i;
    }
  }
  return -1;
}

static bool parseMeasure(const char* text, Measure* measure) {
  static const char* const names[] = {"trials", "whole", "pairs", "nearest", "drift", "touch", "energy"};
  static const Measure measures[] = {measureTrials, measureWhole, measurePairs, measureNearest,
                                     measureDrift,  measureTouch, measureEnergy};
  const int index = parseName(text, names, 7);
  *measure = index < 0 ? measureTrials : measures[index];
  return index >= 0;
}

static bool parseMoves(const char* text, MoveKind* kind) {
  static const char* const names[] = {"uniform", "gaussian", "biased", "sidechain", "sidechain-step"};
  static const MoveKind kinds[] = {movesUniform, movesGaussian, movesBiased, movesSideChain, movesSideChainStep};
  const int index = parseName(text, names, 5);
  *kind = index < 0 ? movesUniform : kinds[index];
  return index >= 0;
}

static bool parseOption(const char* name, const char* value, Options* options, char* error, size_t size) {
  if (strcmp(name, "--measure") == 0) {
    return parseMeasure(value, &options->measure) ||
           fail(error, size, name, value, "trials, whole, pairs, nearest, drift, touch or energy");
  }
  if (strcmp(name, "--contestants") == 0) {
    options->contestants = value;
    return true;
  }
  if (strcmp(name, "--chain") == 0) {
    options->chain = value;
    return true;
  }
  if (strcmp(name, "--n") == 0) {
    return parseInt(value, 4, INT_MAX / 16, &options->count) ||
           fail(error, size, name, value, "a whole number of at least 4");
  }
  if (strcmp(name, "--seed") == 0) {
    return parseSeed(value, &options->seed) || fail(error, size, name, value, "a whole number");
  }
  if (strcmp(name, "--moves") == 0) {
    options->moves = value;
    return parseMoves(value, &options->rule.kind) ||
           fail(error, size, name, value, "uniform, gaussian, biased, sidechain or sidechain-step");
  }
  if (strcmp(name, "--angle") == 0) {
    double degrees;
    const bool success = parseReal(value, 180, &degrees);
    options->rule.angle = degrees * PI / 180;
    return success || fail(error, size, name, value, "a positive number of degrees up to 180");
  }
  if (strcmp(name, "--kappa") == 0) {
    return parseInt(value, 1, MOST_TURNS, &options->rule.kappa) ||
           fail(error, size, name, value, "a whole number from 1 to 64");
  }
  if (strcmp(name, "--trials") == 0) {
    return parseInt(value, 1, INT_MAX / 2, &options->trialCount) ||
           fail(error, size, name, value, "a positive whole number");
  }
  if (strcmp(name, "--block") == 0) {
    return parseInt(value, 1, 1 << 20, &options->blockSize) ||
           fail(error, size, name, value, "a positive whole number up to 1048576");
  }
  if (strcmp(name, "--seconds") == 0) {
    return parseReal(value, INFINITY, &options->seconds) || fail(error, size, name, value, "a positive number");
  }
  if (strcmp(name, "--positions") == 0) {
    options->readsPositions = strcmp(value, "each") == 0;
    return options->readsPositions || strcmp(value, "none") == 0 || fail(error, size, name, value, "each or none");
  }
  if (strcmp(name, "--record") == 0) {
    options->record = value;
    return true;
  }
  if (strcmp(name, "--recorded") == 0) {
    return parseInt(value, 0, INT_MAX, &options->recordCount) || fail(error, size, name, value, "a whole number");
  }
  if (strcmp(name, "--energy") == 0) {
    options->energy = value;
    return true;
  }
  if (strcmp(name, "--temperature") == 0) {
    return parseReal(value, 1e6, &options->temperature) || fail(error, size, name, value, "a positive number of K");
  }
  if (strcmp(name, "--cutoff") == 0) {
    return parseReal(value, 1e6, &options->cutoff) || fail(error, size, name, value, "a positive length");
  }
  if (strcmp(name, "--obstacles") == 0) {
    return parseInt(value, 1, INT_MAX / 16, &options->obstacleCount) ||
           fail(error, size, name, value, "a positive whole number");
  }
  if (strcmp(name, "--isa") == 0) {
    options->set = instructionSetFind(value);
    return options->set != NULL || fail(error, size, name, value, "an instruction set that this machine has");
  }
  snprintf(error, size, "there is no option %s", name);
  return false;
}

bool optionsParse(int argc, char** argv, Options* options, char* error, size_t size) {
  *options = (Options){.measure = measureTrials,
                       .chain = "random",
                       .count = 1000,
                       .moves = "uniform",
                       .rule = {movesUniform, 5 * PI / 180, 1},
                       .seed = 1,
                       .blockSize = BLOCK_SIZE,
                       .seconds = INFINITY,
                       .cutoff = 0.8,
                       .recordCount = 16,
                       .temperature = 300,
                       .obstacleCount = 1000,
                       .set = instructionSetFind(NULL)};
  for (int i = 1; i < argc; i += 2) {
    options->help = strcmp(argv[i], "--help") == 0;
    options->list = strcmp(argv[i], "--list") == 0;
    options->about = strcmp(argv[i], "--about") == 0;
    if (options->help || options->list || options->about) {
      return true;
    }
    if (i + 1 == argc) {
      snprintf(error, size, "%s stands without a value", argv[i]);
      return false;
    }
    if (!parseOption(argv[i], argv[i + 1], options, error, size)) {
      return false;
    }
  }
  if (options->trialCount == 0) {
    options->trialCount = defaultTrials[options->measure];
  }
  if (options->contestants == NULL) {
    options->contestants = defaultContestants[options->measure];
  }
  if (options->blockSize > options->trialCount) {
    options->blockSize = options->trialCount;
  }
  return true;
}
