#define REAL long double

#include "reference.h"

#include <float.h>

#include "forward.h"

struct Reference {
  Forward forward;
};

bool referenceIsExact(void) {
  return LDBL_MANT_DIG > DBL_MANT_DIG;
}

Reference* referenceMake(const Scene* scene) {
  Reference* reference = calloc(1, sizeof *reference);
  if (reference != NULL && !forwardInit(&reference->forward, scene)) {
    free(reference);
    return NULL;
  }
  return reference;
}

void referenceFree(Reference* reference) {
  if (reference != NULL) {
    forwardFree(&reference->forward);
    free(reference);
  }
}

void referenceTurn(Reference* reference, const Turn* turn) {
  forwardTurn(&reference->forward, turn);
}

void referenceSetAngles(Reference* reference, const double* angles) {
  for (int t = 0; t < reference->forward.scene->torsionCount; t++) {
    forwardSetAngle(&reference->forward, t, angles[t]);
  }
}

void referencePositions(Reference* reference, long double (*positions)[3]) {
  forwardPlace(&reference->forward);
  for (int i = 0; i < reference->forward.scene->particleCount; i++) {
    forwardPosition(&reference->forward, i, positions[i]);
  }
}
