/* All pairs of particles that a trial moves relative to each other: the measure of right and wrong. */
#include "keeper.h"

static void* make(const Scene* scene) {
  return keeperMake(scene, sizeof(Keeper));
}

static bool clash(Keeper* brute, const Sphere* spheres, int i, int j) {
  const double sum = spheres[i].radius + spheres[j].radius;
  brute->counts.particleTests++;
  return squaredDistance(spheres[i].x, spheres[j].x) < sum * sum && !sceneExcludes(brute->scene, i, j);
}

static bool segmentsClash(Keeper* brute, const Segment* a, const Segment* b) {
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
  Keeper* brute = self;
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
  Bodies bodies;
  keeperMove(self, count, turns, &bodies);
  for (int a = 0; a < bodies.segmentCount; a++) {
    for (int b = a + 1; b < bodies.segmentCount; b++) {
      if (bodies.segments[a].body != bodies.segments[b].body &&
          segmentsClash(self, &bodies.segments[a], &bodies.segments[b])) {
        return 1;
      }
    }
  }
  return 0;
}

const Contestant CONTESTANT(contestantBrute) = {.name = "brute",
                                                .idea = "all pairs of particles of different rigid pieces",
                                                .make = make,
                                                .destroy = keeperDestroy,
                                                .test = test,
                                                .accept = keeperAccept,
                                                .reject = keeperReject,
                                                .testAll = testAll,
                                                .counts = keeperCounts,
                                                .spheres = keeperSpheres};
