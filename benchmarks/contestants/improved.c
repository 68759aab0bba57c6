/* The ChainTree of 2002 with better boxes: fitted to those two levels below along the best of three sets of axes, and
 * not compared within a rigid piece. */
#include "obb.h"

#define Volume Obb
#define volumeOfSphere obbOfSphere
#define volumeOfPair obbByCandidates
#define volumesOverlap obbsOverlap
#define SHRINK_DEPTH 2
#define IMPROVED 1

#include "binarytree.h"

const Contestant CONTESTANT(contestantImproved) =
    BINARY_TREE("improved", "the ChainTree of 2002 with better boxes, and without tests within a rigid piece");
