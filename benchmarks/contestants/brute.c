/* All pairs of particles that a trial moves relative to each other: the measure of right and wrong. */
#include <stdlib.h>
#include <string.h>

#include "bodies.h"

typedef struct Brute {
  const Scene* scene;
  Sphere* spheres;
  Sphere* trial;
  Counts counts;
} Brute;

static void destroy(void* self) {
  Brute* brute = self;
  if (brute != NULL) {
    free(brute->spheres);
    free(brute->trial);
    free(brute);
  }
}

static void* make(const Scene* scene) {
  Brute* brute = calloc(1, sizeof *brute);
  if (brute == NULL) {
    return NULL;
  }
  const size_t bytes = (size_t)scene->particleCount * sizeof(Sphere);
  brute->scene = scene;
  brute->spheres = malloc(bytes);
  brute->trial = malloc(bytes);
  if (brute->spheres == NULL || brute->trial == NULL) {
    destroy(brute);
    return NULL;
  }
  memcpy(brute->spheres, scene->spheres, bytes);
  return brute;
}

static bool clash(Brute* brute, const Sphere* spheres, int i, int j) {
  const double sum = spheres[i].radius + spheres[j].radius;
  brute->counts.particleTests++;
  return squaredDistance(spheres[i].x, spheres[j].x) < sum * sum && !sceneExcludes(brute->scene, i, j);
}

static bool segmentsClash(Brute* brute, const Segment* a, const Segment* b) {
  for (int i = a->first; i < a->last; i++) {
    for (int j = b->first; j < b->last; j++) {
      if (clash(brute, brute->trial, i, j)) {
        return true;
      }
    }
  }
  return false;
}

static int testAll(void* self) {
  Brute* brute = self;
  for (int i = 1; i < brute->scene->particleCount; i++) {
    for (int j = 0; j < i; j++) {
      if (clash(brute, brute->spheres, i, j)) {
        return 1;
      }
    }
  }
  return 0;
}

static int test(void* self, int count, const Turn* turns) {
  Brute* brute = self;
  Bodies bodies;
  bodiesMove(brute->scene, brute->spheres, count, turns, &bodies);
  bodiesApply(&bodies, brute->spheres, brute->trial);
  for (int a = 0; a < bodies.segmentCount; a++) {
    for (int b = a + 1; b < bodies.segmentCount; b++) {
      if (bodies.segments[a].body != bodies.segments[b].body &&
          segmentsClash(brute, &bodies.segments[a], &bodies.segments[b])) {
        return 1;
      }
    }
  }
  return 0;
}

static bool accept(void* self) {
  Brute* brute = self;
  Sphere* trial = brute->spheres;
  brute->spheres = brute->trial;
  brute->trial = trial;
  return true;
}

static void reject(void* self) {
  (void)self;
}

static Counts counts(const void* self) {
  return ((const Brute*)self)->counts;
}

static const Sphere* spheres(const void* self) {
  return ((const Brute*)self)->spheres;
}

const Contestant CONTESTANT(contestantBrute) = {.name = "brute",
                                                .idea = "all pairs of particles of different rigid pieces",
                                                .make = make,
                                                .destroy = destroy,
                                                .test = test,
                                                .accept = accept,
                                                .reject = reject,
                                                .testAll = testAll,
                                                .counts = counts,
                                                .spheres = spheres};
