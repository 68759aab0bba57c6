/* Clashes of the state: pairs that overlap by more than their tolerance. */
#ifndef CT_CLASHES_H_
#define CT_CLASHES_H_

#include "scene.h"

/* A query, and what it does with each clash. */
typedef struct Clashes {
  ctChainTree* tree;
  const Sweep* sweep;
  bool (*found)(struct Clashes* clashes, int slotA, int slotB, double overlap);
  void* context;
  bool isOver; /* `found` has returned false */
} Clashes;

/* Calls `found` for each clash, until it returns false. False if there is no memory. */
bool ctFindClashes(Clashes* clashes, ctCounts* counts);

#endif /* CT_CLASHES_H_ */
