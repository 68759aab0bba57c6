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
  uint16_t* mask; /* per node of the tree: members that hold particles of the set */
  int nearest[2]; /* the pair that was the nearest when last asked: a particle of the set first, or CT_NULL */

  /* Its particles without a slot, in a hierarchy of their own. */
  int unmodelledCount;
  int* unmodelled; /* ascending */
  Tree unmodelledLayout;
  uint16_t* unmodelledMask;     /* per node: all its members */
  Block* unmodelledBlock;       /* per node; scratch of a query */
  double (*unmodelledPoint)[3]; /* scratch of a query */
};

bool ctSelectionHolds(const ctSelection* selection, int particle);

/* Tells all selections of a scene that it is gone: another may come to lie at its address. */
void ctDisownSelections(ctChainTree* scene);

#endif /* CT_SELECTION_H_ */
