/* Forward kinematics: each link is placed on the one that it hangs on, from the root on, by the angle that its torsion
 * has turned in all. In double, or in what a file that includes this has defined REAL as. */
#ifndef FORWARD_H_
#define FORWARD_H_

#include <stdlib.h>
#include <string.h>

#include "contestant.h"
#include "random.h"
#include "rigid.h"

/* Literals of long double are right for any REAL. */
#define FULL_TURN ((REAL)6.283185307179586476925286766559005768L)

typedef struct Forward {
  const Scene* scene;
  REAL* angles;      /* of each torsion, turned in all, within half a turn */
  Rigid* joints;     /* of each torsion: from the frame of its link to that of the parent */
  Rigid* frames;     /* of each link, to the world */
  REAL (*axes)[3];   /* of each torsion, from the particle of the parent to that of the link */
  REAL (*locals)[3]; /* of each particle, in the frame of its link */
} Forward;

static inline void forwardFree(Forward* forward) {
  free(forward->angles);
  free(forward->joints);
  free(forward->frames);
  free(forward->axes);
  free(forward->locals);
}

static inline void forwardSetAngle(Forward* forward, int torsion, REAL angle) {
  const REAL origin[3] = {0, 0, 0};
  Rigid* joint = &forward->joints[torsion];
  const Rigid turn = rigidTurn(origin, forward->axes[torsion], angle);
  forward->angles[torsion] = angle;
  memcpy(joint->r, turn.r, sizeof joint->r);
}

static inline void forwardTurn(Forward* forward, const Turn* turn) {
  const REAL angle = forward->angles[turn->torsion] + (REAL)turn->angle;
  forwardSetAngle(forward, turn->torsion, remainder(angle, FULL_TURN));
}

/* Coordinates are rounded to REAL before anything else is. */
static inline void forwardSpan(const double from[3], const double to[3], REAL span[3]) {
  for (int k = 0; k < 3; k++) {
    span[k] = (REAL)to[k] - (REAL)from[k];
  }
}

/* A link's frame has its origin at the far particle of its torsion's axis, or at the scene's first. */
static inline void forwardMeasure(Forward* forward, const int* originOfLink) {
  const Scene* scene = forward->scene;
  for (int t = 0; t < scene->torsionCount; t++) {
    const Torsion* torsion = &scene->torsions[t];
    const double* origin = scene->spheres[torsion->axis[1]].x;
    forwardSpan(scene->spheres[torsion->axis[0]].x, origin, forward->axes[t]);
    forwardSpan(scene->spheres[originOfLink[scene->linkParents[torsion->link]]].x, origin, forward->joints[t].t);
    forwardSetAngle(forward, t, 0);
  }
  for (int i = 0; i < scene->particleCount; i++) {
    forwardSpan(scene->spheres[originOfLink[scene->particleLinks[i]]].x, scene->spheres[i].x, forward->locals[i]);
  }
}

/* As the scene is; false if there is no memory. */
static inline bool forwardInit(Forward* forward, const Scene* scene) {
  const size_t torsions = (size_t)scene->torsionCount + 1;
  const size_t links = (size_t)scene->linkCount + 1;
  const size_t particles = (size_t)scene->particleCount + 1;
  *forward = (Forward){.scene = scene,
                       .angles = calloc(torsions, sizeof(REAL)),
                       .joints = calloc(torsions, sizeof(Rigid)),
                       .frames = calloc(links, sizeof(Rigid)),
                       .axes = calloc(torsions, sizeof *forward->axes),
                       .locals = calloc(particles, sizeof *forward->locals)};
  int* originOfLink = calloc(links, sizeof(int));
  const bool success = forward->angles != NULL && forward->joints != NULL && forward->frames != NULL &&
                       forward->axes != NULL && forward->locals != NULL && originOfLink != NULL;
  if (success) {
    for (int t = 0; t < scene->torsionCount; t++) {
      originOfLink[scene->torsions[t].link] = scene->torsions[t].axis[1];
    }
    forwardMeasure(forward, originOfLink);
  } else {
    forwardFree(forward);
    *forward = (Forward){0};
  }
  free(originOfLink);
  return success;
}

/* Brings the frames up to date. Torsions come in the order of what they move, so a parent before its children. */
static inline void forwardPlace(Forward* forward) {
  const Scene* scene = forward->scene;
  for (int link = 0; link < scene->linkCount; link++) {
    if (scene->linkParents[link] < 0) {
      forward->frames[link] = rigidIdentity();
      for (int k = 0; k < 3; k++) {
        forward->frames[link].t[k] = (REAL)scene->spheres[0].x[k];
      }
    }
  }
  for (int t = 0; t < scene->torsionCount; t++) {
    const int link = scene->torsions[t].link;
    forward->frames[link] = rigidCompose(&forward->frames[scene->linkParents[link]], &forward->joints[t]);
  }
}

/* By the frames. */
static inline void forwardPosition(const Forward* forward, int particle, REAL position[3]) {
  rigidApply(&forward->frames[forward->scene->particleLinks[particle]], forward->locals[particle], position);
}

#endif /* FORWARD_H_ */
