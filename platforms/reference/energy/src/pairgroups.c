#include "pairgroups.h"

#include <stdlib.h>
#include <string.h>

/* A particle of a set of a group. */
typedef struct Member {
  int slot;
  int group;
  int set;
} Member;

/* By leaves, then groups. */
static int compare(const void* a, const void* b) {
  const Member* p = a;
  const Member* q = b;
  const int leafP = p->slot / CT_LEAF_WIDTH;
  const int leafQ = q->slot / CT_LEAF_WIDTH;
  if (leafP != leafQ) {
    return leafP < leafQ ? -1 : 1;
  }
  return (p->group > q->group) - (p->group < q->group);
}

static size_t listMembers(int groupCount, const ctInteractionGroup* given, const int* slotOf, Member* members) {
  size_t count = 0;
  for (int g = 0; g < groupCount; g++) {
    for (int set = 0; set < 2; set++) {
      for (int i = 0; i < given[g].counts[set]; i++) {
        members[count++] = (Member){slotOf[given[g].particles[set][i]], g, set};
      }
    }
  }
  qsort(members, count, sizeof *members, compare);
  return count;
}

bool ctPairGroupsCreate(PairGroups* groups, int leafCount, int groupCount, const ctInteractionGroup* given,
                        const int* slotOf) {
  size_t most = 1;
  for (int g = 0; g < groupCount; g++) {
    most += (size_t)given[g].counts[0] + (size_t)given[g].counts[1];
  }
  Member* members = malloc(most * sizeof *members);
  groups->begin = calloc((size_t)leafCount + 1, sizeof *groups->begin);
  groups->ofLeaves = calloc(most, sizeof *groups->ofLeaves);
  if (members == NULL || groups->begin == NULL || groups->ofLeaves == NULL) {
    free(members);
    ctPairGroupsFree(groups);
    return false;
  }
  const size_t count = listMembers(groupCount, given, slotOf, members);
  int made = 0;
  for (size_t i = 0; i < count; i++) {
    if (i == 0 || compare(&members[i - 1], &members[i]) != 0) {
      groups->ofLeaves[made++].group = members[i].group;
    }
    groups->ofLeaves[made - 1].members[members[i].set] |= 1u << members[i].slot % CT_LEAF_WIDTH;
    groups->begin[members[i].slot / CT_LEAF_WIDTH + 1] = made;
  }
  /* Leaves without a group end where those before them do. */
  for (int leaf = 0; leaf < leafCount; leaf++) {
    if (groups->begin[leaf + 1] < groups->begin[leaf]) {
      groups->begin[leaf + 1] = groups->begin[leaf];
    }
  }
  free(members);
  return true;
}

void ctPairGroupsFree(PairGroups* groups) {
  free(groups->begin);
  free(groups->ofLeaves);
  *groups = (PairGroups){0};
}

/* The slots of leaf b that a group pairs with slot k of leaf a. */
static unsigned pairedWith(const LeafGroup* a, const LeafGroup* b, int k) {
  return (a->members[0] >> k & 1 ? b->members[1] : 0) | (a->members[1] >> k & 1 ? b->members[0] : 0);
}

/* The groups that two leaves share, one after the other. */
typedef struct SharedGroups {
  const LeafGroup* a;
  const LeafGroup* endOfA;
  const LeafGroup* b;
  const LeafGroup* endOfB;
} SharedGroups;

static SharedGroups shareOf(const PairGroups* groups, int a, int b) {
  const LeafGroup* all = groups->ofLeaves;
  const int* begin = groups->begin;
  return (SharedGroups){all + begin[a], all + begin[a + 1], all + begin[b], all + begin[b + 1]};
}

/* Advances to the next group of both, the present one included; false if there is none. */
static bool findShared(SharedGroups* shared) {
  while (shared->a < shared->endOfA && shared->b < shared->endOfB) {
    if (shared->a->group == shared->b->group) {
      return true;
    }
    if (shared->a->group < shared->b->group) {
      shared->a++;
    } else {
      shared->b++;
    }
  }
  return false;
}

static void countTimes(SharedGroups shared, int times[CT_LEAF_WIDTH][CT_LEAF_WIDTH]) {
  memset(times, 0, CT_LEAF_WIDTH * sizeof *times);
  for (; findShared(&shared); shared.a++, shared.b++) {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      const unsigned paired = pairedWith(shared.a, shared.b, k);
      for (int l = 0; l < CT_LEAF_WIDTH; l++) {
        times[k][l] += (int)(paired >> l & 1);
      }
    }
  }
}

GroupedPairs ctFindGroupedPairs(const PairGroups* groups, int a, int b, uint16_t allowed[CT_LEAF_WIDTH],
                                int times[CT_LEAF_WIDTH][CT_LEAF_WIDTH]) {
  unsigned some = 0;
  unsigned often = 0;
  memset(allowed, 0, CT_LEAF_WIDTH * sizeof *allowed);
  for (SharedGroups shared = shareOf(groups, a, b); findShared(&shared); shared.a++, shared.b++) {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      const unsigned paired = pairedWith(shared.a, shared.b, k);
      often |= allowed[k] & paired;
      some |= paired;
      allowed[k] = (uint16_t)(allowed[k] | paired);
    }
  }
  if (often != 0) {
    countTimes(shareOf(groups, a, b), times);
  }
  return some == 0 ? NO_PAIR_COUNTS : often == 0 ? PAIRS_COUNT_ONCE : PAIRS_COUNT_OFTEN;
}
