#define _POSIX_C_SOURCE 200112L
#include "energyrace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ourtree.h"

/* kJ/(mol K), as OpenMM has it. */
#define BOLTZMANN 8.314462618153241e-3

const EnergyContestant energyContestants[] = {{"ours", "all parts, by the widest instructions", NULL, false},
                                              {"ours-avx512", "all parts, with AVX-512", "avx512", false},
                                              {"ours-avx2", "all parts, with AVX2", "avx2", false},
                                              {"ours-portable", "all parts, in plain C", "portable", false},
                                              {"ours-stages", "part by part, until one refuses", NULL, true},
                                              {0}};

const EnergyContestant* energyContestantFind(const char* name, size_t length) {
  for (const EnergyContestant* c = energyContestants; c->name != NULL; c++) {
    if (strlen(c->name) == length && memcmp(c->name, name, length) == 0) {
      return c;
    }
  }
  return NULL;
}

enum { CLOCK_READINGS = 10000 };

typedef struct EnergyTrial {
  bool clash;
  int reached; /* parts that were computed before the trial was decided */
  bool accepted;
  double change[CT_ENERGY_PARTS];
  double drawn[CT_ENERGY_PARTS];
} EnergyTrial;

/* The trials of one block, as the judge decided them. */
typedef struct EnergyBlock {
  int count;
  Turn* turns; /* count * kappa */
  EnergyTrial* trials;
} EnergyBlock;

typedef struct EnergyLane {
  const EnergyContestant* contestant; /* NULL for the judge */
  ctChainTree* tree;
  ctEnergy* energy;
  double* times;                  /* of each trial without a clash, microseconds */
  double* parts[CT_ENERGY_PARTS]; /* of each that came so far */
  double* acceptances;            /* of each that was accepted */
  double* means;                  /* of each block with such trials */
  int timeCount, acceptanceCount, meanCount;
  int partCounts[CT_ENERGY_PARTS];
} EnergyLane;

typedef struct EnergyCourse {
  const EnergyRace* race;
  Moves moves;
  Random random;
  double clockCost; /* is subtracted from each time */
  EnergyLane judge;
  EnergyLane lanes[MOST_ENERGY_LANES];
  EnergyBlock block;
  double* positions;
  Sphere* spheres; /* of the state, where moves need them */
  int recorded;
  bool stateIsRecorded;
  int free, accepted;
  int reached[CT_ENERGY_PARTS], refused[CT_ENERGY_PARTS];
} EnergyCourse;

/* Microseconds of the processor, as processorTime, but read in half the time. */
static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * (double)time.tv_sec + 1e-3 * (double)time.tv_nsec;
}

/* What reading the clock adds to a time: no less than this. */
static double clockCost(void) {
  double least = INFINITY;
  for (int i = 0; i < CLOCK_READINGS; i++) {
    const double start = now();
    least = fmin(least, now() - start);
  }
  return least;
}

/* ---- Life ---- */

static void laneEnd(EnergyLane* lane) {
  ctDestroyEnergy(lane->energy);
  ctDestroy(lane->tree);
  free(lane->times);
  free(lane->acceptances);
  free(lane->means);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    free(lane->parts[part]);
  }
}

static bool laneBegin(EnergyLane* lane, const EnergyContestant* contestant, const EnergyRace* race, char* error,
                      size_t size) {
  const size_t count = (size_t)race->trialCount + 1;
  lane->contestant = contestant;
  lane->times = calloc(count, sizeof(double));
  lane->acceptances = calloc(count, sizeof(double));
  lane->means = calloc(count, sizeof(double));
  bool success = lane->times != NULL && lane->acceptances != NULL && lane->means != NULL;
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    lane->parts[part] = calloc(count, sizeof(double));
    success = success && lane->parts[part] != NULL;
  }
  if (!success) {
    snprintf(error, size, "not enough memory");
    return false;
  }
  const char* set = contestant == NULL ? NULL : contestant->instructionSet;
  lane->tree = ourTreeWithEnergy(race->scene, race->energy, set, &lane->energy, error, size);
  if (lane->tree != NULL && ctRefreshEnergy(lane->energy, NULL) != ctSuccess) {
    snprintf(error, size, "%s", ctGetEnergyErrorText(lane->energy));
    return false;
  }
  return lane->tree != NULL;
}

