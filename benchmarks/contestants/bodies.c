#include "bodies.h"

#include <string.h>

/* Outer turns first. */
static void sortTurns(const Scene* scene, int count, const Turn* turns, Turn* sorted) {
  for (int i = 0; i < count; i++) {
    int k = i;
    for (; k > 0 && scene->torsions[sorted[k - 1].torsion].first > scene->torsions[turns[i].torsion].first; k--) {
      sorted[k] = sorted[k - 1];
    }
    sorted[k] = turns[i];
  }
}

static void addSegment(Bodies* bodies, int first, int last, int body) {
  if (first < last) {
    bodies->segments[bodies->segmentCount++] = (Segment){first, last, body};
    bodies->sizes[body] += last - first;
  }
}

/* Intervals of torsions are nested or apart, so the intervals around a particle form a stack. */
static void cut(const Scene* scene, int count, const Turn* sorted, Bodies* bodies) {
  int openBodies[MOST_TURNS + 1] = {0};
  int openEnds[MOST_TURNS + 1] = {scene->particleCount};
  int depth = 0;
  int cursor = 0;
  for (int i = 0; i <= count; i++) {
    const Torsion* torsion = i < count ? &scene->torsions[sorted[i].torsion] : NULL;
    const int first = torsion != NULL ? torsion->first : scene->particleCount;
    while (depth > 0 && openEnds[depth] <= first) {
      addSegment(bodies, cursor, openEnds[depth], openBodies[depth]);
      cursor = openEnds[depth--];
    }
    addSegment(bodies, cursor, first, openBodies[depth]);
    cursor = first;
    if (torsion != NULL) {
      const int body = bodies->bodyCount++;
      bodies->sizes[body] = 0;
      bodies->parents[body] = openBodies[depth];
      bodies->turns[body] = sorted[i];
      openBodies[++depth] = body;
      openEnds[depth] = torsion->last;
    }
  }
}

void bodiesCut(const Scene* scene, int turnCount, const Turn* turns, Bodies* bodies) {
  Turn sorted[MOST_TURNS];
  sortTurns(scene, turnCount, turns, sorted);
  bodies->segmentCount = 0;
  bodies->bodyCount = 1;
  bodies->sizes[0] = 0;
  cut(scene, turnCount, sorted, bodies);
  bodies->resting = 0;
  for (int body = 1; body < bodies->bodyCount; body++) {
    bodies->resting = bodies->sizes[body] > bodies->sizes[bodies->resting] ? body : bodies->resting;
  }
}

static void restLargest(Bodies* bodies) {
  const Rigid back = rigidInvert(&bodies->motions[bodies->resting]);
  for (int body = 0; body < bodies->bodyCount; body++) {
    bodies->motions[body] = rigidCompose(&back, &bodies->motions[body]);
  }
  bodies->motions[bodies->resting] = rigidIdentity();
}

void bodiesMove(const Scene* scene, const Sphere* spheres, int turnCount, const Turn* turns, Bodies* bodies) {
  bodiesCut(scene, turnCount, turns, bodies);
  bodies->motions[0] = rigidIdentity();
  for (int body = 1; body < bodies->bodyCount; body++) {
    const int* axis = scene->torsions[bodies->turns[body].torsion].axis;
    const Rigid turn = rigidTurn(spheres[axis[0]].x, spheres[axis[1]].x, bodies->turns[body].angle);
    bodies->motions[body] = rigidCompose(&bodies->motions[bodies->parents[body]], &turn);
  }
  if (bodies->resting != 0) {
    restLargest(bodies);
  }
}

void bodiesApply(const Bodies* bodies, const Sphere* spheres, Sphere* trial) {
  for (int s = 0; s < bodies->segmentCount; s++) {
    const Segment* segment = &bodies->segments[s];
    if (segment->body == bodies->resting) {
      memcpy(trial + segment->first, spheres + segment->first,
             (size_t)(segment->last - segment->first) * sizeof(Sphere));
    } else {
      for (int i = segment->first; i < segment->last; i++) {
        trial[i] = movedSphere(&bodies->motions[segment->body], &spheres[i]);
      }
    }
  }
}
