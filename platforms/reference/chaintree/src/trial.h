/* A trial: changes of some joints, and the pieces of the sequence that they move as rigid bodies. */
#ifndef CT_TRIAL_H_
#define CT_TRIAL_H_

#include "traverse.h"

typedef struct TrialChange {
  int link;
  JointState before;
  JointState after;
  Frame motion; /* of the link in the world, were this the only change */
} TrialChange;

typedef struct Trial {
  bool open;
  int count;
  int capacity;         /* of the arrays below, in changes */
  TrialChange* changes; /* ascending by link */
  int pieceCount;
  Piece* pieces;
  int motionCount;
  Frame* motions; /* of change i and all changes around it: i + 1; 0: the identity */
  int* links;     /* of the changes */
  int* motionOf;  /* scratch: one a change */
  int* scratch;   /* scratch: one a change */
} Trial;

/* Makes room for a number of changes; false, and nothing changed, if there is no memory. */
bool ctTrialReserve(Trial* trial, int count);

/* Completes a trial whose changes 0 .. count - 1 have link and the caller's change, unsorted; computes joint states,
 * motions and pieces from the state. `given` is in the order of the changes. Returns the link that occurs twice, or
 * CT_NULL. */
int ctTrialOpen(Trial* trial, const Sequence* sequence, Traversal* traversal, const ctChange* given, int count);

/* Puts the changes' joints into their states after (or before) the trial, and all that follows from them; returns the
 * number of nodes recomputed. Before, after, before: bit by bit where it was, since everything is a function of the
 * state. */
int ctTrialApply(Trial* trial, bool after, Sequence* sequence, Tree* tree);

/* The view of the trial; `moved` false: its pieces where they are. */
View ctTrialView(const Trial* trial, bool moved, bool surfaces, double reach);

void ctTrialFree(Trial* trial);

#endif /* CT_TRIAL_H_ */
