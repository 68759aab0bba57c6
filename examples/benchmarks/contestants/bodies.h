/* Which particles a trial moves together, and by what: the rigid pieces of the paper (section 2.3). */
#ifndef BODIES_H_
#define BODIES_H_

#include "contestant.h"
#include "rigid.h"

/* Particles first ... last - 1 belong to one body. */
typedef struct Segment {
  int first;
  int last;
  int body;
} Segment;

/* A cut of all particles into segments, in their order. Nothing but relative motion counts for a clash, so the largest
 * body stays where it is: body `resting`. */
typedef struct Bodies {
  int segmentCount;
  Segment segments[2 * MOST_TURNS + 1];
  int bodyCount;
  int resting;
  Rigid motions[MOST_TURNS + 1];
  int sizes[MOST_TURNS + 1]; /* in particles */
} Bodies;

/* `spheres` are the particles before the trial. */
void bodiesOf(const Scene* scene, const Sphere* spheres, int turnCount, const Turn* turns, Bodies* bodies);

/* The body of particle i. */
static inline int bodyOf(const Bodies* bodies, int i) {
  int s = 0;
  while (bodies->segments[s].last <= i) {
    s++;
  }
  return bodies->segments[s].body;
}

static inline Sphere movedSphere(const Rigid* motion, const Sphere* sphere) {
  Sphere moved;
  rigidApply(motion, sphere->x, moved.x);
  moved.radius = sphere->radius;
  return moved;
}

#endif /* BODIES_H_ */
