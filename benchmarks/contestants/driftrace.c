#include "driftrace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"

/* The first turns are timed, in blocks of which the first does not count. */
enum { BLOCK = 25, BLOCKS = FIRST_STATION / BLOCK };

typedef struct DriftLane {
  const Kinematics* path;
  void* self;
  double elapsed; /* microseconds, for all turns so far */
  double times[BLOCKS];
  bool goesOn;
  double* angles; /* of each torsion */
} DriftLane;

typedef struct DriftCourse {
  const DriftRace* race;
  Moves moves; /* where they stand after the turns that all lanes have made */
  DriftLane lanes[MOST_DRIFT_LANES];
  Reference* byTurns;
  Reference* byAngles;
  PairSample sample;
  Place* expected;
  Place* expectedByAngles;
  double* positions;
} DriftCourse;

/* ---- Life ---- */

static void courseEnd(DriftCourse* course) {
  for (int i = 0; i < course->race->laneCount; i++) {
    DriftLane* lane = &course->lanes[i];
    if (lane->path != NULL) {
      lane->path->destroy(lane->self);
    }
    free(lane->angles);
  }
  movesFree(&course->moves);
  referenceFree(course->byTurns);
  referenceFree(course->byAngles);
  pairSampleFree(&course->sample);
  free(course->expected);
  free(course->expectedByAngles);
  free(course->positions);
}

static bool laneBegin(DriftLane* lane, const Kinematics* path, const Scene* scene) {
  lane->path = path;
  lane->self = path->make(scene);
  lane->goesOn = true;
  lane->angles = calloc((size_t)scene->torsionCount + 1, sizeof(double));
  return lane->self != NULL && lane->angles != NULL;
}

static bool isChain(const Scene* scene) {
  for (int t = 0; t < scene->torsionCount; t++) {
    if (scene->torsions[t].last != scene->particleCount) {
      return false;
    }
  }
  return scene->linkCount == scene->torsionCount + 1;
}

static bool courseBegin(DriftCourse* course, const DriftRace* race, char* error, size_t size) {
  const Scene* scene = race->scene;
  const size_t count = (size_t)scene->particleCount;
  Random random = {race->seed};
  *course = (DriftCourse){.race = race};
  if (!isChain(scene) || !referenceIsExact()) {
    snprintf(error, size, "%s",
             isChain(scene) ? "the long double of this machine is no longer than its double"
                            : "errors are measured of chains without branches");
    return false;
  }
  if (!movesInit(&course->moves, scene, race->rule, race->seed, error, size)) {
    return false;
  }
  course->byTurns = referenceMake(scene);
  course->byAngles = referenceMake(scene);
  course->expected = calloc(count, sizeof(Place));
  course->expectedByAngles = calloc(count, sizeof(Place));
  course->positions = calloc(3 * count, sizeof(double));
  bool success = pairSampleInit(&course->sample, scene->particleCount, &random) && course->byTurns != NULL &&
                 course->byAngles != NULL && course->expected != NULL && course->expectedByAngles != NULL &&
                 course->positions != NULL;
  for (int i = 0; i < race->laneCount && success; i++) {
    success = laneBegin(&course->lanes[i], race->paths[i], scene);
  }
  if (!success) {
    snprintf(error, size, "not enough memory");
  }
  return success;
}

/* ---- Turns ---- */

static bool runTurns(DriftLane* lane, int count, const Turn* turns) {
  bool success = true;
  for (int i = 0; i < count && success; i++) {
    success = lane->path->turn(lane->self, &turns[i]);
  }
  return success;
}

/* As it would be in a simulation, where each turn is followed by a search. Returns microseconds for each. */
static double timeTurns(DriftLane* lane, int count, const Turn* turns, bool* success) {
  const double start = processorTime();
  for (int i = 0; i < count && *success; i++) {
    *success = lane->path->turn(lane->self, &turns[i]);
    if (lane->path->update != NULL) {
      lane->path->update(lane->self);
    }
  }
  return (processorTime() - start) / count;
}

static void makeTurns(Moves* moves, int count, Turn* turns) {
  for (int i = 0; i < count; i++) {
    movesNext(moves, NULL, &turns[i]);
  }
}

/* Another lane begins each block: the first finds least in the caches. */
static bool runTimed(DriftCourse* course, int count) {
  const int laneCount = course->race->laneCount;
  bool success = true;
  for (int block = 0; block * BLOCK < count && success; block++) {
    Turn turns[BLOCK];
    const int size = count - block * BLOCK < BLOCK ? count - block * BLOCK : BLOCK;
    makeTurns(&course->moves, size, turns);
    for (int i = 0; i < size; i++) {
      referenceTurn(course->byTurns, &turns[i]);
    }
    for (int i = 0; i < laneCount && success; i++) {
      DriftLane* lane = &course->lanes[(i + block) % laneCount];
      lane->times[block] = timeTurns(lane, size, turns, &success);
    }
  }
  return success;
}

