#include "race.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure.h"
#include "record.h"

typedef struct Lane {
  const Contestant* contestant;
  void* self;
  double* times;     /* of each block but the first, microseconds per trial */
  double* positions; /* as last read; NULL where the contestant keeps them itself */
} Lane;

/* The trials of one block, and what the first lane says of them. */
typedef struct Block {
  int count;
  int kappa;
  Turn* turns;
  unsigned char* clashes;
} Block;

typedef struct Course {
  const Race* race;
  Moves moves;
  Lane judge; /* of no contestant, if trials do not depend on positions */
  Lane lanes[MOST_LANES];
  Block block;
  unsigned char* clashes; /* of the lane that runs */
  int blocksTimed;        /* without the first, as the following */
  int trialsTimed;
  int trialsRun; /* with the first block, as the following */
  int accepted;
  double gyration[3]; /* as in RaceResult */
} Course;

/* ---- Life ---- */

static void laneEnd(Lane* lane) {
  if (lane->contestant != NULL) {
    lane->contestant->destroy(lane->self);
  }
  free(lane->times);
  free(lane->positions);
  *lane = (Lane){0};
}

static bool laneBegin(Lane* lane, const Contestant* contestant, const Scene* scene, int blockCount) {
  lane->contestant = contestant;
  lane->self = contestant->make(scene);
  lane->times = calloc((size_t)blockCount, sizeof(double));
  if (contestant->spheres == NULL) {
    lane->positions = calloc(3 * (size_t)scene->particleCount + 1, sizeof(double));
  }
  return lane->self != NULL && lane->times != NULL && (contestant->spheres != NULL || lane->positions != NULL);
}

static int blockCountOf(const Race* race) {
  return (race->trialCount + race->blockSize - 1) / race->blockSize;
}

static void courseEnd(Course* course) {
  movesFree(&course->moves);
  laneEnd(&course->judge);
  for (int i = 0; i < course->race->laneCount; i++) {
    laneEnd(&course->lanes[i]);
  }
  free(course->block.turns);
  free(course->block.clashes);
  free(course->clashes);
}

static bool courseBegin(Course* course, const Race* race, char* error, size_t size) {
  *course = (Course){.race = race};
  if (!movesInit(&course->moves, race->scene, race->rule, race->seed, error, size)) {
    return false;
  }
  const size_t trials = (size_t)race->blockSize;
  course->block.kappa = race->rule.kappa;
  course->block.turns = calloc(trials * (size_t)race->rule.kappa, sizeof(Turn));
  course->block.clashes = calloc(trials, 1);
  course->clashes = calloc(trials, 1);
  if (course->block.turns == NULL || course->block.clashes == NULL || course->clashes == NULL) {
    snprintf(error, size, "not enough memory");
    return false;
  }
  if (movesNeedPositions(&course->moves) && !laneBegin(&course->judge, race->judge, race->scene, 1)) {
    snprintf(error, size, "not enough memory for the judge");
    return false;
  }
  for (int i = 0; i < race->laneCount; i++) {
    if (!laneBegin(&course->lanes[i], race->contestants[i], race->scene, 1 + blockCountOf(race))) {
      snprintf(error, size, "not enough memory for %s", race->contestants[i]->name);
      return false;
    }
  }
  return true;
}

/* ---- Running ---- */

static void readPositions(const Lane* lane) {
  if (lane->positions != NULL) {
    lane->contestant->positions(lane->self, lane->positions);
  }
}

/* Tests a trial and takes it over unless it clashes; -1 if there is no memory. */
static int run(const Lane* lane, int kappa, const Turn* turns, bool readsPositions) {
  const int clash = lane->contestant->test(lane->self, kappa, turns);
  if (clash != 0) {
    lane->contestant->reject(lane->self);
    return clash;
  }
  if (!lane->contestant->accept(lane->self)) {
    return -1;
  }
  if (readsPositions) {
    readPositions(lane);
  }
  return 0;
}

static bool makeBlock(Course* course, int count) {
  const Lane* judge = &course->judge;
  course->block.count = count;
  for (int i = 0; i < count; i++) {
    Turn* turns = course->block.turns + i * course->block.kappa;
    const Sphere* spheres = judge->contestant == NULL ? NULL : judge->contestant->spheres(judge->self);
    movesNext(&course->moves, spheres, turns);
    if (judge->contestant != NULL && run(judge, course->block.kappa, turns, false) < 0) {
      return false;
    }
  }
  return true;
}

/* Returns microseconds per trial, negative if there is no memory. */
static double runBlock(const Lane* lane, const Block* block, bool readsPositions, unsigned char* clashes) {
  const double start = processorTime();
  for (int i = 0; i < block->count; i++) {
    const int clash = run(lane, block->kappa, block->turns + i * block->kappa, readsPositions);
    if (clash < 0) {
      return -1;
    }
    clashes[i] = (unsigned char)clash;
  }
  return (processorTime() - start) / block->count;
}

static void reportDisagreement(const Course* course, int lane, int firstTrial, char* error, size_t size) {
  int trial = 0;
  while (course->clashes[trial] == course->block.clashes[trial]) {
    trial++;
  }
  snprintf(error, size, "%s calls trial %d %s, %s does not", course->lanes[lane].contestant->name, firstTrial + trial,
           course->clashes[trial] ? "a clash" : "free of clashes", course->lanes[0].contestant->name);
}

