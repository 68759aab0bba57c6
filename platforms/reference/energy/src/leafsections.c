#include "leafsections.h"

/* Makes one of two consecutive sections, those that are the smallest together. */
static void joinSmallest(int* count, uint16_t* members) {
  int first = 0;
  int least = 2 * CT_LEAF_WIDTH;
  for (int s = 0; s + 1 < *count; s++) {
    const int together = __builtin_popcount(members[s]) + __builtin_popcount(members[s + 1]);
    if (together < least) {
      least = together;
      first = s;
    }
  }
  members[first] |= members[first + 1];
  for (int s = first + 1; s + 1 < *count; s++) {
    members[s] = members[s + 1];
  }
  members[--*count] = 0;
}

static void findSections(const int links[CT_LEAF_WIDTH], LeafSections* sections) {
  uint16_t members[CT_LEAF_WIDTH] = {0};
  int count = 0;
  int last = CT_NULL;
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    if (links[k] != CT_NULL) {
      count += count == 0 || links[k] != last ? 1 : 0;
      last = links[k];
      members[count - 1] = (uint16_t)(members[count - 1] | 1u << k);
    }
  }
  while (count > MOST_SECTIONS) {
    joinSmallest(&count, members);
  }
  for (int s = 0; s < MOST_SECTIONS; s++) {
    sections->members[s] = members[s];
  }
}

void ctFindLeafSections(const ctDefinition* scene, const int* particleIn, int leafCount, LeafSections* sections) {
  for (int leaf = 0; leaf < leafCount; leaf++) {
    int links[CT_LEAF_WIDTH];
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      const int particle = particleIn[leaf * CT_LEAF_WIDTH + k];
      links[k] = particle != CT_NULL ? scene->particleLinks[particle] : CT_NULL;
    }
    findSections(links, &sections[leaf]);
  }
}
