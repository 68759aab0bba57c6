#include "slotpairs.h"

#include "arena.h"
#include "chaintree.h"

bool ctSlotPairsAdd(SlotPairs* list, const SlotPair* pair) {
  if (list->count == CT_MOST_COUNT ||
      !ctReserve((void**)&list->pairs, &list->capacity, list->count + 1, sizeof(SlotPair))) {
    return false;
  }
  list->pairs[list->count++] = *pair;
  return true;
}
