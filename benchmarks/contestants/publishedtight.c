/* The ChainTree as published, its boxes shrunk until they touch particles (section 6.1). */
#include "obb.h"

#define Volume Obb
#define volumeOfSphere obbOfSphere
#define volumeOfPair obbByCovariance
#define volumesOverlap obbsOverlap
#define SHRINK_DEPTH 32
#define IMPROVED 0

#include "binarytree.h"

const Contestant CONTESTANT(contestantPublishedTight) = BINARY_TREE("published-tight",
                                                                    "the ChainTree of 2002 with tight boxes");
