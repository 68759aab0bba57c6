/* The least distance between two clouds of points, by branch and bound over their trees. */
#ifndef CT_NEAREST_H_
#define CT_NEAREST_H_

#include "traverse.h"

/* Points in a tree: slots of the scene, whose world coordinates a traversal keeps, or points of their own. */
typedef struct Cloud {
  const Tree* layout;       /* its content is not read */
  const uint16_t* mask;     /* per node: members that hold points of the cloud */
  const int* particle;      /* per slot */
  Traversal* traversal;     /* NULL: points of their own */
  const Block* block;       /* of those: per node, its members */
  const double (*point)[3]; /* of those: per slot */
} Cloud;

/* A search, which may continue from one pair of clouds to the next. Coordinates are from the sequence's worldOrigin. */
typedef struct Nearest {
  Traversal* traversal;
  double coordinateBound; /* no coordinate of points of their own is larger */
  double known;           /* the distance of some pair */
  const Image* image;     /* of the first cloud; NULL: without shift */
  float shift[3];         /* the same */
  float margin;           /* the error of a distance in float is less, see findNearest */
  float reach;            /* pairs farther apart in float are not the nearest */
  double distance;        /* the least found so far */
  int pair[2];
  int64_t volumeTests;
  int64_t particleTests;
} Nearest;

/* Compares a pair of slots with the nearest so far. */
void ctNearestOffer(Nearest* nearest, const Cloud* a, int slotA, const Cloud* b, int slotB);

#endif /* CT_NEAREST_H_ */
