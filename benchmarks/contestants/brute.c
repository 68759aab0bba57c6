/* All pairs of particles that a trial moves relative to each other: the measure of right and wrong. */
#include "keeper.h"

static void* make(const Scene* scene) {
  return keeperMake(scene, sizeof(Keeper));
}

static bool segmentsClash(Keeper* brute, const Segment* a, const Segment* b) {
  const Sphere* spheres = brute->trial;
  for (int i = a->first; i < a->last; i++) {
    for (int j = b->first; j < b->last; j++) {
      const double sum = spheres[i].radius + spheres[j].radius;
      brute->counts.particleTests++;
      if (squaredDistance(spheres[i].x, spheres[j].x) < sum * sum && !sceneExcludes(brute->scene, i, j)) {
        return true;
      }
    }
  }
  return false;
}

static bool test(void* self, int count, const Turn* turns) {
  Bodies bodies;
  keeperMove(self, count, turns, &bodies);
  for (int a = 0; a < bodies.segmentCount; a++) {
    for (int b = a + 1; b < bodies.segmentCount; b++) {
      if (bodies.segments[a].body != bodies.segments[b].body &&
          segmentsClash(self, &bodies.segments[a], &bodies.segments[b])) {
        return true;
      }
    }
  }
  return false;
}

const Contestant CONTESTANT(contestantBrute) = {.name = "brute",
                                                .idea = "all pairs of particles of different rigid pieces",
                                                .make = make,
                                                .destroy = keeperDestroy,
                                                .test = test,
                                                .accept = keeperAccept,
                                                .reject = keeperReject,
                                                .counts = keeperCounts,
                                                .spheres = keeperSpheres};
