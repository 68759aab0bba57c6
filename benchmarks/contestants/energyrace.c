#include "energyrace.h"

#include <math.h>
#include <string.h>

#include "ourtree.h"

/* kJ/(mol K), as OpenMM has it. */
#define BOLTZMANN 8.314462618153241e-3

const EnergyContestant energyContestants[] = {{"ours", "all parts, by the widest instructions", NULL, false},
                                              {"ours-avx512", "all parts, with AVX-512", "avx512", false},
                                              {"ours-avx2", "all parts, with AVX2", "avx2", false},
                                              {"ours-portable", "all parts, in plain C", "portable", false},
                                              {"ours-stages", "part by part, until one refuses", NULL, true},
                                              {0}};

const EnergyContestant* energyContestantFind(const char* name) {
  for (const EnergyContestant* c = energyContestants; c->name != NULL; c++) {
    if (strcmp(c->name, name) == 0) {
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
  double* parts[CT_ENERGY_PARTS]; /* of each that came to the part */
  double* means;                  /* of each block with such trials */
  int timeCount, meanCount;
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

/* What reading the clock adds to a time: no less than this. */
static double clockCost(void) {
  double least = INFINITY;
  for (int i = 0; i < CLOCK_READINGS; i++) {
    const double start = processorTime();
    least = fmin(least, processorTime() - start);
  }
  return least;
}

/* ---- Life ---- */

static void laneEnd(EnergyLane* lane) {
  ctDestroyEnergy(lane->energy);
  ctDestroy(lane->tree);
  free(lane->times);
  free(lane->means);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    free(lane->parts[part]);
  }
}

static bool laneBegin(EnergyLane* lane, const EnergyContestant* contestant, const EnergyRace* race, char* error,
                      size_t size) {
  lane->contestant = contestant;
  lane->times = allocate(race->trialCount, sizeof(double));
  lane->means = allocate(race->trialCount, sizeof(double));
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    lane->parts[part] = allocate(race->trialCount, sizeof(double));
  }
  const char* set = contestant == NULL ? NULL : contestant->instructionSet;
  lane->tree = ourTreeWith(race->scene, race->energy, set, &lane->energy, error, size);
  if (lane->tree != NULL) {
    ourCheck(ctRefreshEnergy(lane->energy, NULL));
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
  *course = (EnergyCourse){.race = race, .random = {~race->seed}, .clockCost = clockCost()};
  if (!movesInit(&course->moves, race->scene, race->rule, race->seed, error, size)) {
    return false;
  }
  course->block.turns = allocate(race->blockSize * race->rule.kappa, sizeof(Turn));
  course->block.trials = allocate(race->blockSize, sizeof(EnergyTrial));
  course->positions = allocate(3 * race->scene->particleCount, sizeof(double));
  course->spheres = allocate(race->scene->particleCount, sizeof(Sphere));
  bool success = laneBegin(&course->judge, NULL, race, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    success = laneBegin(&course->lanes[i], race->contestants[i], race, error, size);
  }
  return success;
}

/* ---- Trials ---- */

/* Opens a trial, and returns whether it clashes. */
static bool openTrial(EnergyLane* lane, const Scene* scene, int count, const Turn* turns) {
  ctChange changes[MOST_TURNS];
  bool clash = false;
  for (int i = 0; i < count; i++) {
    changes[i].link = scene->torsions[turns[i].torsion].link;
    changes[i].angle = turns[i].angle;
  }
  ourCheck(ctPropose(lane->tree, count, changes));
  ourCheck(ctTestTrial(lane->tree, &clash, NULL, NULL));
  return clash;
}

static void closeTrial(EnergyLane* lane, bool accepted) {
  if (accepted) {
    ourCheck(ctAccept(lane->tree, NULL));
  } else {
    ctReject(lane->tree);
  }
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
static void recordTrialAndState(EnergyCourse* course, const EnergyTrial* trial) {
  const EnergyRace* race = course->race;
  const int particles = race->scene->particleCount;
  if (!course->stateIsRecorded) {
    ctGetPositions(course->judge.tree, course->positions);
    fprintf(race->record, "{\"energy\": %.17g, ", energyOf(&course->judge, race->energy));
    writePositions(race->record, "state", course->positions, particles);
    fputs("}\n", race->record);
    course->stateIsRecorded = true;
  }
  ourCheck(ctGetTrialPositions(course->judge.tree, course->positions));
  double change = 0;
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    change += trial->change[part];
  }
  fprintf(race->record, "{\"change\": %.17g, ", change);
  writePositions(race->record, "trial", course->positions, particles);
  fputs("}\n", race->record);
  course->recorded++;
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

/* Makes and decides a trial, by a lane of its own whose time does not count. */
static void judgeTrial(EnergyCourse* course, Turn* turns, EnergyTrial* trial) {
  const EnergyRace* race = course->race;
  EnergyLane* judge = &course->judge;
  if (movesNeedPositions(&course->moves)) {
    ctGetPositions(judge->tree, course->positions);
    for (int i = 0; i < race->scene->particleCount; i++) {
      memcpy(course->spheres[i].x, course->positions + 3 * i, sizeof course->spheres[i].x);
    }
  }
  movesNext(&course->moves, course->spheres, turns);
  *trial = (EnergyTrial){.clash = openTrial(judge, race->scene, race->rule.kappa, turns)};
  if (trial->clash) {
    closeTrial(judge, false);
    return;
  }
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    ourCheck(ctComputeEnergyChange(judge->energy, (ctEnergyPart)part, &trial->change[part], NULL));
  }
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    trial->drawn[part] = randomReal(&course->random);
  }
  decide(trial, race->temperature);
  if (race->record != NULL && course->recorded < race->recordCount) {
    recordTrialAndState(course, trial);
  }
  course->stateIsRecorded = course->stateIsRecorded && !trial->accepted;
  closeTrial(judge, trial->accepted);
  if (trial->accepted) {
    ourCheck(ctAcceptEnergyChange(judge->energy));
  }
}

static void makeBlock(EnergyCourse* course, int count) {
  course->block.count = count;
  for (int i = 0; i < count; i++) {
    judgeTrial(course, course->block.turns + i * course->race->rule.kappa, &course->block.trials[i]);
  }
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

/* Computes the parts of an open trial and closes it as the judge decided; adds the microseconds of all to `elapsed`.
 * False if the lane computes other bits than the judge. */
static bool runFree(EnergyLane* lane, const EnergyTrial* trial, double clockCost, bool isTimed, double* elapsed) {
  double change[CT_ENERGY_PARTS];
  double sum = 0;
  const int parts = lane->contestant->stops ? trial->reached : CT_ENERGY_PARTS;
  for (int part = 0; part < parts; part++) {
    const double start = processorTime();
    ourCheck(ctComputeEnergyChange(lane->energy, (ctEnergyPart)part, &change[part], NULL));
    const double time = processorTime() - start - clockCost;
    sum += time;
    if (isTimed) {
      lane->parts[part][lane->partCounts[part]++] = time;
    }
  }
  closeTrial(lane, trial->accepted);
  if (trial->accepted) {
    const double start = processorTime();
    ourCheck(ctAcceptEnergyChange(lane->energy));
    sum += processorTime() - start - clockCost;
  }
  if (isTimed) {
    lane->times[lane->timeCount++] = sum;
  }
  *elapsed += sum;
  return memcmp(change, trial->change, (size_t)parts * sizeof(double)) == 0;
}

/* False if the lane computes other bits than the judge. */
static bool runBlock(EnergyLane* lane, const EnergyCourse* course, bool isTimed) {
  const EnergyRace* race = course->race;
  double elapsed = 0;
  int count = 0;
  bool agrees = true;
  for (int i = 0; i < course->block.count && agrees; i++) {
    const EnergyTrial* trial = &course->block.trials[i];
    const Turn* turns = course->block.turns + i * race->rule.kappa;
    const bool clash = openTrial(lane, race->scene, race->rule.kappa, turns);
    if (clash || trial->clash) {
      ctReject(lane->tree);
      agrees = clash == trial->clash;
    } else {
      agrees = runFree(lane, trial, course->clockCost, isTimed, &elapsed);
      count++;
    }
  }
  if (isTimed && count > 0) {
    lane->means[lane->meanCount++] = elapsed / count;
  }
  return agrees;
}

/* Another lane begins each block: the first finds least in the caches. */
static bool runLanes(EnergyCourse* course, int number, char* error, size_t size) {
  const int laneCount = course->race->laneCount;
  for (int i = 0; i < laneCount; i++) {
    EnergyLane* lane = &course->lanes[(i + number) % laneCount];
    if (!runBlock(lane, course, number > 0)) {
      snprintf(error, size, "%s computes other energies than the others", lane->contestant->name);
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
    makeBlock(course, count);
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

static void finish(const EnergyCourse* course, EnergyLane* lane, EnergyResult* result) {
  *result = (EnergyResult){.instructionSet = ctGetInstructionSet(lane->tree),
                           .free = course->free,
                           .accepted = course->accepted,
                           .microseconds = medianOf(lane->times, lane->timeCount),
                           .mean = medianOf(lane->means, lane->meanCount),
                           .energy = energyOf(lane, course->race->energy)};
  memcpy(result->reached, course->reached, sizeof result->reached);
  memcpy(result->refused, course->refused, sizeof result->refused);
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    result->parts[part] = medianOf(lane->parts[part], lane->partCounts[part]);
  }
  ourCheck(ctRefreshEnergy(lane->energy, NULL));
  result->drift = energyOf(lane, course->race->energy) - result->energy;
}

bool energyRaceRun(const EnergyRace* race, EnergyResult* results, char* error, size_t size) {
  EnergyCourse course;
  if (race->record != NULL) {
    recordNames(race);
  }
  const bool success = courseBegin(&course, race, error, size) && runBlocks(&course, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    finish(&course, &course.lanes[i], &results[i]);
  }
  courseEnd(&course);
  return success;
}
