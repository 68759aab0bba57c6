/* Leaves on the grid before and in the open trial, and how their sections move in it. */
#ifndef CT_TRIALGRIDS_H_
#define CT_TRIALGRIDS_H_

#include "tapekernels.h"
#include "trialleaves.h"

/* Of a leaf or section whose particles are of many bodies. */
enum { MANY_BODIES = -1 };

/* How a leaf moves in a trial: the bodies of its particles. */
typedef struct LeafMotion {
  int body;
  int sections[MOST_SECTIONS]; /* only if there are many */
} LeafMotion;

typedef struct TrialGrids {
  TrialLeaves* leaves; /* shared with others */
  const TapeKernels* kernels;
  LeafSections* sections; /* per leaf, as all that follow */
  LeafGrid* state;
  bool* isStale;
  LeafGrid* trial;
  const LeafGrid** inTrial; /* one of the two */
  int64_t* gridStamp;       /* the trial in which that was found */
  int64_t* motionStamp;
  LeafMotion* motions;
  int movedBegin; /* slots beyond these are at rest in the trial */
  int movedEnd;
} TrialGrids;

/* False if there is no memory. */
bool ctTrialGridsCreate(TrialGrids* grids, TrialLeaves* leaves, const ctDefinition* scene);
void ctTrialGridsFree(TrialGrids* grids);

/* To be called once the leaves have opened a trial. */
void ctTrialGridsOpen(TrialGrids* grids);

/* Takes notice that the state has become another one, or that the trial has become the state. */
void ctTrialGridsForget(TrialGrids* grids);
void ctTrialGridsAccept(TrialGrids* grids);

/* Where the particles of a leaf are in the state and in the trial, and how it moves. They hold until the trial ends. */
const LeafGrid* ctStateGrid(TrialGrids* grids, int leaf);
const LeafGrid* ctMovedGrid(TrialGrids* grids, int leaf);
const LeafMotion* ctMotionOfMoved(TrialGrids* grids, int leaf);

/* True if a leaf is at rest since no slot nearby moves. */
static inline bool isFarFromMoved(const TrialGrids* grids, int leaf) {
  const int begin = leaf * CT_LEAF_WIDTH;
  return begin >= grids->movedEnd || begin + CT_LEAF_WIDTH <= grids->movedBegin;
}

static inline const LeafGrid* trialGrid(TrialGrids* grids, int leaf) {
  if (isFarFromMoved(grids, leaf)) {
    return grids->isStale[leaf] ? ctStateGrid(grids, leaf) : &grids->state[leaf];
  }
  return ctMovedGrid(grids, leaf);
}

static inline const LeafMotion* trialMotion(TrialGrids* grids, int leaf) {
  static const LeafMotion atRest = {0};
  return isFarFromMoved(grids, leaf) ? &atRest : ctMotionOfMoved(grids, leaf);
}

#endif /* CT_TRIALGRIDS_H_ */
