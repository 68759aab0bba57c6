#include "heldterms.h"

#include <stdlib.h>

/* The number of slots that the terms of a set name. */
static size_t countNamed(const TermSet* set) {
  return (size_t)set->count * (size_t)set->width;
}

bool ctHeldTermsCreate(int slotCount, int setCount, const TermSet* sets, HeldTerms* held) {
  held->slotCount = slotCount;
  held->begin = calloc((size_t)slotCount + 2, sizeof *held->begin);
  held->bodies = calloc((size_t)slotCount + 1, sizeof *held->bodies);
  if (held->begin == NULL || held->bodies == NULL) {
    return false;
  }
  /* One further on, so that filling the lists turns their ends into their begins. */
  size_t* begin = held->begin + 1;
  for (int s = 0; s < setCount; s++) {
    for (size_t i = 0; i < countNamed(&sets[s]); i++) {
      begin[sets[s].slots[i] + 1]++;
    }
  }
  for (int slot = 0; slot < slotCount; slot++) {
    begin[slot + 1] += begin[slot];
  }
  held->terms = malloc((begin[slotCount] + 1) * sizeof *held->terms);
  if (held->terms == NULL) {
    return false;
  }
  for (int s = 0; s < setCount; s++) {
    for (size_t i = 0; i < countNamed(&sets[s]); i++) {
      held->terms[begin[sets[s].slots[i]]++] = sets[s].firstTerm + (int)(i / (size_t)sets[s].width);
    }
  }
  return true;
}

void ctHeldTermsFree(HeldTerms* held) {
  free(held->begin);
  free(held->terms);
  free(held->bodies);
}
