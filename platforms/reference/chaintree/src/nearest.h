/* The least distance between two clouds of points, by branch and bound over their hierarchies. */
#ifndef CT_NEAREST_H_
#define CT_NEAREST_H_

#include "traverse.h"

/* Points in a hierarchy: slots of the scene, which a traversal puts into the world, or points of their own. */
typedef struct Cloud {
  const Tree* layout;       /* nothing else of it is read */
  const uint16_t* mask;     /* per node: members that hold points of the cloud */
  const int* particle;      /* per slot */
  Traversal* traversal;     /* NULL: points of their own */
  const Block* block;       /* of those: per node, its members */
  const double (*point)[3]; /* of those: per slot */
} Cloud;

/* A search, which may go on from clouds to clouds. Coordinates are from the sequence's worldOrigin. */
typedef struct Nearest {
  Traversal* traversal;
  double extent;   /* no coordinate of points of their own is larger */
  double known;    /* some pair is this near */
  float margin;    /* what rounding may do to a distance in float */
  float reach;     /* nothing farther apart matters, in float */
  double distance; /* the least found so far */
  int pair[2];
  int64_t volumeTests;
  int64_t particleTests;
} Nearest;

/* Takes notice of a pair of slots. */
void ctNearestOffer(Nearest* nearest, const Cloud* a, int slotA, const Cloud* b, int slotB);

#endif /* CT_NEAREST_H_ */