/* Runs trials made by makeBlock, which are number `firstTrial` and following; returns how long the contestants took
 * together, in microseconds, negative if that fails. */
static double runLanes(Course* course, int firstTrial, char* error, size_t size) {
  double sum = 0;
  for (int i = 0; i < course->race->laneCount; i++) {
    Lane* lane = &course->lanes[i];
    unsigned char* clashes = i == 0 ? course->block.clashes : course->clashes;
    const double time = runBlock(lane, &course->block, course->race->readsPositions, clashes);
    if (time < 0) {
      snprintf(error, size, "not enough memory for a trial of %s", lane->contestant->name);
      return -1;
    }
    if (i > 0 && memcmp(clashes, course->block.clashes, (size_t)course->block.count) != 0) {
      reportDisagreement(course, i, firstTrial, error, size);
      return -1;
    }
    lane->times[course->blocksTimed] = time;
    sum += time * course->block.count;
  }
  return sum;
}

static void countBlock(Course* course, bool isTimed) {
  course->blocksTimed += isTimed;
  course->trialsTimed += isTimed ? course->block.count : 0;
  course->trialsRun += course->block.count;
  for (int i = 0; i < course->block.count; i++) {
    course->accepted += !course->block.clashes[i];
  }
}

static void recordBlock(FILE* record, const Block* block) {
  for (int i = 0; i < block->count; i++) {
    recordTrial(record, block->kappa, block->turns + i * block->kappa, block->clashes[i]);
  }
}

/* By a contestant that keeps positions, if there is one: reading them changes nothing. */
static double gyrationNow(const Course* course) {
  const Lane* lane = &course->lanes[0];
  for (int i = 0; i < course->race->laneCount && lane->positions != NULL; i++) {
    lane = course->lanes[i].positions == NULL ? &course->lanes[i] : lane;
  }
  readPositions(lane);
  const Sphere* spheres = lane->positions == NULL ? lane->contestant->spheres(lane->self) : NULL;
  const int count = course->race->scene->particleCount;
  double sum[3] = {0, 0, 0};
  double squares = 0;
  for (int i = 0; i < count; i++) {
    const double* x = spheres == NULL ? lane->positions + 3 * i : spheres[i].x;
    for (int k = 0; k < 3; k++) {
      sum[k] += x[k] / count;
      squares += x[k] * x[k] / count;
    }
  }
  return sqrt(squares - sum[0] * sum[0] - sum[1] * sum[1] - sum[2] * sum[2]);
}

/* Caches are cold in the first block, so it is not timed. It is counted: chains are most compact there. */
static bool runBlocks(Course* course, char* error, size_t size) {
  const Race* race = course->race;
  double left = 1e6 * race->seconds;
  course->gyration[0] = gyrationNow(course);
  for (int b = 0; b <= blockCountOf(race) && (left > 0 || b < 2); b++) {
    const int trialsLeft = race->trialCount - course->trialsTimed;
    if (!makeBlock(course, trialsLeft < race->blockSize ? trialsLeft : race->blockSize)) {
      snprintf(error, size, "not enough memory for a trial");
      return false;
    }
    const double time = runLanes(course, b * race->blockSize, error, size);
    if (time < 0) {
      return false;
    }
    left -= time;
    if (race->record != NULL) {
      recordBlock(race->record, &course->block);
    }
    countBlock(course, b > 0);
    if (b == 0) {
      course->gyration[1] = gyrationNow(course);
    }
  }
  course->gyration[2] = gyrationNow(course);
  return true;
}

/* ---- Results ---- */

static RaceResult resultOf(const Course* course, const Lane* lane) {
  const double trials = course->trialsRun;
  const Contestant* contestant = lane->contestant;
  const Counts counts = contestant->counts(lane->self);
  return (RaceResult){
      .instructionSet = contestant->instructionSet == NULL ? NULL : contestant->instructionSet(lane->self),
      .trials = course->trialsTimed,
      .gyration = {course->gyration[0], course->gyration[1], course->gyration[2]},
      .microseconds = quartilesOf(lane->times, course->blocksTimed),
      .accepted = course->accepted / trials,
      .volumeTests = (double)counts.volumeTests / trials,
      .particleTests = (double)counts.particleTests / trials,
      .updates = (double)counts.updates / trials};
}

/* Ends a lane. What the lane itself holds beside the contestant is not counted. */
static int64_t bytesFreed(Lane* lane) {
  const int64_t before = heapBytes();
  lane->contestant->destroy(lane->self);
  const int64_t after = heapBytes();
  lane->contestant = NULL;
  return before < 0 ? -1 : before - after;
}

bool raceRun(const Race* race, RaceResult* results, char* error, size_t size) {
  Course course;
  if (race->record != NULL) {
    recordScene(race->record, race->scene);
  }
  const bool success = courseBegin(&course, race, error, size) && runBlocks(&course, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    results[i] = resultOf(&course, &course.lanes[i]);
    results[i].bytes = bytesFreed(&course.lanes[i]);
  }
  courseEnd(&course);
  return success;
}
