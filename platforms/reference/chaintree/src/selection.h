/* Sets of particles, prepared for queries. */
#ifndef CT_SELECTION_H_
#define CT_SELECTION_H_

#include "nearest.h"
#include "scene.h"

struct ctSelection {
  const ctChainTree* scene;
  Arena arena;
  int count;
  uint16_t* mask; /* per item of the tree: members that hold particles of the set */

  /* Its particles without a slot, in a hierarchy of their own. */
  int idleCount;
  int* idle; /* ascending */
  Tree idleLayout;
  uint16_t* idleMask;     /* per item: all its members */
  Block* idleBlock;       /* per item; scratch of a query */
  double (*idlePoint)[3]; /* scratch of a query */
};

#endif /* CT_SELECTION_H_ */
