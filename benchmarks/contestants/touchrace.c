#include "touchrace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"

/* States change so often before contacts are looked for, and between them; so many trials may fail to change one. */
enum { FIRST_CHANGES = 30, CHANGES = 2, CHANGES_TRIED = 1000, TRIALS_OF_CONTACT = 14 };

typedef struct TouchLane {
  const Contestant* contestant;
  void* self;
  double* times; /* of each contact */
} TouchLane;

typedef struct TouchCourse {
  const TouchRace* race;
  Random random;
  TouchLane judge;
  TouchLane lanes[MOST_TOUCH_LANES];
  Reference* reference;
  Place* places;
  int contactCount;
  int trialCount;
} TouchCourse;

/* ---- Life ---- */

static void laneEnd(TouchLane* lane) {
  if (lane->contestant != NULL) {
    lane->contestant->destroy(lane->self);
  }
  free(lane->times);
}

static void courseEnd(TouchCourse* course) {
  laneEnd(&course->judge);
  for (int i = 0; i < course->race->laneCount; i++) {
    laneEnd(&course->lanes[i]);
  }
  referenceFree(course->reference);
  free(course->places);
}

static bool laneBegin(TouchLane* lane, const Contestant* contestant, const TouchRace* race) {
  lane->contestant = contestant;
  lane->self = contestant->make(race->scene);
  lane->times = calloc((size_t)race->trialCount + 1, sizeof(double));
  return lane->self != NULL && lane->times != NULL;
}

static bool courseBegin(TouchCourse* course, const TouchRace* race) {
  *course = (TouchCourse){.race = race, .random = {race->seed}};
  course->reference = referenceMake(race->scene);
  course->places = calloc((size_t)race->scene->particleCount + 1, sizeof(Place));
  bool success = course->reference != NULL && course->places != NULL && laneBegin(&course->judge, race->judge, race);
  for (int i = 0; i < race->laneCount && success; i++) {
    success = laneBegin(&course->lanes[i], race->contestants[i], race);
  }
  return success;
}

/* ---- Changing the state ---- */

/* 1 if anyone calls a turn a clash, 0 if nobody does; -1 if there is no memory. */
static int testTurn(const TouchCourse* course, const Turn* turn) {
  int clash = course->judge.contestant->test(course->judge.self, 1, turn);
  for (int i = 0; i < course->race->laneCount && clash >= 0; i++) {
    const TouchLane* lane = &course->lanes[i];
    const int itsClash = lane->contestant->test(lane->self, 1, turn);
    clash = itsClash < 0 ? itsClash : clash | itsClash;
  }
  return clash;
}

static bool acceptTurn(const TouchCourse* course) {
  bool success = course->judge.contestant->accept(course->judge.self);
  for (int i = 0; i < course->race->laneCount && success; i++) {
    success = course->lanes[i].contestant->accept(course->lanes[i].self);
  }
  return success;
}

static void rejectTurn(const TouchCourse* course) {
  course->judge.contestant->reject(course->judge.self);
  for (int i = 0; i < course->race->laneCount; i++) {
    course->lanes[i].contestant->reject(course->lanes[i].self);
  }
}

/* By so many turns that everyone calls free; fewer if such turns are rare. False if there is no memory. */
static bool change(TouchCourse* course, int count) {
  for (int tried = 0; tried < CHANGES_TRIED && count > 0; tried++) {
    const Turn turn = {randomInt(&course->random, course->race->scene->torsionCount),
                       PI * (2 * randomReal(&course->random) - 1)};
    const int clash = testTurn(course, &turn);
    if (clash < 0) {
      return false;
    }
    if (clash) {
      rejectTurn(course);
      continue;
    }
    if (!acceptTurn(course)) {
      return false;
    }
    referenceTurn(course->reference, &turn);
    count--;
  }
  referencePositions(course->reference, course->places);
  return true;
}

/* ---- Trials ---- */

typedef struct TouchTrials {
  int count;
  Turn turns[TRIALS_OF_CONTACT];
  double overlaps[TRIALS_OF_CONTACT]; /* nm; negative: a gap */
} TouchTrials;

