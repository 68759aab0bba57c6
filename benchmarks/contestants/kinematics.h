/* What the driver sees of a way to know where a scene's particles are while its torsions turn, one after another. */
#ifndef KINEMATICS_H_
#define KINEMATICS_H_

#include "contestant.h"

typedef struct Kinematics {
  const char* name;
  const char* idea; /* one line about it */

  /* NULL if there is no memory. The scene, a chain without branches, must outlive it. */
  void* (*make)(const Scene* scene);
  void (*destroy)(void* self);

  /* Takes a turn over; false if there is no memory. */
  bool (*turn)(void* self, const Turn* turn);

  /* Brings up to date what a search for clashes would look at; NULL where `turn` has done so. */
  void (*update)(void* self);

  /* Writes 3 * particleCount coordinates, after an update; false if there is no memory. */
  bool (*positions)(void* self, double* positions);

  /* Writes the angle that each torsion has turned in all; NULL where that is not kept. False if there is no memory. */
  bool (*angles)(const void* self, double* angles);

  /* As of contestants. */
  const char* (*instructionSet)(const void* self);
} Kinematics;

#endif /* KINEMATICS_H_ */
