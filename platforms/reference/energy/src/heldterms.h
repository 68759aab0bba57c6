/* The terms that hold each particle, which a displacement of the particle changes. */
#ifndef CT_HELDTERMS_H_
#define CT_HELDTERMS_H_

#include <stdbool.h>
#include <stddef.h>

#include "termset.h"

typedef struct HeldTerms {
  int slotCount;
  size_t* begin; /* of the terms of each slot, and one more; NULL: a scene whose particles cannot be displaced */
  int* terms;    /* ascending in each list; a term that names a particle twice is there twice */
  int* bodies;   /* of each slot that the trial displaces, while its terms are computed; 0 of all others */
} HeldTerms;

/* Makes the lists of all sets. False if there is no memory; the lists have to be freed all the same. O(slots +
 * particles of all terms). */
bool ctHeldTermsCreate(int slotCount, int setCount, const TermSet* sets, HeldTerms* held);

void ctHeldTermsFree(HeldTerms* held);

#endif /* CT_HELDTERMS_H_ */
