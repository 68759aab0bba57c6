/* Sets of particles, prepared for queries. */
#ifndef CT_SELECTION_H_
#define CT_SELECTION_H_

#include "nearest.h"
#include "scene.h"

struct ctSelection {
  const ctChainTree* scene; /* NULL once that is gone */
  ctSelection* next;        /* in the scene's list */
  ctSelection** listedAt;   /* what points to it there; NULL: it is in none */
  Arena arena;
  int count;
  uint16_t* mask; /* per item of the tree: members that hold particles of the set */
  int nearest[2]; /* the pair that was the nearest when last asked: a particle of the set first, or CT_NULL */

  /* Its particles without a slot, in a hierarchy of their own. */
  int idleCount;
  int* idle; /* ascending */
  Tree idleLayout;
  uint16_t* idleMask;     /* per item: all its members */
  Block* idleBlock;       /* per item; scratch of a query */
  double (*idlePoint)[3]; /* scratch of a query */
};

bool ctSelectionHolds(const ctSelection* selection, int particle);

/* Tells all selections of a scene that it is gone: another may come to lie at its address. */
void ctDisownSelections(ctChainTree* scene);

#endif /* CT_SELECTION_H_ */
