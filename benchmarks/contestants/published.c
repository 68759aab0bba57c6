/* The ChainTree as published. */
#include "obb.h"

#define Volume Obb
#define volumeOfSphere obbOfSphere
#define volumeOfPair obbByCovariance
#define volumesOverlap obbsOverlap
#define SHRINK_DEPTH 0
#define IMPROVED 0

#include "binarytree.h"

const Contestant CONTESTANT(contestantPublished) = BINARY_TREE("published", "the ChainTree of 2002");
