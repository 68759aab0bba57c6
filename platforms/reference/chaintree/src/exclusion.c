#include "exclusion.h"

#include <stdlib.h>
#include <string.h>

/* ---- Exclusions ---- */

/* Lists the excluded pairs of modelled particles, as slots, each in both orders; returns how many. */
static int listPairs(const Sequence* s, const ctDefinition* d, int (*pairs)[2]) {
  int count = 0;
  for (int i = 0; i < d->exclusionCount; i++) {
    const int a = modelledSlot(s, d->exclusions[i][0]);
    const int b = modelledSlot(s, d->exclusions[i][1]);
    if (a != CT_NULL && b != CT_NULL) {
      pairs[count][0] = pairs[count + 1][1] = a;
      pairs[count][1] = pairs[count + 1][0] = b;
      count += 2;
    }
  }
  return count;
}

/* Lists the partners of each leaf, each once, starting at begin[leaf]. */
static void listPartners(int pairCount, const int (*pairs)[2], int leafCount, int* begin, int* partners) {
  /* Counts are kept two entries on, so that filling the list turns them into its begins. */
  int* next = begin + 1;
  for (int i = 0; i < pairCount; i++) {
    next[coveringNode(pairs[i][0]) + 1]++;
  }
  ctAccumulate(next, leafCount);
  for (int i = 0; i < pairCount; i++) {
    partners[next[coveringNode(pairs[i][0])]++] = coveringNode(pairs[i][1]);
  }
  /* Sort each leaf's partners and close the gaps that repeats leave. */
  int kept = 0;
  int from = 0;
  for (int leaf = 0; leaf < leafCount; leaf++) {
    const int end = begin[leaf + 1];
    ctSortInts(partners + from, end - from);
    const int first = kept;
    for (int i = from; i < end; i++) {
      if (kept == first || partners[kept - 1] != partners[i]) {
        partners[kept++] = partners[i];
      }
    }
    from = end;
    begin[leaf + 1] = kept;
  }
}

static void setMasks(Exclusions* exclusions, int pairCount, const int (*pairs)[2]) {
  for (int i = 0; i < pairCount; i++) {
    const int a = pairs[i][0];
    const int b = pairs[i][1];
    uint16_t* mask = &exclusions->mask[exclusionPartner(exclusions, coveringNode(a), coveringNode(b))][memberIndex(a)];
    *mask = (uint16_t)(*mask | 1u << memberIndex(b));
  }
}

bool ctExclusionsBuild(Exclusions* exclusions, Arena* arena, const Sequence* s, const ctDefinition* d) {
  const int leafCount = (s->slotCount + TREE_WIDTH - 1) / TREE_WIDTH;
  Arena scratch = {0};
  int(*pairs)[2] = ctArenaAllocate(&scratch, 2 * (size_t)d->exclusionCount, sizeof *pairs);
  int* partners = ctArenaAllocate(&scratch, 2 * (size_t)d->exclusionCount, sizeof *partners);
  exclusions->begin = ctArenaAllocate(arena, (size_t)leafCount + 2, sizeof(int));
  if (!scratch.failed && !arena->failed) {
    const int pairCount = listPairs(s, d, pairs);
    listPartners(pairCount, (const int(*)[2])pairs, leafCount, exclusions->begin, partners);
    const size_t partnerCount = (size_t)exclusions->begin[leafCount];
    exclusions->partner = ctArenaAllocate(arena, partnerCount + TREE_WIDTH, sizeof(int));
    exclusions->mask = ctArenaAllocate(arena, partnerCount + 1, sizeof(uint16_t[TREE_WIDTH]));
    exclusions->own = ctArenaAllocate(arena, (size_t)leafCount, sizeof(int));
    exclusions->emptyMask = (int)partnerCount;
    if (!arena->failed) {
      memcpy(exclusions->partner, partners, partnerCount * sizeof(int));
      setMasks(exclusions, pairCount, (const int(*)[2])pairs);
      for (int leaf = 0; leaf < leafCount; leaf++) {
        const int own = exclusionPartner(exclusions, leaf, leaf);
        exclusions->own[leaf] = own == CT_NULL ? exclusions->emptyMask : own;
      }
    }
  }
  const bool built = !scratch.failed && !arena->failed;
  ctArenaFree(&scratch);
  return built;
}

/* ---- Limits ---- */

double ctLimitsFind(const Limits* limits, int particle1, int particle2, double otherwise) {
  const uint64_t key = pairKey(particle1, particle2);
  /* Without a branch on the result, which processors would mispredict. */
  int low = 0;
  for (int left = limits->count; left > 0;) {
    const int half = (left + 1) / 2;
    low += limits->keys[low + half - 1] < key ? half : 0;
    left -= half;
  }
  return low < limits->count && limits->keys[low] == key ? limits->values[low] : otherwise;
}

bool ctLimitsAppend(Limits* limits, int particle1, int particle2, double limit) {
  if (limits->count == CT_MOST_COUNT ||
      !ctReserve((void**)&limits->keys, &limits->keyCapacity, limits->count + 1, sizeof(uint64_t)) ||
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
