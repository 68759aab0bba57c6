/* Witnesses: pairs of particles that clashed in past trials. Where moves are small, a trial that clashes is likely to
 * make some of them clash again, which costs a fraction of a search.
 *
 * Whether they are asked is decided by counts (never by clocks) of what that costs and what it spares, so that the same
 * calls give the same method; the verdict is the same. */
#ifndef CT_WITNESS_H_
#define CT_WITNESS_H_

#include "costs.h"
#include "traverse.h"

typedef struct Witnesses {
  int pair[MOST_WITNESSES][2]; /* slots */
  int count;
  int next; /* to be replaced */

  /* The choice, made after each round of trials. Costs are in the units of Clearance.cost. */
  int trials;         /* of this round */
  int64_t cost;       /* of asking, in this round */
  int clashes;        /* that asking has found, in this round */
  int64_t searchCost; /* of searches that found a clash, on average of late */
  int patience;       /* rounds without asking after one in which that has not paid */
  int wait;           /* of those left */
} Witnesses;

/* Whether the next trial should ask them. */
bool ctWitnessesAreWanted(Witnesses* witnesses);

/* Adds what asking them has cost. */
void ctWitnessesCharge(Witnesses* witnesses, int64_t cost, bool clash);

/* A search has found a pair that clashes, at this cost: takes the place of the oldest, if all are taken. */
void ctWitnessesAdd(Witnesses* witnesses, const Tree* tree, int slotA, int slotB, int64_t searchCost);

#endif /* CT_WITNESS_H_ */
