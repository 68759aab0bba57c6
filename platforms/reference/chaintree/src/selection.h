/* Sets of particles for queries. */
#ifndef CT_SELECTION_H_
#define CT_SELECTION_H_

#include "nearest.h"
#include "scene.h"

struct ctSelection {
  const ctChainTree* scene; /* NULL: it has been freed */
  ctSelection* next;        /* in the scene's list */
  ctSelection** listedAt;   /* the pointer to it in that list; NULL: it is in none */
  Arena arena;
  int count;
  uint16_t* mask; /* per node of the tree: members that hold particles of the set */
  int nearest[2]; /* the nearest pair of the last query, first the particle of this set; or CT_NULL */

  /* Its particles that are not modelled, in a tree of their own. */
  int unmodelledCount;
  int* unmodelled; /* ascending */
  Tree unmodelledLayout;
  uint16_t* unmodelledMask;     /* per node: all its members */
  Block* unmodelledBlock;       /* per node; scratch of a query */
  double (*unmodelledPoint)[3]; /* scratch of a query */
};

bool ctSelectionHolds(const ctSelection* selection, int particle);

/* Detaches all selections from a scene that is being freed: a new one may get the same address. */
void ctDisownSelections(ctChainTree* scene);

#endif /* CT_SELECTION_H_ */
