/* A trial: changes of joints, and the pieces of the sequence that they move as rigid bodies. */
#ifndef CT_TRIAL_H_
#define CT_TRIAL_H_

#include "traverse.h"

typedef struct TrialChange {
  int link;
  int userLink; /* the caller's number of it */
  JointState before;
  JointState after;
  bool isTurnOfBall;     /* a ball joint's, of which neither state is known yet */
  double rotation[3];    /* of a ball joint, in the world */
  const ctChange* given; /* by the caller, during ctPropose */
} TrialChange;

typedef struct Trial {
  bool open;
  int count;
  int capacity;         /* of the arrays below, in changes */
  TrialChange* changes; /* ascending by link */
  int pieceCount;
  int motionCount;
  Piece* pieces;
  Frame* motions; /* i + 1: of change i together with all changes around it; 0: the identity */

  /* Bodies that move as another does, up to rounding, are merged: they have its number in `pieces`, see ctTrialMerge.
   */
  double displacement;  /* nm: most displacement of their particles from where that number takes them */
  double distanceError; /* nm: most change of a distance within a body of `pieces`; 0: none are merged */
  int apartCount;
  Piece* apart; /* if some are merged: the pieces with the numbers of their own */

  bool isFree;       /* tested, and free of clashes */
  bool isSkipTested; /* that test has skipped pairs within merged bodies */
  int* links;        /* of the changes */
  int* bodyOf;       /* scratch: one a change, and one more */
  int* scratch;      /* scratch: one a change */

  /* What callers see of it, made on first use. */
  bool isShown;
  ctTransform* worldMotions; /* motions of absolute positions */
  int* userLinks;            /* of the changes */
} Trial;

/* Makes room for a number of changes; false, and nothing changed, if there is no memory. */
bool ctTrialReserve(Trial* trial, int count);

/* Proposes a trial of the caller's `given` changes, for which there is room: computes joint states, motions and pieces
 * from the state. Returns the caller's link that is changed twice, or CT_NULL. */
int ctTrialPropose(Trial* trial, const Sequence* sequence, Traversal* traversal, const ctChange* given, int count);

/* True if some body may move as another does, up to rounding. A trial of one change always moves something. */
bool ctTrialMayMerge(const Trial* trial);

/* Merges bodies that move as another does, up to rounding: what lies behind a closed window counts as static. `reach`:
 * in the state no particle with a slot is farther from worldOrigin. */
void ctTrialMerge(Trial* trial, double reach, int levelCount);

/* Sets the joints to their states after or before the trial, and updates sequence and tree; returns how many nodes were
 * recomputed. After that, applying the state before restores every bit, since everything is a function of the state. */
int ctTrialApply(Trial* trial, bool after, Sequence* sequence, Tree* tree, Traversal* traversal);

/* The view of the trial; if not `moved`, of its pieces before it. */
View ctTrialView(const Trial* trial, bool moved, bool surfaces, double reach);

/* Fills what callers see of an open trial, once. */
void ctTrialShow(Trial* trial, const Sequence* sequence);

void ctTrialFree(Trial* trial);

#endif /* CT_TRIAL_H_ */
