/* Excluded pairs, and limits of single pairs. */
#ifndef CT_EXCLUSION_H_
#define CT_EXCLUSION_H_

#include "order.h"
#include "sequence.h"

/* The excluded pairs of slots. The partners of a leaf, ascending, are the leaves with which it has excluded pairs. Each
 * pair is kept in both orders. */
typedef struct Exclusions {
  int* begin;                   /* per leaf, and one more: the first of its partners */
  int* partner;                 /* leaves; sixteen more may be read */
  uint16_t (*mask)[TREE_WIDTH]; /* per partner and slot of the leaf, bits: the slots of the partner; one more, empty */
  int emptyMask;                /* index of that */
  int* own;                     /* per leaf: the index of its masks with itself, or emptyMask */
} Exclusions;

/* Pairs of particles whose limit is not their tolerance, ascending by key. */
typedef struct Limits {
  uint64_t* keys;
  double* values;
  int count;
  int keyCapacity;
  int valueCapacity;
} Limits;

bool ctExclusionsBuild(Exclusions* exclusions, Arena* arena, const Sequence* sequence, const ctDefinition* definition);

/* The index of the first partner of leafA that is not before leafB. O(log of their number). */
static inline int exclusionsFrom(const Exclusions* exclusions, int leafA, int leafB) {
  return ascendingFrom(exclusions->partner, exclusions->begin[leafA], exclusions->begin[leafA + 1], leafB);
}

/* The index of leafB among the partners of leafA, or CT_NULL. */
static inline int exclusionPartner(const Exclusions* exclusions, int leafA, int leafB) {
  const int i = exclusionsFrom(exclusions, leafA, leafB);
  return i < exclusions->begin[leafA + 1] && exclusions->partner[i] == leafB ? i : CT_NULL;
}

/* Advances an index among the partners of leafA to leafB, or to the first one behind it; true if leafB is one of them.
 */
static inline bool exclusionReaches(const Exclusions* exclusions, int leafA, int leafB, int* partner) {
  const int end = exclusions->begin[leafA + 1];
  while (*partner < end && exclusions->partner[*partner] < leafB) {
    (*partner)++;
  }
  return *partner < end && exclusions->partner[*partner] == leafB;
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
