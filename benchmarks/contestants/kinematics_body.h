/* Ways to know where particles are, in one precision. Before a file includes this, it defines
 *
 *   REAL              double or float
 *   PRECISE(name)     what a contestant is called in C
 *   IN_WORDS(words)   what it is called by users
 *   PRECISION         "double" or "single" */
#include <stdlib.h>
#include <string.h>

#include "forward.h"
#include "kinematics.h"

/* The angles that torsions have turned in all; a contestant that keeps them begins with a Forward. */
static bool forwardAngles(const void* self, double* angles) {
  const Forward* forward = self;
  for (int t = 0; t < forward->scene->torsionCount; t++) {
    angles[t] = (double)forward->angles[t];
  }
  return true;
}

/* ---- Positions that are turned with each trial, and kept ---- */

typedef struct Cartesian {
  const Scene* scene;
  REAL (*positions)[3];
} Cartesian;

static void cartesianDestroy(void* self) {
  Cartesian* cartesian = self;
  if (cartesian != NULL) {
    free(cartesian->positions);
    free(cartesian);
  }
}

static void* cartesianMake(const Scene* scene) {
  Cartesian* cartesian = calloc(1, sizeof *cartesian);
  if (cartesian == NULL) {
    return NULL;
  }
  cartesian->scene = scene;
  cartesian->positions = calloc((size_t)scene->particleCount + 1, sizeof *cartesian->positions);
  if (cartesian->positions == NULL) {
    cartesianDestroy(cartesian);
    return NULL;
  }
  for (int i = 0; i < scene->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      cartesian->positions[i][k] = (REAL)scene->spheres[i].x[k];
    }
  }
  return cartesian;
}

static bool cartesianTurn(void* self, const Turn* turn) {
  Cartesian* cartesian = self;
  const Torsion* torsion = &cartesian->scene->torsions[turn->torsion];
  REAL(*x)[3] = cartesian->positions;
  const Rigid motion = rigidTurn(x[torsion->axis[0]], x[torsion->axis[1]], (REAL)turn->angle);
  for (int i = torsion->first; i < torsion->last; i++) {
    REAL moved[3];
    rigidApply(&motion, x[i], moved);
    for (int k = 0; k < 3; k++) {
      x[i][k] = moved[k];
    }
  }
  return true;
}

static bool cartesianPositions(void* self, double* positions) {
  const Cartesian* cartesian = self;
  for (int i = 0; i < cartesian->scene->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = (double)cartesian->positions[i][k];
    }
  }
  return true;
}

const Kinematics CONTESTANT(PRECISE(kinematicsCartesian)) = {.name = IN_WORDS("cartesian"),
                                                             .idea = "positions turned and kept, in " PRECISION,
                                                             .make = cartesianMake,
                                                             .destroy = cartesianDestroy,
                                                             .turn = cartesianTurn,
                                                             .positions = cartesianPositions};

/* ---- Forward kinematics of the whole chain for each trial ---- */

static void sequentialDestroy(void* self) {
  if (self != NULL) {
    forwardFree(self);
    free(self);
  }
}

static void* sequentialMake(const Scene* scene) {
  Forward* forward = calloc(1, sizeof *forward);
  if (forward == NULL || !forwardInit(forward, scene)) {
    free(forward);
    return NULL;
  }
  return forward;
}

static bool sequentialTurn(void* self, const Turn* turn) {
  forwardTurn(self, turn);
  return true;
}

static void sequentialUpdate(void* self) {
  forwardPlace(self);
}

