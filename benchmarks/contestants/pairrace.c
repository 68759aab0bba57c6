#include "pairrace.h"

#include <math.h>
#include <stdio.h>

#include "random.h"
#include "rigid.h"

/* Of distances in single precision, relative to the size of the scene. */
#define ROUNDING 1e-6

typedef struct PairLane {
  const PairFinder* finder;
  void* self;
  PairList list;
  double* times;
} PairLane;

typedef struct PairCourse {
  const PairRace* race;
  double* positions;
  double precision; /* of distances */
  PairLane lanes[MOST_PAIR_FINDERS];
} PairCourse;

/* ---- Life ---- */

static void courseEnd(PairCourse* course) {
  for (int i = 0; i < course->race->finderCount; i++) {
    PairLane* lane = &course->lanes[i];
    if (lane->finder != NULL) {
      lane->finder->destroy(lane->self);
    }
    pairListFree(&lane->list);
    free(lane->times);
  }
  free(course->positions);
}

static bool courseBegin(PairCourse* course, const PairRace* race) {
  *course = (PairCourse){.race = race};
  double extent = race->cutoff;
  course->positions = calloc(3 * (size_t)race->scene->particleCount + 1, sizeof(double));
  for (int i = 1; i < race->scene->particleCount; i++) {
    extent = fmax(extent, sqrt(squaredDistance(race->scene->spheres[0].x, race->scene->spheres[i].x)));
  }
  course->precision = ROUNDING * extent;
  bool success = course->positions != NULL;
  for (int i = 0; i < race->finderCount && success; i++) {
    PairLane* lane = &course->lanes[i];
    lane->finder = race->finders[i];
    lane->self = lane->finder->make(race->scene);
    lane->times = calloc((size_t)race->repeats, sizeof(double));
    success = lane->self != NULL && lane->times != NULL;
  }
  return success;
}

/* ---- Comparison ---- */

typedef struct IndexPair {
  int first;
  int second;
  double distance; /* as the finder says; negative if it does not */
} IndexPair;

static int comparePairs(const void* a, const void* b) {
  const IndexPair* p = a;
  const IndexPair* q = b;
  return p->first != q->first ? (p->first > q->first) - (p->first < q->first)
                              : (p->second > q->second) - (p->second < q->second);
}

/* Pairs with the lower index first, sorted; NULL if there is no memory. */
static IndexPair* inOrder(const PairList* list, bool withDistances) {
  IndexPair* pairs = malloc(((size_t)list->count + 1) * sizeof *pairs);
  for (int k = 0; k < list->count && pairs != NULL; k++) {
    const int first = list->first[k];
    const int second = list->second[k];
    pairs[k] = (IndexPair){first < second ? first : second, first < second ? second : first,
                           withDistances ? list->distances[k] : -1};
  }
  if (pairs != NULL) {
    qsort(pairs, (size_t)list->count, sizeof *pairs, comparePairs);
  }
  return pairs;
}

static double distanceOf(const PairCourse* course, const IndexPair* pair) {
  return sqrt(squaredDistance(course->positions + 3 * pair->first, course->positions + 3 * pair->second));
}

/* Whether a pair that only one finder lists is as far apart as the cutoff. */
static bool isDoubtful(const PairCourse* course, const IndexPair* pair) {
  return fabs(distanceOf(course, pair) - course->race->cutoff) <= course->precision;
}

static bool distanceIsRight(const PairCourse* course, const IndexPair* pair) {
  return pair->distance < 0 || fabs(pair->distance - distanceOf(course, pair)) <= course->precision;
}

static bool sameSorted(const PairCourse* course, const IndexPair* a, int countA, const IndexPair* b, int countB) {
  int i = 0;
  int j = 0;
  while (i < countA || j < countB) {
    const int order = i == countA ? 1 : j == countB ? -1 : comparePairs(&a[i], &b[j]);
    if (order == 0 && !(distanceIsRight(course, &a[i]) && distanceIsRight(course, &b[j]))) {
      return false;
    }
    if (order != 0 && !isDoubtful(course, order < 0 ? &a[i] : &b[j])) {
      return false;
    }
    i += order <= 0;
    j += order >= 0;
  }
  return true;
}

/* Whether pairs come in the order that the finder promises. */
static bool keepsOrder(const PairFinder* finder, const PairList* list) {
  for (int k = 0; k < list->count && finder->order == pairsSorted; k++) {
    const bool behind = k == 0 || list->first[k] > list->first[k - 1] ||
                        (list->first[k] == list->first[k - 1] && list->second[k] > list->second[k - 1]);
    if (!behind || list->first[k] >= list->second[k]) {
      return false;
    }
  }
  return true;
}

static bool compareLists(const PairCourse* course, char* error, size_t size) {
  const PairLane* lanes = course->lanes;
  IndexPair* reference = inOrder(&lanes[0].list, lanes[0].finder->order == pairsSorted);
  bool success = true;
  for (int i = 0; i < course->race->finderCount && success; i++) {
    const PairLane* lane = &lanes[i];
    IndexPair* pairs = inOrder(&lane->list, lane->finder->order == pairsSorted);
    success = reference != NULL && pairs != NULL;
    if (!success) {
      snprintf(error, size, "not enough memory to compare pairs");
    } else if (!keepsOrder(lane->finder, &lane->list)) {
      snprintf(error, size, "the pairs of %s are not in order", lane->finder->name);
      success = false;
    } else if (!sameSorted(course, reference, lanes[0].list.count, pairs, lane->list.count)) {
      snprintf(error, size, "%s and %s list different pairs or distances", lanes[0].finder->name, lane->finder->name);
      success = false;
    }
    free(pairs);
  }
  free(reference);
  return success;
}

/* ---- Running ---- */

static void shake(PairCourse* course, Random* random) {
  const Scene* scene = course->race->scene;
  for (int i = 0; i < 3 * scene->particleCount; i++) {
    course->positions[i] = scene->spheres[i / 3].x[i % 3] + 0.01 * course->race->cutoff * (2 * randomReal(random) - 1);
  }
}

static bool runRepeats(PairCourse* course, char* error, size_t size) {
  Random random = {course->race->seed};
  for (int repeat = 0; repeat < course->race->repeats; repeat++) {
    shake(course, &random);
    for (int i = 0; i < course->race->finderCount; i++) {
      PairLane* lane = &course->lanes[i];
      const double start = processorTime();
      if (!lane->finder->find(lane->self, course->positions, course->race->cutoff, &lane->list)) {
        snprintf(error, size, "not enough memory for %s", lane->finder->name);
        return false;
      }
      lane->times[repeat] = processorTime() - start;
    }
    if (!compareLists(course, error, size)) {
      return false;
    }
  }
  return true;
}

bool pairRaceRun(const PairRace* race, PairResult* results, char* error, size_t size) {
  PairCourse course;
  bool success = courseBegin(&course, race);
  if (!success) {
    snprintf(error, size, "not enough memory");
  }
  success = success && runRepeats(&course, error, size);
  for (int i = 0; i < race->finderCount && success; i++) {
    results[i] = (PairResult){quartilesOf(course.lanes[i].times, race->repeats), course.lanes[i].list.count};
  }
  courseEnd(&course);
  return success;
}
