#include "race.h"

#include <string.h>

typedef struct Lane {
  const Contestant* contestant;
  void* self;
  double* times; /* of each block but the first, microseconds per trial */
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
  int blocksTimed;        /* without the first */
  int trialsRun;          /* with the first block, as the following */
  int accepted;
} Course;

/* ---- Life ---- */

static void laneBegin(Lane* lane, const Contestant* contestant, const Race* race) {
  lane->contestant = contestant;
  lane->self = contestant->make(race->scene);
  lane->times = allocate(race->trialCount / race->blockSize + 1, sizeof(double));
}

static void laneEnd(Lane* lane) {
  if (lane->contestant != NULL) {
    lane->contestant->destroy(lane->self);
    free(lane->times);
  }
}

static bool courseBegin(Course* course, const Race* race, char* error, size_t size) {
  *course = (Course){.race = race};
  if (!movesInit(&course->moves, race->scene, race->rule, race->seed, error, size)) {
    return false;
  }
  course->block.kappa = race->rule.kappa;
  course->block.turns = allocate(race->blockSize * race->rule.kappa, sizeof(Turn));
  course->block.clashes = allocate(race->blockSize, 1);
  course->clashes = allocate(race->blockSize, 1);
  if (movesNeedPositions(&course->moves)) {
    laneBegin(&course->judge, race->judge, race);
  }
  for (int i = 0; i < race->laneCount; i++) {
    laneBegin(&course->lanes[i], race->contestants[i], race);
  }
  return true;
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

/* ---- Running ---- */

/* Tests a trial and accepts it unless it clashes. */
static bool run(const Lane* lane, int kappa, const Turn* turns) {
  const bool clash = lane->contestant->test(lane->self, kappa, turns);
  if (clash) {
    lane->contestant->reject(lane->self);
  } else {
    lane->contestant->accept(lane->self);
  }
  return clash;
}

static void makeBlock(Course* course, int count) {
  const Lane* judge = &course->judge;
  course->block.count = count;
  for (int i = 0; i < count; i++) {
    Turn* turns = course->block.turns + i * course->block.kappa;
    movesNext(&course->moves, judge->contestant == NULL ? NULL : judge->contestant->spheres(judge->self), turns);
    if (judge->contestant != NULL) {
      run(judge, course->block.kappa, turns);
    }
  }
}

/* Returns microseconds per trial. */
static double runBlock(const Lane* lane, const Block* block, unsigned char* clashes) {
  const double start = processorTime();
  for (int i = 0; i < block->count; i++) {
    clashes[i] = run(lane, block->kappa, block->turns + i * block->kappa);
  }
  return (processorTime() - start) / block->count;
}

/* Runs trials made by makeBlock, the first of which is number `firstTrial`; false if lanes disagree. */
static bool runLanes(Course* course, int firstTrial, char* error, size_t size) {
  for (int i = 0; i < course->race->laneCount; i++) {
    Lane* lane = &course->lanes[i];
    unsigned char* clashes = i == 0 ? course->block.clashes : course->clashes;
    lane->times[course->blocksTimed] = runBlock(lane, &course->block, clashes);
    for (int k = 0; k < course->block.count; k++) {
      if (clashes[k] != course->block.clashes[k]) {
        snprintf(error, size, "%s calls trial %d %s, %s does not", lane->contestant->name, firstTrial + k,
                 clashes[k] ? "a clash" : "free of clashes", course->lanes[0].contestant->name);
        return false;
      }
    }
  }
  return true;
}

/* Caches are cold in the first block, so it is not timed. It is counted: chains are most compact there. */
static bool runBlocks(Course* course, char* error, size_t size) {
  const Race* race = course->race;
  int left = race->trialCount;
  for (int b = 0; left > 0; b++) {
    makeBlock(course, left < race->blockSize ? left : race->blockSize);
    if (!runLanes(course, b * race->blockSize, error, size)) {
      return false;
    }
    const Block* block = &course->block;
    for (int i = 0; i < block->count; i++) {
      course->accepted += !block->clashes[i];
      if (race->record != NULL) {
        recordTrial(race->record, block->kappa, block->turns + i * block->kappa, block->clashes[i]);
      }
    }
    course->trialsRun += block->count;
    course->blocksTimed += b > 0;
    left -= b > 0 ? block->count : 0;
  }
  return true;
}

bool raceRun(const Race* race, RaceResult* results, char* error, size_t size) {
  Course course;
  if (race->record != NULL) {
    recordScene(race->record, race->scene);
  }
  const bool success = courseBegin(&course, race, error, size) && runBlocks(&course, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    const Lane* lane = &course.lanes[i];
    const Counts counts = lane->contestant->counts(lane->self);
    const double trials = course.trialsRun;
    results[i] = (RaceResult){.microseconds = medianOf(lane->times, course.blocksTimed),
                              .accepted = course.accepted / trials,
                              .volumeTests = (double)counts.volumeTests / trials,
                              .particleTests = (double)counts.particleTests / trials};
    if (lane->contestant->instructionSet != NULL) {
      results[i].instructionSet = lane->contestant->instructionSet(lane->self);
    }
  }
  courseEnd(&course);
  return success;
}
