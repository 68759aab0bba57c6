/* Witnesses: pairs of particles that clashed in past trials. If moves are small, a trial that clashes is likely to make
 * one of them clash again. Testing them costs a fraction of a search.
 *
 * Counts (never clocks) of what asking costs and spares decide whether they are asked: the same calls take the same
 * way. The verdict is the same. */
#ifndef CT_WITNESS_H_
#define CT_WITNESS_H_

#include "costs.h"
#include "traverse.h"

typedef struct Witnesses {
  int pair[MOST_WITNESSES][2]; /* slots */
  int count;
  int next; /* to be replaced */

  /* The choice, made after each round of trials. Costs are in the units of costs.h. */
  int trials;         /* of this round */
  int64_t cost;       /* of asking, in this round */
  int clashes;        /* that asking has found, in this round */
  int64_t searchCost; /* mean of the last searches that found a clash */
  int patience;       /* rounds without asking after the next one in which asking does not pay */
  int wait;           /* rounds without asking that are left */
} Witnesses;

/* True if the next trial should ask them. */
bool ctWitnessesAreWanted(Witnesses* witnesses);

/* Adds what asking them has cost. */
void ctWitnessesCharge(Witnesses* witnesses, int64_t cost, bool clash);

/* Adds a pair that a search has found at this cost; replaces the oldest one if there are enough. */
void ctWitnessesAdd(Witnesses* witnesses, const Tree* tree, int slotA, int slotB, int64_t searchCost);

#endif /* CT_WITNESS_H_ */
