/* Which joints change which terms, and how the terms that a trial changes are found. */
#ifndef CT_DEPENDENCE_H_
#define CT_DEPENDENCE_H_

#include <stdbool.h>
#include <stddef.h>

#include "termset.h"

/* A term that many joints change, and the span of its particles. */
typedef struct WideTerm {
  int term;
  int firstSlot;
  int lastSlot;
} WideTerm;

/* A term that few joints change is in the list of each. One that many change, such as a restraint across a protein,
 * would need much memory there; it is found by the bodies of its particles instead. */
typedef struct Dependence {
  size_t* begin; /* of the terms of each of the caller's links; one more is their end */
  int* terms;    /* ascending in each list */
  int singleCount;
  WideTerm* singles; /* wide terms of one slot, ascending by it */
  int acrossCount;
  WideTerm* across; /* the other wide terms, ascending by their first slot */
} Dependence;

/* Makes the lists for `setCount` sets, described by `given` and made as `sets`, and counts the changeable terms of each
 * set. False if there is no memory; the lists have to be freed all the same. O(links + terms log terms). */
bool ctDependenceCreate(const ctDefinition* scene, int setCount, const ctTermSet* given, TermSet* sets,
                        Dependence* dependence);

void ctDependenceFree(Dependence* dependence);

#endif /* CT_DEPENDENCE_H_ */
