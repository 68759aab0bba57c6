/* Positions that are turned with each trial, and kept. A file that includes this is one contestant; before, it defines
 * REAL. */
#include <stdlib.h>

#include "kinematics.h"
#include "rigid.h"

typedef struct Cartesian {
  const Scene* scene;
  REAL (*positions)[3];
} Cartesian;

static void destroy(void* self) {
  Cartesian* cartesian = self;
  if (cartesian != NULL) {
    free(cartesian->positions);
    free(cartesian);
  }
}

static void* make(const Scene* scene) {
  Cartesian* cartesian = calloc(1, sizeof *cartesian);
  if (cartesian == NULL) {
    return NULL;
  }
  cartesian->scene = scene;
  cartesian->positions = calloc((size_t)scene->particleCount + 1, sizeof *cartesian->positions);
  if (cartesian->positions == NULL) {
    destroy(cartesian);
    return NULL;
  }
  for (int i = 0; i < scene->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      cartesian->positions[i][k] = (REAL)scene->spheres[i].x[k];
    }
  }
  return cartesian;
}

static bool turn(void* self, const Turn* turn) {
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

static bool positions(void* self, double* positions) {
  const Cartesian* cartesian = self;
  for (int i = 0; i < cartesian->scene->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = (double)cartesian->positions[i][k];
    }
  }
  return true;
}

#define CARTESIAN(itsName, itsIdea) \
  { .name = itsName, .idea = itsIdea, .make = make, .destroy = destroy, .turn = turn, .positions = positions }