static void courseEnd(EnergyCourse* course) {
  movesFree(&course->moves);
  laneEnd(&course->judge);
  for (int i = 0; i < course->race->laneCount; i++) {
    laneEnd(&course->lanes[i]);
  }
  free(course->block.turns);
  free(course->block.trials);
  free(course->positions);
  free(course->spheres);
}

static bool courseBegin(EnergyCourse* course, const EnergyRace* race, char* error, size_t size) {
  const size_t particles = (size_t)race->scene->particleCount;
  *course = (EnergyCourse){.race = race, .random = {~race->seed}, .clockCost = clockCost()};
  if (!movesInit(&course->moves, race->scene, race->rule, race->seed, error, size)) {
    return false;
  }
  course->block.turns = calloc((size_t)race->blockSize * (size_t)race->rule.kappa, sizeof(Turn));
  course->block.trials = calloc((size_t)race->blockSize, sizeof(EnergyTrial));
  course->positions = calloc(3 * particles, sizeof(double));
  course->spheres = calloc(particles, sizeof(Sphere));
  if (course->block.turns == NULL || course->block.trials == NULL || course->positions == NULL ||
      course->spheres == NULL) {
    snprintf(error, size, "not enough memory");
    return false;
  }
  bool success = laneBegin(&course->judge, NULL, race, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    success = laneBegin(&course->lanes[i], race->contestants[i], race, error, size);
  }
  return success;
}

/* ---- Trials ---- */

/* Opens a trial and tests it; false if there is no memory. */
static bool openTrial(EnergyLane* lane, const Scene* scene, int count, const Turn* turns, bool* clash) {
  ctChange changes[MOST_TURNS];
  for (int i = 0; i < count; i++) {
    changes[i].link = scene->torsions[turns[i].torsion].link;
    changes[i].angle = turns[i].angle;
  }
  return ctPropose(lane->tree, count, changes) == ctSuccess && ctTestTrial(lane->tree, clash, NULL, NULL) == ctSuccess;
}

static bool closeTrial(EnergyLane* lane, bool accepted) {
  if (accepted) {
    return ctAccept(lane->tree, NULL) == ctSuccess;
  }
  ctReject(lane->tree);
  return true;
}

static void writePositions(FILE* file, const char* name, const double* positions, int count) {
  fprintf(file, "\"%s\": [", name);
  for (int i = 0; i < 3 * count; i++) {
    fprintf(file, "%s%.17g", i == 0 ? "" : ", ", positions[i]);
  }
  fputs("]", file);
}

static void recordNames(const EnergyRace* race) {
  fputs("{\"names\": [", race->record);
  for (int i = 0; i < race->scene->particleCount; i++) {
    fprintf(race->record, "%s%d", i == 0 ? "" : ", ", race->scene->particleNames[i]);
  }
  fputs("]}\n", race->record);
}

static double energyOf(const EnergyLane* lane, const Energy* energy) {
  double sum = ctGetPairEnergy(lane->energy);
  for (int s = 0; s < energy->setCount; s++) {
    sum += ctGetTermEnergy(lane->energy, s);
  }
  return sum;
}

/* Writes the open trial, and the state before it unless it stands there already. */
static bool recordTrialAndState(EnergyCourse* course, const EnergyTrial* trial) {
  const EnergyRace* race = course->race;
  const int particles = race->scene->particleCount;
  if (!course->stateIsRecorded) {
    ctGetPositions(course->judge.tree, course->positions);
    fprintf(race->record, "{\"energy\": %.17g, ", energyOf(&course->judge, race->energy));
    writePositions(race->record, "state", course->positions, particles);
    fputs("}\n", race->record);
    course->stateIsRecorded = true;
  }
  if (ctGetTrialPositions(course->judge.tree, course->positions) != ctSuccess) {
    return false;
  }
  double change = 0;
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    change += trial->change[part];
  }
  fprintf(race->record, "{\"change\": %.17g, ", change);
  writePositions(race->record, "trial", course->positions, particles);
  fputs("}\n", race->record);
  course->recorded++;
  return true;
}

/* Part by part, as the integrator decides: what is accepted by each is accepted. */
static void decide(EnergyTrial* trial, double temperature) {
  trial->accepted = true;
  trial->reached = 0;
  while (trial->reached < CT_ENERGY_PARTS && trial->accepted) {
    const int part = trial->reached++;
    trial->accepted = trial->drawn[part] < exp(-trial->change[part] / (BOLTZMANN * temperature));
  }
}

