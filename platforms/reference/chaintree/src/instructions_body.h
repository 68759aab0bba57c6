/* All that is compiled once for each instruction set, and the table of it. A file that includes this defines before
 * INSTRUCTION_SET, the table, and INSTRUCTION_SET_NAME. */
#include "clearance_body.h"
#include "leafpairs_body.h"
#include "nearest_body.h"
#include "refresh_body.h"
#include "sweep_body.h"
#include "traverse_body.h"
#include "witness_body.h"

const InstructionSet INSTRUCTION_SET = {
    .name = INSTRUCTION_SET_NAME,
    .refreshLeaf = refreshLeaf,
    .linkInLeaf = linkInLeaf,
    .openLeaf = openLeaf,
    .refreshTwig = refreshTwig,
    .refreshInnerNode = refreshInnerNode,
    .refreshLeafBound = refreshLeafBound,
    .widenAbove = widenAbove,
    .updateWorldLeaf = updateWorldLeaf,
    .traverse = traverse,
    .traverseFew = traverseFew,
    .probe = traverseProbe,
    .askWitnesses = askWitnesses,
    .measureClearances = measureClearances,
    .testByClearance = testByClearance,
    .commitClearances = commitClearances,
    .boundSnapshot = boundSnapshot,
    .sweepClashes = sweepClashes,
    .sweepNeighbors = sweepNeighbors,
    .neighborDistances = neighborDistances,
    .updateLeaves = updateLeaves,
    .listLeafPairs = listLeafPairs,
    .boundPoints = boundPoints,
    .findNearest = findNearest,
};
