/* A balanced tree of shortcuts over the joints of a chain, as in the paper (section 2.1). A file that includes this is
 * one contestant; before, it defines REAL, and ABSOLUTE: 1 if a joint is made anew from the angle that it has turned in
 * all, 0 if each turn is multiplied on it. */
#include "forward.h"
#include "kinematics.h"

enum { MOST_LEVELS = 32 };

typedef struct Shortcuts {
  Forward forward; /* its joints are level 0 */
  int levelCount;
  int levelSizes[MOST_LEVELS];
  Rigid* levels[MOST_LEVELS]; /* of a node: from the frame behind its joints to that before them */
} Shortcuts;

static void destroy(void* self) {
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

static void* make(const Scene* scene) {
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
      destroy(shortcuts);
      return NULL;
    }
    for (int i = 0; i < size; i++) {
      compose(shortcuts, level, i);
    }
  }
  return shortcuts;
}

#if ABSOLUTE
static void changeJoint(Forward* forward, const Turn* turn) {
  forwardTurn(forward, turn);
}

static bool angles(const void* self, double* angles) {
  const Forward* forward = &((const Shortcuts*)self)->forward;
  for (int t = 0; t < forward->scene->torsionCount; t++) {
    angles[t] = (double)forward->angles[t];
  }
  return true;
}
#else
static void changeJoint(Forward* forward, const Turn* turn) {
  const REAL origin[3] = {0, 0, 0};
  Rigid* joint = &forward->joints[turn->torsion];
  const Rigid rotation = rigidTurn(origin, forward->axes[turn->torsion], (REAL)turn->angle);
  *joint = rigidCompose(joint, &rotation);
}
#endif

static bool turn(void* self, const Turn* turn) {
  Shortcuts* shortcuts = self;
  changeJoint(&shortcuts->forward, turn);
  for (int level = 1; level < shortcuts->levelCount; level++) {
    compose(shortcuts, level, turn->torsion >> level);
  }
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

static bool positions(void* self, double* positions) {
  const Shortcuts* shortcuts = self;
  Rigid frame = rigidIdentity();
  for (int k = 0; k < 3; k++) {
    frame.t[k] = (REAL)shortcuts->forward.scene->spheres[0].x[k];
  }
  place(&shortcuts->forward, 0, &frame, positions);
  placeNode(shortcuts, shortcuts->levelCount - 1, 0, &frame, positions);
  return true;
}

#define SHORTCUTS(itsName, itsIdea, itsAngles)                                                                \
  {                                                                                                           \
    .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .turn = turn, .positions = positions, \
    .angles = itsAngles                                                                                       \
  }
