#include "exclusion.h"

#include <stdlib.h>

#include "order.h"

/* ---- Exclusions ---- */

bool ctExclusionsBuild(Exclusions* exclusions, Arena* arena, const Sequence* s, const ctDefinition* d) {
  const size_t slots = (size_t)s->slotCount;
  exclusions->begin = ctArenaAllocate(arena, slots + 2, sizeof(int));
  if (arena->failed) {
    return false;
  }
  /* Counts two places on, so that filling moves each begin to its place. */
  int* next = exclusions->begin + 1;
  for (int i = 0; i < d->exclusionCount; i++) {
    const int a = s->particleSlot[d->exclusions[i][0]];
    const int b = s->particleSlot[d->exclusions[i][1]];
    if (a != CT_NULL && b != CT_NULL) {
      next[a + 1]++;
      next[b + 1]++;
    }
  }
  ctAccumulate(next, s->slotCount);
  exclusions->partner = ctArenaAllocate(arena, (size_t)next[s->slotCount], sizeof(int));
  if (arena->failed) {
    return false;
  }
  for (int i = 0; i < d->exclusionCount; i++) {
    const int a = s->particleSlot[d->exclusions[i][0]];
    const int b = s->particleSlot[d->exclusions[i][1]];
    if (a != CT_NULL && b != CT_NULL) {
      exclusions->partner[next[a]++] = b;
      exclusions->partner[next[b]++] = a;
    }
  }
  /* Sort each slot's partners and close the gaps that repeats leave. */
  int kept = 0;
  int from = 0;
  for (int slot = 0; slot < s->slotCount; slot++) {
    const int end = exclusions->begin[slot + 1];
    ctSortInts(exclusions->partner + from, end - from);
    const int first = kept;
    for (int i = from; i < end; i++) {
      if (kept == first || exclusions->partner[kept - 1] != exclusions->partner[i]) {
        exclusions->partner[kept++] = exclusions->partner[i];
      }
    }
    from = end;
    exclusions->begin[slot + 1] = kept;
  }
  return true;
}

/* ---- Limits ---- */

double ctLimitsFind(const Limits* limits, int particle1, int particle2, double otherwise) {
  const uint64_t key = pairKey(particle1, particle2);
  int low = 0;
  int high = limits->count;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (limits->keys[middle] < key) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low < limits->count && limits->keys[low] == key ? limits->values[low] : otherwise;
}

bool ctLimitsAppend(Limits* limits, int particle1, int particle2, double limit) {
  if (!ctReserve((void**)&limits->keys, &limits->keyCapacity, limits->count + 1, sizeof(uint64_t)) ||
      !ctReserve((void**)&limits->values, &limits->valueCapacity, limits->count + 1, sizeof(double))) {
    return false;
  }
  limits->keys[limits->count] = pairKey(particle1, particle2);
  limits->values[limits->count++] = limit;
  return true;
}

typedef struct Limit {
  uint64_t key;
  double value;
} Limit;

static int compareLimits(const void* a, const void* b) {
  const Limit* x = a;
  const Limit* y = b;
  if (x->key != y->key) {
    return x->key < y->key ? -1 : 1;
  }
  return (x->value < y->value) - (x->value > y->value);
}

bool ctLimitsSort(Limits* limits) {
  if (limits->count == 0) {
    return true;
  }
  Limit* sorted = malloc((size_t)limits->count * sizeof(Limit));
  if (sorted == NULL) {
    return false;
  }
  for (int i = 0; i < limits->count; i++) {
    sorted[i] = (Limit){limits->keys[i], limits->values[i]};
  }
  qsort(sorted, (size_t)limits->count, sizeof(Limit), compareLimits);
  int kept = 0;
  for (int i = 0; i < limits->count; i++) {
    if (kept == 0 || limits->keys[kept - 1] != sorted[i].key) {
      limits->keys[kept] = sorted[i].key;
      limits->values[kept++] = sorted[i].value;
    }
  }
  limits->count = kept;
  free(sorted);
  return true;
}

void ctLimitsFree(Limits* limits) {
  free(limits->keys);
  free(limits->values);
  *limits = (Limits){0};
}
