/* What trials skip: pairs within bodies that move as one up to rounding, such as what lies before a closed window and
 * behind it.
 *
 * Such a pair is within its limit in the state and hardly moves, so a trial does not test it. But many trials may move
 * it far. So each accepted trial adds a bound of what it has skipped, `Trial.slack`, to a bound of how far pairs may be
 * beyond their limits. Before that exceeds MOST_EXCESS, a look at all pairs of the state replaces the sum by what it
 * finds: usually 0. If it finds too much, or somebody has made a state that clashes, trials are tested in full, and
 * after some of them there is another look. So a verdict is wrong for no pair that is farther than CT_SIGMA from its
 * limit. */
#ifndef CT_SKIPPED_H_
#define CT_SKIPPED_H_

#include "chaintree.h"

/* nm: no pair may be beyond its limit by more in a trial that skips it, and no cached position may be off by more. The
 * rest of CT_SIGMA is left to the roundings of either look. */
#define MOST_EXCESS (0.5 * CT_SIGMA)

/* Most trials that are tested in full between two looks that find too much. */
enum { MOST_LOOK_PATIENCE = 1 << 12 };

typedef struct Skipped {
  double excess; /* nm: no pair of the state is beyond its limit by more; INFINITY: not known */
  int wait;      /* so many trials are tested in full before the next look */
  int patience;  /* how many after the next look that finds too much */
  double total;  /* nm: the shifts of all accepted trials */
  double arm;    /* nm: no listed particle is farther from all that are modelled; below 0: not known */
} Skipped;

/* To be called when the state has become another one than by an accepted trial, and when limits are others. */
void ctSkippedForget(ctChainTree* scene);

/* True if the test of the open trial, of which some bodies have another's number, may skip pairs. If that is not known,
 * looks at all pairs of the state, or says no until it is time for the next look: after up to MOST_LOOK_PATIENCE more
 * trials. Without memory for a look, says no. */
bool ctMaySkip(ctChainTree* scene, ctCounts* counts);

/* To be called when the open trial is accepted. */
void ctSkippedAccept(ctChainTree* scene);

/* No particle with a slot is farther from worldOrigin; the tree must not be stale. */
double ctSceneReach(ctChainTree* scene);

#endif /* CT_SKIPPED_H_ */
