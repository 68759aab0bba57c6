/* Forward kinematics of the whole chain for each trial. A file that includes this is one contestant; before, it defines
 * REAL. */
#include "forward.h"
#include "kinematics.h"

static void destroy(void* self) {
  if (self != NULL) {
    forwardFree(self);
    free(self);
  }
}

static void* make(const Scene* scene) {
  Forward* forward = calloc(1, sizeof *forward);
  if (forward == NULL || !forwardInit(forward, scene)) {
    free(forward);
    return NULL;
  }
  return forward;
}

static bool turn(void* self, const Turn* turn) {
  forwardTurn(self, turn);
  return true;
}

static void update(void* self) {
  forwardPlace(self);
}

static bool positions(void* self, double* positions) {
  const Forward* forward = self;
  for (int i = 0; i < forward->scene->particleCount; i++) {
    REAL position[3];
    forwardPosition(forward, i, position);
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = (double)position[k];
    }
  }
  return true;
}

static bool angles(const void* self, double* angles) {
  const Forward* forward = self;
  for (int t = 0; t < forward->scene->torsionCount; t++) {
    angles[t] = (double)forward->angles[t];
  }
  return true;
}

#define SEQUENTIAL(itsName, itsIdea)                                                                    \
  {                                                                                                     \
    .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .turn = turn, .update = update, \
    .positions = positions, .angles = angles                                                            \
  }
