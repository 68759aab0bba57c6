/* What an open trial of the scene moves, and where particles are before it and in it. */
#ifndef CT_TRIALVIEW_H_
#define CT_TRIALVIEW_H_

#include "ctenergy.h"

typedef struct TrialView {
  const ctChainTree* tree;
  const ctLeafPositions* state; /* positions of all leaves in the state */
  int pieceCount;
  const ctPiece* pieces;
  const ctTransform* motions; /* of each body */
  int linkCount;              /* 0: the trial displaces single particles, each of which is a piece */
  const int* links;           /* the caller's links that the trial changes */
} TrialView;

/* The piece that a slot is in. O(log pieces). */
static inline const ctPiece* findPiece(const ctPiece* pieces, int count, int slot) {
  while (count > 1) {
    const int half = count / 2;
    pieces += pieces[half].slotBegin <= slot ? half : 0;
    count -= half;
  }
  return pieces;
}

/* The body of a slot. */
static inline int trialBody(const TrialView* view, int slot) {
  return findPiece(view->pieces, view->pieceCount, slot)->body;
}

/* The position of a slot in the state. */
static inline void statePosition(const TrialView* view, int slot, double position[3]) {
  const ctLeafPositions* leaf = &view->state[(unsigned)slot / CT_LEAF_WIDTH];
  const unsigned row = (unsigned)slot % CT_LEAF_WIDTH;
  position[0] = leaf->x[row];
  position[1] = leaf->y[row];
  position[2] = leaf->z[row];
}

/* Moves a position by the motion of a body. */
static inline void moveByBody(const TrialView* view, int body, double position[3]) {
  if (body == 0) {
    return;
  }
  const ctTransform* motion = &view->motions[body];
  const double* r = motion->rotation;
  const double x = position[0];
  const double y = position[1];
  const double z = position[2];
  for (int d = 0; d < 3; d++) {
    position[d] = r[3 * d] * x + r[3 * d + 1] * y + r[3 * d + 2] * z + motion->translation[d];
  }
}

/* By how much a value changes; 0 also between equal infinite ones. */
static inline double changeOf(double before, double after) {
  return after == before ? 0 : after - before;
}

#endif /* CT_TRIALVIEW_H_ */