/* Each lane by itself: the turns are the same again. */
static bool runUntimed(DriftCourse* course, int count) {
  const Moves start = course->moves;
  bool success = true;
  for (int i = -1; i < course->race->laneCount && success; i++) {
    DriftLane* lane = i < 0 ? NULL : &course->lanes[i];
    if (lane != NULL && !lane->goesOn) {
      continue;
    }
    Moves moves = start;
    const double begin = processorTime();
    for (int done = 0; done < count && success; done += BLOCK) {
      Turn turns[BLOCK];
      const int size = count - done < BLOCK ? count - done : BLOCK;
      makeTurns(&moves, size, turns);
      if (lane != NULL) {
        success = runTurns(lane, size, turns);
      }
      for (int k = 0; k < size && lane == NULL; k++) {
        referenceTurn(course->byTurns, &turns[k]);
      }
    }
    if (lane != NULL) {
      lane->elapsed += processorTime() - begin;
    } else {
      course->moves = moves;
    }
  }
  return success;
}

/* ---- Stations ---- */

/* FNV-1a of the bytes. */
static uint64_t hashOf(const double* numbers, size_t count) {
  const unsigned char* bytes = (const unsigned char*)numbers;
  uint64_t hash = 0xcbf29ce484222325u;
  for (size_t i = 0; i < count * sizeof *numbers; i++) {
    hash = (hash ^ bytes[i]) * 0x100000001b3u;
  }
  return hash;
}

static bool lookAt(DriftCourse* course, DriftLane* lane, int turns, DriftResult* result) {
  const int count = course->race->scene->particleCount;
  Station* station = &result->stations[result->stationCount++];
  if (lane->path->update != NULL) {
    lane->path->update(lane->self);
  }
  if (!lane->path->positions(lane->self, course->positions)) {
    return false;
  }
  *station = (Station){.turns = turns,
                       .size = sizeOf(count, (const Place*)course->expected),
                       .ofTurns = errorsOf(&course->sample, count, course->positions, (const Place*)course->expected),
                       .bits = hashOf(course->positions, 3 * (size_t)count)};
  result->keepsAngles = lane->path->angles != NULL;
  if (!result->keepsAngles) {
    return true;
  }
  if (!lane->path->angles(lane->self, lane->angles)) {
    return false;
  }
  referenceSetAngles(course->byAngles, lane->angles);
  referencePositions(course->byAngles, course->expectedByAngles);
  station->ofAngles = errorsOf(&course->sample, count, course->positions, (const Place*)course->expectedByAngles);
  return true;
}

static bool lookAtAll(DriftCourse* course, int turns, DriftResult* results) {
  bool success = true;
  referencePositions(course->byTurns, course->expected);
  for (int i = 0; i < course->race->laneCount && success; i++) {
    success = !course->lanes[i].goesOn || lookAt(course, &course->lanes[i], turns, &results[i]);
  }
  return success;
}

/* Which lanes can go on from so many turns to so many, and whether any can. */
static bool chooseLanes(DriftCourse* course, int turns, int next) {
  const DriftRace* race = course->race;
  bool any = false;
  for (int i = 0; i < race->laneCount; i++) {
    DriftLane* lane = &course->lanes[i];
    lane->goesOn = lane->goesOn && lane->elapsed / turns * next <= 1e6 * race->seconds / race->laneCount;
    any = any || lane->goesOn;
  }
  return any;
}

/* Times of the first station are those of turns with all that follows them, which later ones do not need. */
static bool runStations(DriftCourse* course, DriftResult* results) {
  const DriftRace* race = course->race;
  int turns = race->turnCount < FIRST_STATION ? race->turnCount : FIRST_STATION;
  if (!runTimed(course, turns) || !lookAtAll(course, turns, results)) {
    return false;
  }
  for (int i = 0; i < race->laneCount; i++) {
    const int blocks = (turns + BLOCK - 1) / BLOCK;
    DriftLane* lane = &course->lanes[i];
    const bool hasMore = blocks > 1;
    results[i].microseconds = quartilesOf(lane->times + hasMore, blocks - hasMore);
    lane->elapsed = lane->path->update == NULL ? results[i].microseconds.median * turns : 0;
  }
  while (turns <= race->turnCount / 10 && chooseLanes(course, turns, 10 * turns)) {
    if (!runUntimed(course, 9 * turns)) {
      return false;
    }
    turns *= 10;
    if (!lookAtAll(course, turns, results)) {
      return false;
    }
  }
  return true;
}

bool driftRaceRun(const DriftRace* race, DriftResult* results, char* error, size_t size) {
  DriftCourse course;
  memset(results, 0, (size_t)race->laneCount * sizeof *results);
  bool success = courseBegin(&course, race, error, size);
  if (success && !runStations(&course, results)) {
    snprintf(error, size, "not enough memory");
    success = false;
  }
  for (int i = 0; i < race->laneCount && success; i++) {
    const DriftLane* lane = &course.lanes[i];
    results[i].instructionSet = lane->path->instructionSet == NULL ? NULL : lane->path->instructionSet(lane->self);
  }
  courseEnd(&course);
  return success;
}
