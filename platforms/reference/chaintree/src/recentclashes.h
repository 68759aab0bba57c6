/* Recent clashes: pairs of particles that clashed in past trials. If moves are small, a trial that clashes is likely to
 * make one of them clash again, and testing them costs a fraction of a descent.
 *
 * Counts, never clocks, of what these tests cost and save decide whether they are made, so equal calls take equal ways.
 * The verdict is the same. */
#ifndef CT_RECENTCLASHES_H_
#define CT_RECENTCLASHES_H_

#include "costs.h"
#include "traverse.h"

typedef struct RecentClashes {
  int pair[MOST_RECENT_CLASHES][2]; /* slots */
  Image image[MOST_RECENT_CLASHES]; /* of the first */
  int count;
  int next; /* to be replaced */

  /* The choice, made after each round of trials. Costs are in the units of costs.h. */
  int trials;         /* of this round */
  int64_t cost;       /* of these tests, in this round */
  int clashes;        /* that these tests have found, in this round */
  int64_t searchCost; /* mean cost of the last descents that found a clash */
  int patience;       /* rounds without these tests after the next one in which they do not pay */
  int wait;           /* rounds without these tests that remain */
} RecentClashes;

/* True if the next trial should be tested by them. */
bool ctRecentClashesAreWanted(RecentClashes* recentClashes);

/* Adds what testing them has cost. */
void ctRecentClashesCharge(RecentClashes* recentClashes, int64_t cost, bool clash);

/* Drops all pairs: their images are of another box. */
void ctRecentClashesForget(RecentClashes* recentClashes);

/* Adds a pair that a descent has found at this cost, in this image of the first; replaces the oldest one if there are
 * enough. */
void ctRecentClashesAdd(RecentClashes* recentClashes, const Tree* tree, int slotA, int slotB, const Image* image,
                        int64_t searchCost);

#endif /* CT_RECENTCLASHES_H_ */