static bool computeParts(const EnergyLane* lane, EnergyTrial* trial) {
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    if (ctComputeEnergyChange(lane->energy, (ctEnergyPart)part, &trial->change[part], NULL) != ctSuccess) {
      return false;
    }
  }
  return true;
}

/* Makes and decides a trial, by a lane of its own whose time does not count. */
static bool judgeTrial(EnergyCourse* course, Turn* turns, EnergyTrial* trial) {
  const EnergyRace* race = course->race;
  EnergyLane* judge = &course->judge;
  if (movesNeedPositions(&course->moves)) {
    ctGetPositions(judge->tree, course->positions);
    for (int i = 0; i < race->scene->particleCount; i++) {
      memcpy(course->spheres[i].x, course->positions + 3 * i, sizeof course->spheres[i].x);
    }
  }
  movesNext(&course->moves, course->spheres, turns);
  *trial = (EnergyTrial){0};
  if (!openTrial(judge, race->scene, race->rule.kappa, turns, &trial->clash)) {
    return false;
  }
  if (trial->clash) {
    return closeTrial(judge, false);
  }
  if (!computeParts(judge, trial)) {
    return false;
  }
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    trial->drawn[part] = randomReal(&course->random);
  }
  decide(trial, race->temperature);
  if (race->record != NULL && course->recorded < race->recordCount && !recordTrialAndState(course, trial)) {
    return false;
  }
  course->stateIsRecorded = course->stateIsRecorded && !trial->accepted;
  return closeTrial(judge, trial->accepted) && (!trial->accepted || ctAcceptEnergyChange(judge->energy) == ctSuccess);
}

static bool makeBlock(EnergyCourse* course, int count) {
  course->block.count = count;
  for (int i = 0; i < count; i++) {
    if (!judgeTrial(course, course->block.turns + i * course->race->rule.kappa, &course->block.trials[i])) {
      return false;
    }
  }
  return true;
}

static void countBlock(EnergyCourse* course) {
  for (int i = 0; i < course->block.count; i++) {
    const EnergyTrial* trial = &course->block.trials[i];
    course->free += !trial->clash;
    course->accepted += trial->accepted;
    for (int part = 0; part < trial->reached; part++) {
      course->reached[part]++;
    }
    if (!trial->clash && !trial->accepted) {
      course->refused[trial->reached - 1]++;
    }
  }
}

typedef enum LaneStatus { laneAgrees, laneDiffers, laneFails } LaneStatus;

/* Computes the parts of an open trial and closes it as the judge decided; `elapsed` becomes the microseconds of all. */
static LaneStatus runFree(EnergyLane* lane, const EnergyTrial* trial, double clockCost, bool isTimed, double* elapsed) {
  double change[CT_ENERGY_PARTS];
  const int parts = lane->contestant->stops ? trial->reached : CT_ENERGY_PARTS;
  for (int part = 0; part < parts; part++) {
    const double start = now();
    if (ctComputeEnergyChange(lane->energy, (ctEnergyPart)part, &change[part], NULL) != ctSuccess) {
      return laneFails;
    }
    const double time = now() - start - clockCost;
    *elapsed += time;
    if (isTimed) {
      lane->parts[part][lane->partCounts[part]++] = time;
    }
  }
  if (!closeTrial(lane, trial->accepted)) {
    return laneFails;
  }
  if (trial->accepted) {
    const double start = now();
    if (ctAcceptEnergyChange(lane->energy) != ctSuccess) {
      return laneFails;
    }
    const double time = now() - start - clockCost;
    *elapsed += time;
    if (isTimed) {
      lane->acceptances[lane->acceptanceCount++] = time;
    }
  }
  if (isTimed) {
    lane->times[lane->timeCount++] = *elapsed;
  }
  return memcmp(change, trial->change, (size_t)parts * sizeof(double)) == 0 ? laneAgrees : laneDiffers;
}

