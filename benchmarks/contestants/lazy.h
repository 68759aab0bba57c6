/* What contestants have in common that keep where particles are and look up only what moves: a trial moves pieces
 * relative to the largest one, which is static, and each moving particle is tested against particles that do not move
 * with it. A clash ends the test, and only an accepted trial is written. */
#ifndef LAZY_H_
#define LAZY_H_

#include "keeper.h"

enum { RUN = 16, STRIDE = 8 };

/* Turns below, rad, are small. */
#define SMALL_ANGLE 0.3

typedef struct Lazy {
  Keeper keeper;         /* the trial holds only particles that move */
  Sphere* seen;          /* the same, seen from another body that moves */
  unsigned char* bodies; /* of each particle during a test: its body + 1, or 0 if it rests; else 0 */
  Bodies motion;         /* of the trial */
  bool isSmall;          /* no torsion turns far */
} Lazy;

/* Some particles of a segment, and how they move. */
typedef struct Run {
  int first;
  int last;
  const Segment* segment;
  const Rigid* motion;
  Sphere* moved; /* of all particles; takes where those of the run are */
  /* The bodies that they are tested against, which are where they were before the trial: + 1, or 0, what rests. */
  unsigned char body;
} Run;

/* What a particle is tested against, for searches. */
typedef struct Others {
  const Scene* scene;
  const unsigned char* bodies; /* of each particle */
  unsigned char body;
} Others;

static inline Others lazyOthers(const Lazy* lazy, const Run* run) {
  return (Others){lazy->keeper.scene, lazy->bodies, run->body};
}

static inline int isOther(const void* context, int j) {
  const Others* others = context;
  return others->bodies[j] == others->body;
}

static inline bool otherIsClash(void* context, int i, int j) {
  return !sceneExcludes(((const Others*)context)->scene, i, j);
}

/* Whether the particles of a run clash. */
typedef bool RunMeets(Lazy* lazy, const Run* run);

static inline void lazyDestroy(void* self) {
  Lazy* lazy = self;
  free(lazy->seen);
  free(lazy->bodies);
  keeperDestroy(lazy);
}

/* As keeperMake. */
static inline void* lazyMake(const Scene* scene, size_t size) {
  Lazy* lazy = keeperMake(scene, size);
  lazy->seen = allocate(scene->particleCount, sizeof(Sphere));
  lazy->bodies = allocate(scene->particleCount, 1);
  return lazy;
}

/* The particles of a segment are taken run by run: after large turns from the joint on, near which clashes are most
 * likely; after small ones every so often along the segment, since far from the axis particles move most, and
 * neighbours move much alike. */
static inline bool lazySegmentMeets(Lazy* lazy, const Segment* segment, const Rigid* motion, int body, Sphere* moved,
                                    RunMeets* runMeets) {
  const int runs = (segment->last - segment->first + RUN - 1) / RUN;
  const int stride = lazy->isSmall ? STRIDE : 1;
  const bool backwards = (segment->first == 0) != lazy->isSmall;
  for (int phase = 0; phase < stride; phase++) {
    for (int r = phase; r < runs; r += stride) {
      const int first = segment->first + RUN * (backwards ? runs - 1 - r : r);
      const int last = first + RUN < segment->last ? first + RUN : segment->last;
      if (runMeets(lazy, &(Run){first, last, segment, motion, moved, (unsigned char)body})) {
        return true;
      }
    }
  }
  return false;
}

/* The smaller of two bodies that move is looked up where the other has not moved. */
static inline bool lazyBodiesMeet(Lazy* lazy, int a, int b, RunMeets* runMeets) {
  const Bodies* motion = &lazy->motion;
  const int small = motion->sizes[a] < motion->sizes[b] ? a : b;
  const int large = small == a ? b : a;
  const Rigid back = rigidInvert(&motion->motions[large]);
  const Rigid relative = rigidCompose(&back, &motion->motions[small]);
  for (int s = 0; s < motion->segmentCount; s++) {
    if (motion->segments[s].body == small &&
        lazySegmentMeets(lazy, &motion->segments[s], &relative, large + 1, lazy->seen, runMeets)) {
      return true;
    }
  }
  return false;
}

static inline bool lazyClashes(Lazy* lazy, RunMeets* runMeets) {
  const Bodies* motion = &lazy->motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    if (segment->body != motion->resting &&
        lazySegmentMeets(lazy, segment, &motion->motions[segment->body], 0, lazy->keeper.trial, runMeets)) {
      return true;
    }
  }
  for (int a = 0; a < motion->bodyCount; a++) {
    for (int b = 0; b < a; b++) {
      if (a != motion->resting && b != motion->resting && lazyBodiesMeet(lazy, a, b, runMeets)) {
        return true;
      }
    }
  }
  return false;
}

static inline void lazyMarkBodies(Lazy* lazy, bool marked) {
  const Bodies* motion = &lazy->motion;
  for (int s = 0; s < motion->segmentCount; s++) {
    const Segment* segment = &motion->segments[s];
    if (segment->body != motion->resting) {
      memset(lazy->bodies + segment->first, marked ? segment->body + 1 : 0, (size_t)(segment->last - segment->first));
    }
  }
}

static inline bool lazyTest(Lazy* lazy, int count, const Turn* turns, RunMeets* runMeets) {
  bodiesMove(lazy->keeper.scene, lazy->keeper.spheres, count, turns, &lazy->motion);
  lazy->isSmall = true;
  for (int i = 0; i < count; i++) {
    lazy->isSmall = lazy->isSmall && fabs(turns[i].angle) < SMALL_ANGLE;
  }
  lazyMarkBodies(lazy, true);
  const bool clash = lazyClashes(lazy, runMeets);
  lazyMarkBodies(lazy, false);
  return clash;
}

#endif /* LAZY_H_ */
