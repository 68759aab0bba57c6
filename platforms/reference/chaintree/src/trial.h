/* A trial: changes of joints, and the pieces of the sequence that they move as rigid bodies. */
#ifndef CT_TRIAL_H_
#define CT_TRIAL_H_

#include "traverse.h"

typedef struct TrialChange {
  int link;
  int userLink; /* the caller's number of it */
  JointState before;
  JointState after;
  bool isPending;        /* neither state is known yet */
  double rotation[3];    /* then: of a ball joint, in the world */
  double angle;          /* then: of a torsion joint of a flexible scene */
  const ctChange* given; /* by the caller, during ctPropose */
} TrialChange;

/* A particle that is displaced within its link. */
typedef struct TrialDisplacement {
  int particle;
  int place;        /* its slot; if it has none, ~ of its link */
  double shift[3];  /* in the world */
  double before[3]; /* its reference position; not known while Trial.arePending */
  double after[3];
} TrialDisplacement;

typedef struct Trial {
  bool open;
  int count;
  int capacity;          /* of the arrays below, in changes */
  TrialChange* changes;  /* ascending by link */
  int displacementCount; /* if there are some, there are no changes */
  int displacementCapacity;
  bool arePending;                  /* no reference position is known yet */
  TrialDisplacement* displacements; /* ascending by place */
  int* displaced;                   /* their particles */
  Frame* inLeaf;                    /* scratch: the frames of their links in their leaves */
  int pieceCount;
  int motionCount;
  Piece* pieces;
  Frame* motions; /* i + 1: of change i together with all changes around it; 0: the identity */

  /* Bodies that move as another does, up to rounding, are merged: they have its number in `pieces`, see merged.h.
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

/* Adds a piece that begins at a slot. */
static inline void addPiece(Trial* trial, int slotBegin, int body) {
  if (trial->pieceCount > 0 && trial->pieces[trial->pieceCount - 1].slotBegin == slotBegin) {
    trial->pieceCount--; /* the last piece has no slots */
  }
  if (trial->pieceCount > 0 && trial->pieces[trial->pieceCount - 1].body == body) {
    return;
  }
  trial->pieces[trial->pieceCount++] = (Piece){slotBegin, body};
}

/* The view of the trial. */
View ctTrialView(const Trial* trial, double reach);

/* Forgets all of a trial but what it changes and its pieces, and opens it. */
static inline void resetTrial(Trial* trial) {
  trial->displacement = 0;
  trial->distanceError = 0;
  trial->isFree = false;
  trial->isShown = false;
  trial->open = true;
}

/* Makes room for what `count` changes or displacements need; false, and nothing lost, if there is no memory. */
bool ctTrialReserve(Trial* trial, int count);

/* Makes the next trial the open one. */
void ctTrialOpen(ctChainTree* scene);

/* Sets the places of displaced particles in their links to those after or before the trial, and updates the tree;
 * returns how many nodes were recomputed. */
int ctDisplacementsApply(ctChainTree* scene, bool after);

/* Fills what callers see of an open trial, once. */
void ctTrialShow(Trial* trial, const Sequence* sequence);

void ctTrialFree(Trial* trial);

#endif /* CT_TRIAL_H_ */
