/* What the driver sees of a contestant: a structure that holds a scene, tests trials and accepts or rejects them. */
#ifndef CONTESTANT_H_
#define CONTESTANT_H_

#include <stdbool.h>
#include <stdint.h>

#include "memory.h"
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
} Counts;

typedef struct Contestant {
  const char* name;
  const char* idea; /* one line about it */

  /* The scene must outlive what is made. */
  void* (*make)(const Scene* scene);
  void (*destroy)(void* self);

  /* Whether particles clash after `count` turns that did not before. One of the next two follows each test. */
  bool (*test)(void* self, int count, const Turn* turns);
  void (*accept)(void* self);
  void (*reject)(void* self);

  Counts (*counts)(const void* self);

  /* The particles as they are now, up to a motion of them all; NULL where a contestant does not keep them. */
  const Sphere* (*spheres)(const void* self);

  /* The instruction set in use; NULL where it is that of the program. */
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