static LaneStatus runTrial(EnergyLane* lane, const EnergyCourse* course, int i, bool isTimed, double* elapsed) {
  const EnergyRace* race = course->race;
  const EnergyTrial* trial = &course->block.trials[i];
  bool clash = false;
  if (!openTrial(lane, race->scene, race->rule.kappa, course->block.turns + i * race->rule.kappa, &clash)) {
    return laneFails;
  }
  if (!clash && !trial->clash) {
    return runFree(lane, trial, course->clockCost, isTimed, elapsed);
  }
  ctReject(lane->tree);
  return clash == trial->clash ? laneAgrees : laneDiffers;
}

static LaneStatus runBlock(EnergyLane* lane, const EnergyCourse* course, bool isTimed) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < course->block.count; i++) {
    double elapsed = 0;
    const LaneStatus status = runTrial(lane, course, i, isTimed, &elapsed);
    if (status != laneAgrees) {
      return status;
    }
    sum += elapsed;
    count += !course->block.trials[i].clash;
  }
  if (isTimed && count > 0) {
    lane->means[lane->meanCount++] = sum / count;
  }
  return laneAgrees;
}

/* Another lane begins each block: the first finds least in the caches. */
static bool runLanes(EnergyCourse* course, int number, char* error, size_t size) {
  const int laneCount = course->race->laneCount;
  for (int i = 0; i < laneCount; i++) {
    EnergyLane* lane = &course->lanes[(i + number) % laneCount];
    const LaneStatus status = runBlock(lane, course, number > 0);
    if (status != laneAgrees) {
      snprintf(error, size,
               status == laneDiffers ? "%s computes other energies than the others" : "not enough memory for %s",
               lane->contestant->name);
      return false;
    }
  }
  return true;
}

static bool runBlocks(EnergyCourse* course, char* error, size_t size) {
  const EnergyRace* race = course->race;
  int timed = 0;
  for (int b = 0; b == 0 || timed < race->trialCount; b++) {
    const int left = race->trialCount - timed;
    const int count = left < race->blockSize ? left : race->blockSize;
    if (!makeBlock(course, count)) {
      snprintf(error, size, "not enough memory for a trial");
      return false;
    }
    if (!runLanes(course, b, error, size)) {
      return false;
    }
    if (b > 0) {
      countBlock(course);
      timed += count;
    }
  }
  if (course->free == 0) {
    snprintf(error, size, "each of %d trials clashes", timed);
    return false;
  }
  return true;
}

/* ---- Results ---- */

static double medianOf(double* values, int count) {
  return count == 0 ? 0 : quartilesOf(values, count).median;
}

/* Ends the lane's energy, so as to know how much memory it had. */
static bool finish(EnergyCourse* course, EnergyLane* lane, EnergyResult* result) {
  *result = (EnergyResult){.instructionSet = ctGetInstructionSet(lane->tree),
                           .free = course->free,
                           .accepted = course->accepted,
                           .microseconds = quartilesOf(lane->times, lane->timeCount),
                           .mean = medianOf(lane->means, lane->meanCount),
                           .acceptance = medianOf(lane->acceptances, lane->acceptanceCount),
                           .energy = energyOf(lane, course->race->energy)};
  memcpy(result->reached, course->reached, sizeof result->reached);
  memcpy(result->refused, course->refused, sizeof result->refused);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    result->parts[part] = medianOf(lane->parts[part], lane->partCounts[part]);
  }
  const double start = now();
  if (ctRefreshEnergy(lane->energy, NULL) != ctSuccess) {
    return false;
  }
  result->refresh = now() - start;
  result->drift = energyOf(lane, course->race->energy) - result->energy;
  const int64_t all = heapBytes();
  ctDestroyEnergy(lane->energy);
  lane->energy = NULL;
  const int64_t withoutEnergy = heapBytes();
  ctDestroy(lane->tree);
  lane->tree = NULL;
  result->energyBytes = all < 0 ? -1 : all - withoutEnergy;
  result->treeBytes = all < 0 ? -1 : withoutEnergy - heapBytes();
  return true;
}

bool energyRaceRun(const EnergyRace* race, EnergyResult* results, char* error, size_t size) {
  EnergyCourse course;
  if (race->record != NULL) {
    recordNames(race);
  }
  bool success = courseBegin(&course, race, error, size) && runBlocks(&course, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    success = finish(&course, &course.lanes[i], &results[i]);
    if (!success) {
      snprintf(error, size, "not enough memory");
    }
  }
  courseEnd(&course);
  return success;
}
