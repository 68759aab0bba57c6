/* loopsteps.h: in which order a loop grows, and how far apart its ends may be on the way. */
#ifndef CT_LOOPSTEPS_H_
#define CT_LOOPSTEPS_H_

#include "ctclosure.h"
#include "loopshape.h"

/* Bins of the distance, of both cosines and of the dihedral of a meeting. */
#define DISTANCE_BINS 32
#define COSINE_BINS 6
#define DIHEDRAL_BINS 8
#define MEETING_BINS (DISTANCE_BINS * COSINE_BINS * COSINE_BINS * DIHEDRAL_BINS)

/* How often the joints between two ends of a free chain bring these into a place relative to each other: the density
 * per volume by the distance of two points, the angles of two axes with the line between them, and the dihedral of
 * axis, line and axis; relative to the largest. */
typedef struct Meetings {
  double width; /* nm, of a bin of the distance */
  float values[MEETING_BINS];
} Meetings;

/* Consecutive joints of the path that turn together, and the pieces that they place: those between the joints and
 * behind them, as seen from the end from which the loop grows. */
typedef struct GrowthStep {
  bool isFromHead;
  int set;   /* or -1: the joint keeps its angle */
  int first; /* of its joints */
  int last;
  int headJoint; /* the first joint that is still to be turned after this step, and the last one */
  int tailJoint;
  Meetings* meetings; /* of these two */
} GrowthStep;

typedef struct LoopSteps {
  int count;
  GrowthStep* steps;
  int closingFirst; /* joints of the path that are solved for, or lie between these */
  int closingLast;
  int pivots[CT_PIVOTS]; /* joints */
} LoopSteps;

/* False if no joints can close the loop, or there is no memory; then *problem says so. */
bool planLoopSteps(const LoopShape* shape, LoopSteps* steps, const char** problem);

void freeLoopSteps(LoopSteps* steps);

/* The bin of an end at x with an axis u as seen from another: at most MEETING_BINS - 1. */
int binOfMeeting(const Meetings* meetings, const double x1[3], const double u1[3], const double x2[3],
                 const double u2[3]);

#endif /* CT_LOOPSTEPS_H_ */
