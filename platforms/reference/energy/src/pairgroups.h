/* Interaction groups: which pairs of particles count, by pairs of leaves; see ctInteractionGroup. */
#ifndef CT_PAIRGROUPS_H_
#define CT_PAIRGROUPS_H_

#include "ctenergy.h"

/* Slots of a leaf that are in the two sets of a group, as bits. */
typedef struct LeafGroup {
  int group;
  unsigned members[2];
} LeafGroup;

typedef struct PairGroups {
  int* begin;          /* per leaf, and one more: the first of its groups */
  LeafGroup* ofLeaves; /* those of a leaf ascending */
} PairGroups;

/* How often pairs of two leaves count. */
typedef enum GroupedPairs { NO_PAIR_COUNTS, PAIRS_COUNT_ONCE, PAIRS_COUNT_OFTEN } GroupedPairs;

/* False, and nothing to free, if there is no memory. */
bool ctPairGroupsCreate(PairGroups* groups, int leafCount, int groupCount, const ctInteractionGroup* given,
                        const int* slotOf);
void ctPairGroupsFree(PairGroups* groups);

/* Finds for each slot of leaf a the slots of leaf b with which it counts, as bits, and how often; `times` is written
 * only if some count often. */
GroupedPairs ctFindGroupedPairs(const PairGroups* groups, int a, int b, uint16_t allowed[CT_LEAF_WIDTH],
                                int times[CT_LEAF_WIDTH][CT_LEAF_WIDTH]);

#endif /* CT_PAIRGROUPS_H_ */
