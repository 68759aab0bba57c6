#include "clearance_body.h"
#include "nearest_body.h"
#include "refresh_body.h"
#include "sweep_body.h"
#include "traverse_body.h"
#include "witness_body.h"

const InstructionSet ctPortable = {
    .name = "portable",
    .refreshLeaf = refreshLeaf,
    .refreshTwig = refreshTwig,
    .refreshInnerNode = refreshInnerNode,
    .updateWorldLeaf = updateWorldLeaf,
    .traverse = traverse,
    .probe = traverseProbe,
    .askWitnesses = askWitnesses,
    .measureClearances = measureClearances,
    .testByClearance = testByClearance,
    .commitClearances = commitClearances,
    .boundSnapshot = boundSnapshot,
    .sweepClashes = sweepClashes,
    .sweepNeighbors = sweepNeighbors,
    .neighborDistances = neighborDistances,
    .boundPoints = boundPoints,
    .findNearest = findNearest,
};
