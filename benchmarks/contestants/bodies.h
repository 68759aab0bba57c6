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

/* A cut of all particles into segments, in their order. Each turn makes a body, of what it moves and no turn further
 * out does; body 0 is what no turn moves. Nothing but relative motion counts for a clash, so the largest body stays
 * where it is. */
typedef struct Bodies {
  int segmentCount;
  Segment segments[2 * MOST_TURNS + 1];
  int bodyCount;
  int sizes[MOST_TURNS + 1];   /* in particles */
  int parents[MOST_TURNS + 1]; /* the body that a turn's own hangs on */
  Turn turns[MOST_TURNS + 1];
  int resting; /* the largest body */
  Rigid motions[MOST_TURNS + 1];
} Bodies;

/* Fills all but the motions. Outer turns come before the turns that they move. */
void bodiesCut(const Scene* scene, int turnCount, const Turn* turns, Bodies* bodies);

/* Fills the motions too; `spheres` are the particles before the trial. */
void bodiesMove(const Scene* scene, const Sphere* spheres, int turnCount, const Turn* turns, Bodies* bodies);

/* Writes all particles as they are in the trial. */
void bodiesApply(const Bodies* bodies, const Sphere* spheres, Sphere* trial);

static inline Sphere movedSphere(const Rigid* motion, const Sphere* sphere) {
  Sphere moved;
  rigidApply(motion, sphere->x, moved.x);
  moved.radius = sphere->radius;
  return moved;
}

#endif /* BODIES_H_ */
