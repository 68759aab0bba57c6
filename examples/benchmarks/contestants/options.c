#include "options.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char* const optionsUsage =
    "usage: openmm-chaintree-contestants [option value] ...\n"
    "\n"
    "Runs contestants on the same trials in turns, compares what they say of each, and prints a line of JSON for "
    "each.\n"
    "\n"
    "--chain NAME        random, hilbert, serpentine, worst, or a file with a scene, - for the standard input "
    "[random]\n"
    "--n COUNT           spheres of a chain that is not from a file [1000]\n"
    "--moves KIND        uniform, gaussian, biased or sidechain [uniform]\n"
    "--angle DEGREES     standard deviation of Gaussian changes [5]\n"
    "--kappa COUNT       consecutive torsions that a trial turns [1]\n"
    "--trials COUNT      [20000]\n"
    "--block COUNT       trials of one contestant before the next has its turn [200]\n"
    "--contestants LIST  names with commas between them [lazygrid,ours]\n"
    "--seed NUMBER       of the random chain and of the moves [1]\n"
    "--isa NAME          avx2 or portable [the best that is here]\n"
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

static bool parseAngle(const char* text, double* value) {
  char* end;
  const double degrees = strtod(text, &end);
  *value = degrees * PI / 180;
  return end != text && *end == '\0' && degrees > 0 && degrees <= 180;
}

static bool parseMoves(const char* text, MoveKind* kind) {
  static const char* const names[] = {"uniform", "gaussian", "biased", "sidechain"};
  static const MoveKind kinds[] = {movesUniform, movesGaussian, movesBiased, movesSideChain};
  for (int i = 0; i < 4; i++) {
    if (strcmp(text, names[i]) == 0) {
      *kind = kinds[i];
      return true;
    }
  }
  return false;
}

static bool parseOption(const char* name, const char* value, Options* options, char* error, size_t size) {
  if (strcmp(name, "--chain") == 0) {
    options->chain = value;
    return true;
  }
  if (strcmp(name, "--contestants") == 0) {
    options->contestants = value;
    return true;
  }
  if (strcmp(name, "--n") == 0) {
    return parseInt(value, 4, INT_MAX / 16, &options->count) ||
           fail(error, size, name, value, "a whole number of at least 4");
  }
  if (strcmp(name, "--moves") == 0) {
    options->moves = value;
    return parseMoves(value, &options->rule.kind) ||
           fail(error, size, name, value, "uniform, gaussian, biased or sidechain");
  }
  if (strcmp(name, "--angle") == 0) {
    return parseAngle(value, &options->rule.angle) ||
           fail(error, size, name, value, "a positive number of degrees up to 180");
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
  if (strcmp(name, "--seed") == 0) {
    return parseSeed(value, &options->seed) || fail(error, size, name, value, "a whole number");
  }
  if (strcmp(name, "--isa") == 0) {
    options->set = instructionSetFind(value);
    return options->set != NULL || fail(error, size, name, value, "an instruction set that this machine has");
  }
  snprintf(error, size, "there is no option %s", name);
  return false;
}

bool optionsParse(int argc, char** argv, Options* options, char* error, size_t size) {
  *options = (Options){.chain = "random",
                       .count = 1000,
                       .moves = "uniform",
                       .rule = {movesUniform, 5 * PI / 180, 1},
                       .seed = 1,
                       .trialCount = 20000,
                       .blockSize = 200,
                       .contestants = "lazygrid,ours",
                       .set = instructionSetFind(NULL)};
  for (int i = 1; i < argc; i += 2) {
    if (strcmp(argv[i], "--help") == 0) {
      options->help = true;
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
  if (options->blockSize > options->trialCount) {
    options->blockSize = options->trialCount;
  }
  return true;
}
