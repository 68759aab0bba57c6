/* Pairs that don't count, and limits of single pairs. */
#ifndef CT_EXCLUSION_H_
#define CT_EXCLUSION_H_

#include "sequence.h"

/* Per slot the slots it never clashes with, ascending; both ways round. */
typedef struct Exclusions {
  int* begin; /* slotCount + 1 */
  int* partner;
} Exclusions;

/* Pairs of particles whose limit is not their tolerance, by ascending key. */
typedef struct Limits {
  uint64_t* keys;
  double* values;
  int count;
  int keyCapacity;
  int valueCapacity;
} Limits;

bool ctExclusionsBuild(Exclusions* exclusions, Arena* arena, const Sequence* sequence, const ctDefinition* definition);

static inline bool isExcluded(const Exclusions* exclusions, int slotA, int slotB) {
  for (int i = exclusions->begin[slotA]; i < exclusions->begin[slotA + 1]; i++) {
    if (exclusions->partner[i] == slotB) {
      return true;
    }
  }
  return false;
}

/* Sorts like (lower particle, higher particle). */
static inline uint64_t pairKey(int particle1, int particle2) {
  const uint32_t low = (uint32_t)(particle1 < particle2 ? particle1 : particle2);
  const uint32_t high = (uint32_t)(particle1 < particle2 ? particle2 : particle1);
  return (uint64_t)low << 32 | high;
}

/* The limit of a pair, or `otherwise` if it has none of its own. O(log of their number). */
double ctLimitsFind(const Limits* limits, int particle1, int particle2, double otherwise);

/* Adds a limit without keeping the order; false, and nothing changed, if there is no memory. */
bool ctLimitsAppend(Limits* limits, int particle1, int particle2, double limit);

/* Restores the order after appending; of several limits of one pair the largest stays. False, and nothing changed, if
 * there is no memory. */
bool ctLimitsSort(Limits* limits);

void ctLimitsFree(Limits* limits);

#endif /* CT_EXCLUSION_H_ */
