/* The engine of this project as a way to know where particles are, with each instruction set. */
#include <stdlib.h>

#include "kinematics.h"
#include "ourtree.h"

typedef struct OurKinematics {
  const Scene* scene;
  ctChainTree* tree;
  double* state; /* room for it */
} OurKinematics;

static void destroy(void* self) {
  OurKinematics* ours = self;
  if (ours != NULL) {
    ctDestroy(ours->tree);
    free(ours->state);
    free(ours);
  }
}

static void* make(const Scene* scene, const char* instructionSet) {
  OurKinematics* ours = calloc(1, sizeof *ours);
  if (ours == NULL) {
    return NULL;
  }
  ours->scene = scene;
  ours->tree = ourTreeWith(scene, "CHAINTREE_SIMD", instructionSet);
  ours->state = ours->tree == NULL ? NULL : calloc(ctGetStateSize(ours->tree), sizeof(double));
  if (ours->state == NULL) {
    destroy(ours);
    return NULL;
  }
  return ours;
}

static void* makeAvx512(const Scene* scene) {
  return make(scene, "avx512");
}

static void* makeAvx2(const Scene* scene) {
  return make(scene, "avx2");
}

static void* makePortable(const Scene* scene) {
  return make(scene, "portable");
}

static bool turn(void* self, const Turn* turn) {
  OurKinematics* ours = self;
  const ctChange change = {.link = ours->scene->torsions[turn->torsion].link, .angle = turn->angle};
  return ctPropose(ours->tree, 1, &change) == ctSuccess && ctAccept(ours->tree, NULL) == ctSuccess;
}

static bool positions(void* self, double* positions) {
  ctGetPositions(((OurKinematics*)self)->tree, positions);
  return true;
}

/* In the state, behind the reference positions, a link has as many numbers as its joint: a torsion one, a root seven.
 */
static bool angles(const void* self, double* angles) {
  enum { TORSION_NUMBERS = 1, ROOT_NUMBERS = 7 };
  const OurKinematics* ours = self;
  const Scene* scene = ours->scene;
  int* torsionOfLink = calloc((size_t)scene->linkCount + 1, sizeof(int));
  if (torsionOfLink == NULL) {
    return false;
  }
  for (int t = 0; t < scene->torsionCount; t++) {
    torsionOfLink[scene->torsions[t].link] = t;
  }
  ctGetState(ours->tree, ours->state);
  const double* numbers = ours->state + 3 * (size_t)scene->particleCount;
  for (int link = 0; link < scene->linkCount; link++) {
    const bool isRoot = scene->linkParents[link] < 0;
    if (!isRoot) {
      angles[torsionOfLink[link]] = numbers[0];
    }
    numbers += isRoot ? ROOT_NUMBERS : TORSION_NUMBERS;
  }
  free(torsionOfLink);
  return true;
}

static const char* instructionSet(const void* self) {
  return ctGetInstructionSet(((const OurKinematics*)self)->tree);
}

#define OUR_KINEMATICS(itsName, itsIdea, itsMake)                                                                \
  {                                                                                                              \
    .name = itsName, .idea = itsIdea, .make = itsMake, .destroy = destroy, .turn = turn, .positions = positions, \
    .angles = angles, .instructionSet = instructionSet                                                           \
  }

const Kinematics kinematicsOursAvx512 = OUR_KINEMATICS("ours-avx512", "the engine with AVX-512", makeAvx512);
const Kinematics kinematicsOursAvx2 = OUR_KINEMATICS("ours-avx2", "the engine with AVX2", makeAvx2);
const Kinematics kinematicsOursPortable = OUR_KINEMATICS("ours-portable", "the engine in plain C", makePortable);
