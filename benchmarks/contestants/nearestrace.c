#include "nearestrace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "random.h"

/* Of distances in single precision, relative to the distance of anything from the origin. */
#define ROUNDING 1e-6

/* Turns are small, so that a chain that is compact stays so for a while. */
#define LARGEST_TURN 0.1

typedef struct NearestLane {
  const NearestFinder* finder;
  void* self;
  double* times;
  Nearest nearest;
} NearestLane;

typedef struct NearestCourse {
  const NearestRace* race;
  Random random;
  double* obstacles;
  double precision;
  NearestLane lanes[MOST_NEAREST_FINDERS];
} NearestCourse;

/* ---- Life ---- */

static void courseEnd(NearestCourse* course) {
  for (int i = 0; i < course->race->finderCount; i++) {
    NearestLane* lane = &course->lanes[i];
    if (lane->finder != NULL) {
      lane->finder->destroy(lane->self);
    }
    free(lane->times);
  }
  free(course->obstacles);
}

/* Into a cube of the size of the chain, which begins along x where the chain ends. */
static void placeObstacles(NearestCourse* course) {
  const Scene* scene = course->race->scene;
  double low[3] = {INFINITY, INFINITY, INFINITY};
  double high[3] = {-INFINITY, -INFINITY, -INFINITY};
  double edge = 0;
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < scene->particleCount; i++) {
      low[k] = fmin(low[k], scene->spheres[i].x[k]);
      high[k] = fmax(high[k], scene->spheres[i].x[k]);
    }
    edge = fmax(edge, high[k] - low[k]);
  }
  low[0] = high[0] + 2 * sceneLargestRadius(scene);
  for (int i = 0; i < 3 * course->race->obstacleCount; i++) {
    course->obstacles[i] = low[i % 3] + edge * randomReal(&course->random);
  }
  course->precision = ROUNDING * (edge * 4 + fabs(low[0]) + fabs(low[1]) + fabs(low[2]));
}

static bool courseBegin(NearestCourse* course, const NearestRace* race) {
  *course = (NearestCourse){.race = race, .random = {race->seed}};
  course->obstacles = calloc(3 * (size_t)race->obstacleCount, sizeof(double));
  if (course->obstacles == NULL) {
    return false;
  }
  placeObstacles(course);
  for (int i = 0; i < race->finderCount; i++) {
    NearestLane* lane = &course->lanes[i];
    lane->finder = race->finders[i];
    lane->self = lane->finder->make(race->scene, race->obstacleCount, course->obstacles);
    lane->times = calloc((size_t)race->repeats, sizeof(double));
    if (lane->self == NULL || lane->times == NULL) {
      return false;
    }
  }
  return true;
}

/* ---- Running ---- */

static bool ask(NearestLane* lane, Turn turn, int repeat, char* error, size_t size) {
  bool success = lane->finder->turn(lane->self, turn);
  const double start = processorTime();
  success = success && lane->finder->find(lane->self, &lane->nearest);
  lane->times[repeat] = processorTime() - start;
  if (!success) {
    snprintf(error, size, "not enough memory for %s", lane->finder->name);
  }
  return success;
}

static bool runRepeats(NearestCourse* course, char* error, size_t size) {
  const NearestRace* race = course->race;
  const NearestLane* first = &course->lanes[0];
  for (int repeat = 0; repeat < race->repeats; repeat++) {
    const Turn turn = {randomInt(&course->random, race->scene->torsionCount),
                       LARGEST_TURN * (2 * randomReal(&course->random) - 1)};
    for (int i = 0; i < race->finderCount; i++) {
      NearestLane* lane = &course->lanes[i];
      if (!ask(lane, turn, repeat, error, size)) {
        return false;
      }
      if (fabs(lane->nearest.distance - first->nearest.distance) > course->precision) {
        snprintf(error, size, "%s finds a distance of %.9g, %s of %.9g", first->finder->name, first->nearest.distance,
                 lane->finder->name, lane->nearest.distance);
        return false;
      }
    }
  }
  return true;
}

bool nearestRaceRun(const NearestRace* race, Quartiles* microseconds, char* error, size_t size) {
  NearestCourse course;
  bool success = courseBegin(&course, race);
  if (!success) {
    snprintf(error, size, "not enough memory");
  }
  success = success && runRepeats(&course, error, size);
  for (int i = 0; i < race->finderCount && success; i++) {
    microseconds[i] = quartilesOf(course.lanes[i].times, race->repeats);
  }
  courseEnd(&course);
  return success;
}
