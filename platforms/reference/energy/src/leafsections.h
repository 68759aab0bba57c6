/* Parts of leaves that move together. */
#ifndef CT_LEAFSECTIONS_H_
#define CT_LEAFSECTIONS_H_

#include "ctenergy.h"

enum { MOST_SECTIONS = 4 };

/* Consecutive slots of a leaf each, of one link or, where there would be too many sections, of some: bits of those that
 * hold a particle. Sections that are not needed are empty, and the last. */
typedef struct LeafSections {
  uint16_t members[MOST_SECTIONS];
} LeafSections;

/* Finds the sections of all leaves, given the particle in each slot, or CT_NULL. */
void ctFindLeafSections(const ctDefinition* scene, const int* particleIn, int leafCount, LeafSections* sections);

#endif /* CT_LEAFSECTIONS_H_ */
