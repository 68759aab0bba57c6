/* A growing list of pairs of slots. */
#ifndef CT_SLOT_PAIRS_H_
#define CT_SLOT_PAIRS_H_

#include <stdbool.h>

/* A pair about which the canonical distance decides. */
typedef struct SlotPair {
  int slotA;
  int slotB;
  int n[3];     /* box vectors by which slotA is shifted */
  double value; /* the limit of its overlap, or its distance before the trial */
} SlotPair;

typedef struct SlotPairs {
  SlotPair* pairs;
  int count;
  int capacity;
} SlotPairs;

/* False, and nothing changed, if there is no memory. */
bool ctSlotPairsAdd(SlotPairs* list, const SlotPair* pair);

#endif /* CT_SLOT_PAIRS_H_ */
