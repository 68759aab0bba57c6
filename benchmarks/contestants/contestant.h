/* What the driver sees of a contestant: a structure that holds a scene, tests trials and takes them over or not. */
#ifndef CONTESTANT_H_
#define CONTESTANT_H_

#include <stdbool.h>
#include <stdint.h>

#include "scene.h"

enum { MOST_TURNS = 64 };

/* Part of a trial: this torsion of the scene turns by this angle, rad. A trial names a torsion once. */
typedef struct Turn {
  int torsion;
  double angle;
} Turn;

/* What a contestant has done so far. */
typedef struct Counts {
  int64_t volumeTests;   /* pairs of bounding volumes compared */
  int64_t particleTests; /* pairs of particles whose distance was computed */
  int64_t updates;       /* what it keeps about a part of the scene, recomputed: a node, or the cell of a particle */
} Counts;

typedef struct Contestant {
  const char* name;
  const char* idea; /* one line about it */

  /* NULL if there is no memory. The scene must outlive it. */
  void* (*make)(const Scene* scene);
  void (*destroy)(void* self);

  /* Whether particles clash after `count` turns that did not before: 1, or 0; -1 if there is no memory. */
  int (*test)(void* self, int count, const Turn* turns);

  /* One of these follows each test; `accept` is false if there is no memory. */
  bool (*accept)(void* self);
  void (*reject)(void* self);

  /* Whether any particles clash as they are now, between trials: 1, 0, or -1 if there is no memory. NULL where that is
   * no business of a contestant. */
  int (*testAll)(void* self);

  Counts (*counts)(const void* self);

  /* The particles as they are now, up to a motion of them all; NULL where a contestant does not keep them. */
  const Sphere* (*spheres)(const void* self);

  /* Writes them as 3 * particleCount coordinates; NULL where `spheres` has them already. */
  void (*positions)(void* self, double* coordinates);

  /* The instruction set in use; NULL where it is the one that a contestant is compiled for. */
  const char* (*instructionSet)(const void* self);
} Contestant;

/* Contestants are compiled once for each instruction set, under names of its own. */
#ifndef CONTESTANT_ISA
#define CONTESTANT_ISA Portable
#endif
#define CONTESTANT_JOIN_(a, b) a##b
#define CONTESTANT_JOIN(a, b) CONTESTANT_JOIN_(a, b)
#define CONTESTANT(name) CONTESTANT_JOIN(name, CONTESTANT_ISA)

#endif /* CONTESTANT_H_ */
