/* The ChainTree as published, but for line-swept spheres as its volumes. */
#include "capsule.h"

#define Volume Capsule
#define volumeOfSphere capsuleOfSphere
#define volumeOfPair capsuleOfPair
#define volumesOverlap capsulesOverlap
#define SHRINK_DEPTH 0
#define IMPROVED 0

#include "binarytree.h"

const Contestant CONTESTANT(contestantPublishedCapsules) = BINARY_TREE("published-capsules",
                                                                       "the ChainTree of 2002 with line-swept spheres");