/* On both sides of a contact, by turns. */
static void makeTrials(TouchCourse* course, const Contact* contact, TouchTrials* trials) {
  const TouchRace* race = course->race;
  trials->count = 0;
  for (int i = 0; i < TRIALS_OF_CONTACT; i++) {
    const double depth = LEAST_TOUCH * pow(MOST_TOUCH / LEAST_TOUCH, randomReal(&course->random));
    double angle;
    if (contactAngle(race->scene, (const Place*)course->places, contact, i % 2 == 0 ? depth : -depth, &angle)) {
      const double overlap = (double)contactOverlap(race->scene, (const Place*)course->places, contact, angle);
      if (fabs(overlap) > LEAST_TOUCH) {
        trials->turns[trials->count] = (Turn){contact->torsion, angle};
        trials->overlaps[trials->count++] = overlap;
      }
    }
  }
}

static void judge(TouchResult* result, double overlap, bool clash) {
  if (overlap > 0) {
    result->clashes++;
    result->missed += !clash;
    result->largestMissed = clash ? result->largestMissed : fmax(result->largestMissed, overlap);
  } else {
    result->gaps++;
    result->invented += clash;
    result->largestInvented = clash ? fmax(result->largestInvented, -overlap) : result->largestInvented;
  }
}

/* Another lane begins each time: the first finds least in the caches. */
static bool runTrials(TouchCourse* course, const TouchTrials* trials, TouchResult* results) {
  const int laneCount = course->race->laneCount;
  for (int turn = 0; turn < laneCount; turn++) {
    const int i = (turn + course->contactCount) % laneCount;
    const TouchLane* lane = &course->lanes[i];
    int clashes[TRIALS_OF_CONTACT];
    const double start = processorTime();
    for (int k = 0; k < trials->count; k++) {
      clashes[k] = lane->contestant->test(lane->self, 1, &trials->turns[k]);
      lane->contestant->reject(lane->self);
    }
    lane->times[course->contactCount] = (processorTime() - start) / trials->count;
    for (int k = 0; k < trials->count; k++) {
      if (clashes[k] < 0) {
        return false;
      }
      judge(&results[i], trials->overlaps[k], clashes[k] > 0);
    }
  }
  course->contactCount++;
  course->trialCount += trials->count;
  return true;
}

/* Contacts until there are enough trials, or time is up. */
static bool runContacts(TouchCourse* course, TouchResult* results, char* error, size_t size) {
  const TouchRace* race = course->race;
  const double start = processorTime();
  bool success = change(course, FIRST_CHANGES);
  while (success && course->trialCount < race->trialCount &&
         (course->contactCount == 0 || processorTime() - start < 1e6 * race->seconds)) {
    Contact contact;
    TouchTrials trials;
    const ContactStatus status = contactFind(race->scene, (const Place*)course->places, race->judge, course->judge.self,
                                             &course->random, &contact);
    if (status == contactFound) {
      makeTrials(course, &contact, &trials);
      success = trials.count == 0 || runTrials(course, &trials, results);
    }
    contactFree(&contact);
    if (status == contactNone) {
      snprintf(error, size, "no turn makes particles touch");
      return false;
    }
    success = success && status == contactFound && change(course, CHANGES);
  }
  if (!success) {
    snprintf(error, size, "not enough memory");
  }
  return success;
}

bool touchRaceRun(const TouchRace* race, TouchResult* results, char* error, size_t size) {
  TouchCourse course = {0};
  if (!referenceIsExact()) {
    snprintf(error, size, "the long double of this machine is no longer than its double");
    return false;
  }
  memset(results, 0, (size_t)race->laneCount * sizeof *results);
  bool success = courseBegin(&course, race);
  if (!success) {
    snprintf(error, size, "not enough memory");
  }
  success = success && runContacts(&course, results, error, size);
  for (int i = 0; i < race->laneCount && success; i++) {
    const TouchLane* lane = &course.lanes[i];
    const Contestant* contestant = lane->contestant;
    results[i].instructionSet = contestant->instructionSet == NULL ? NULL : contestant->instructionSet(lane->self);
    results[i].microseconds = quartilesOf(lane->times, course.contactCount);
  }
  courseEnd(&course);
  return success;
}