static bool sequentialPositions(void* self, double* positions) {
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

const Kinematics CONTESTANT(PRECISE(kinematicsSequential)) = {
    .name = IN_WORDS("sequential"),
    .idea = "link after link by absolute angles, in " PRECISION,
    .make = sequentialMake,
    .destroy = sequentialDestroy,
    .turn = sequentialTurn,
    .update = sequentialUpdate,
    .positions = sequentialPositions,
    .angles = forwardAngles};

/* ---- A balanced tree of shortcuts over the joints of a chain, as in the paper (section 2.1) ---- */

enum { MOST_LEVELS = 32 };

typedef struct Shortcuts {
  Forward forward; /* its joints are level 0 */
  int levelCount;
  int levelSizes[MOST_LEVELS];
  Rigid* levels[MOST_LEVELS]; /* of a node: from the frame behind its joints to that before them */
} Shortcuts;

static void shortcutsDestroy(void* self) {
  Shortcuts* shortcuts = self;
  if (shortcuts != NULL) {
    for (int level = 1; level < shortcuts->levelCount; level++) {
      free(shortcuts->levels[level]);
    }
    forwardFree(&shortcuts->forward);
    free(shortcuts);
  }
}

static void compose(Shortcuts* shortcuts, int level, int index) {
  const Rigid* children = &shortcuts->levels[level - 1][2 * index];
  const bool hasTwo = 2 * index + 1 < shortcuts->levelSizes[level - 1];
  shortcuts->levels[level][index] = hasTwo ? rigidCompose(&children[0], &children[1]) : children[0];
}

static void* shortcutsMake(const Scene* scene) {
  Shortcuts* shortcuts = calloc(1, sizeof *shortcuts);
  if (shortcuts == NULL || !forwardInit(&shortcuts->forward, scene)) {
    free(shortcuts);
    return NULL;
  }
  shortcuts->levelSizes[0] = scene->torsionCount;
  shortcuts->levels[0] = shortcuts->forward.joints;
  shortcuts->levelCount = 1;
  for (int size = scene->torsionCount; size > 1; shortcuts->levelCount++) {
    const int level = shortcuts->levelCount;
    size = (size + 1) / 2;
    shortcuts->levelSizes[level] = size;
    shortcuts->levels[level] = calloc((size_t)size, sizeof(Rigid));
    if (shortcuts->levels[level] == NULL) {
      shortcutsDestroy(shortcuts);
      return NULL;
    }
    for (int i = 0; i < size; i++) {
      compose(shortcuts, level, i);
    }
  }
  return shortcuts;
}

static void multiplyJoint(Forward* forward, const Turn* turn) {
  const REAL origin[3] = {0, 0, 0};
  Rigid* joint = &forward->joints[turn->torsion];
  const Rigid rotation = rigidTurn(origin, forward->axes[turn->torsion], (REAL)turn->angle);
  *joint = rigidCompose(joint, &rotation);
}

static void composeAbove(Shortcuts* shortcuts, int torsion) {
  for (int level = 1; level < shortcuts->levelCount; level++) {
    compose(shortcuts, level, torsion >> level);
  }
}

/* The joint is made anew from the angle that it has turned in all. */
static bool shortcutsTurn(void* self, const Turn* turn) {
  forwardTurn(&((Shortcuts*)self)->forward, turn);
  composeAbove(self, turn->torsion);
  return true;
}

/* The turn is multiplied on the joint. */
static bool multipliedTurn(void* self, const Turn* turn) {
  multiplyJoint(&((Shortcuts*)self)->forward, turn);
  composeAbove(self, turn->torsion);
  return true;
}

/* The particles before torsion `next` that follow those before the one before it. */
static void place(const Forward* forward, int next, const Rigid* frame, double* positions) {
  const Scene* scene = forward->scene;
  const int first = next == 0 ? 0 : scene->torsions[next - 1].first;
  const int last = next == scene->torsionCount ? scene->particleCount : scene->torsions[next].first;
  for (int i = first; i < last; i++) {
    REAL position[3];
    rigidApply(frame, forward->locals[i], position);
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = (double)position[k];
    }
  }
}

/* What lies behind each joint of a node; `frame` is that before them. */
static void placeNode(const Shortcuts* shortcuts, int level, int index, const Rigid* frame, double* positions) {
  if (level == 0) {
    const Rigid behind = rigidCompose(frame, &shortcuts->levels[0][index]);
    place(&shortcuts->forward, index + 1, &behind, positions);
    return;
  }
  placeNode(shortcuts, level - 1, 2 * index, frame, positions);
  if (2 * index + 1 < shortcuts->levelSizes[level - 1]) {
    const Rigid middle = rigidCompose(frame, &shortcuts->levels[level - 1][2 * index]);
    placeNode(shortcuts, level - 1, 2 * index + 1, &middle, positions);
  }
}

static bool shortcutsPositions(void* self, double* positions) {
  const Shortcuts* shortcuts = self;
  Rigid frame = rigidIdentity();
  for (int k = 0; k < 3; k++) {
    frame.t[k] = (REAL)shortcuts->forward.scene->spheres[0].x[k];
  }
  place(&shortcuts->forward, 0, &frame, positions);
  placeNode(shortcuts, shortcuts->levelCount - 1, 0, &frame, positions);
  return true;
}

const Kinematics CONTESTANT(PRECISE(kinematicsShortcuts)) = {.name = IN_WORDS("shortcuts"),
                                                             .idea = "shortcuts from absolute angles, in " PRECISION,
                                                             .make = shortcutsMake,
                                                             .destroy = shortcutsDestroy,
                                                             .turn = shortcutsTurn,
                                                             .positions = shortcutsPositions,
                                                             .angles = forwardAngles};

const Kinematics CONTESTANT(PRECISE(kinematicsMultiplied)) = {.name = IN_WORDS("multiplied"),
                                                              .idea = "joint matrices multiplied on, in " PRECISION,
                                                              .make = shortcutsMake,
                                                              .destroy = shortcutsDestroy,
                                                              .turn = multipliedTurn,
                                                              .positions = shortcutsPositions};
