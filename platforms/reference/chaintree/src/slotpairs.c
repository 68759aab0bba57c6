#include "slotpairs.h"

#include "arena.h"
#include "chaintree.h"

bool ctSlotPairsAdd(SlotPairs* list, int slotA, int slotB, double value) {
  if (list->count == CT_MOST_COUNT ||
      !ctReserve((void**)&list->pairs, &list->capacity, list->count + 1, sizeof(SlotPair))) {
    return false;
  }
  list->pairs[list->count++] = (SlotPair){slotA, slotB, value};
  return true;
}
