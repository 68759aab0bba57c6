/* Merged bodies: bodies that move as one up to rounding, such as the parts of a chain before and behind a closed
 * window. Trials skip pairs within them. Such a pair is within its limit in the state and hardly moves, so a trial does
 * not test it. Many trials may move it far, though. So each accepted trial adds Trial.distanceError to a bound of how
 * far pairs may be beyond their limits. Before that exceeds MOST_ERROR, a check of all pairs of the state replaces the
 * bound by what it finds: usually 0. If it finds too much, or the state was set with clashes, trials are tested in full
 * until a later check finds less. So a verdict is wrong for no pair that is farther than CT_SIGMA from its limit. */
#ifndef CT_MERGED_H_
#define CT_MERGED_H_

#include "trial.h"

/* nm: most that a pair may be beyond its limit in a trial that skips it, and most error of a cached position. The rest
 * of CT_SIGMA covers the roundings of test and check. */
#define MOST_ERROR (0.5 * CT_SIGMA)

/* Most trials that are tested in full between two checks that find too much. */
enum { MOST_CHECK_PATIENCE = 1 << 12 };

typedef struct Merged {
  double accumulatedError; /* nm: no pair of the state is beyond its limit by more; INFINITY: not known */
  int wait;                /* trials to be tested in full before the next check */
  int patience;            /* the same, after the next check that finds too much */
  double total;            /* nm: sum of Trial.displacement over accepted trials */
  double arm;              /* nm: no listed particle is farther from all that are modelled; below 0: not known */
  double lengthening;      /* nm: by which displacements may have lengthened it since */
} Merged;

/* True if some body may move as another does, up to rounding. A trial of one change always moves something. */
bool ctMayMerge(const Trial* trial);

/* Most difference, nm, of a distance that is computed by different products of transforms before and after a trial. */
double ctTrialRounding(const Trial* trial, double reach, int levelCount);

/* Merges bodies that move as another does, up to rounding: what lies behind a closed window counts as static. `reach`:
 * in the state no particle with a slot is farther from worldOrigin. */
void ctMergeBodies(Trial* trial, double reach, int levelCount);

/* Call after a change of the state other than accept, and after a change of limits. */
void ctMergedForget(ctChainTree* scene);

/* True if the test of the open trial may skip pairs inside merged bodies. Side effect: may check all pairs of the
 * state. If the check finds too much or has no memory, up to MOST_CHECK_PATIENCE trials are tested in full before the
 * next. */
bool ctPrepareSkip(ctChainTree* scene, ctCounts* counts);

/* To be called when the open trial is accepted. */
void ctMergedAccept(ctChainTree* scene);

/* No particle with a slot is farther from worldOrigin; the tree must be up to date. */
double ctSceneReach(ctChainTree* scene);

#endif /* CT_MERGED_H_ */
