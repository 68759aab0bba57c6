/* The ChainTree as published, but for spheres as its volumes. */
#include "ball.h"

#define Volume Ball
#define volumeOfSphere ballOfSphere
#define volumeOfPair ballOfPair
#define volumesOverlap ballsOverlap
#define SHRINK_DEPTH 0
#define IMPROVED 0

#include "binarytree.h"

const Contestant CONTESTANT(contestantPublishedSpheres) = BINARY_TREE("published-spheres",
                                                                      "the ChainTree of 2002 with spheres");
