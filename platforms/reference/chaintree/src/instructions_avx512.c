#ifdef __x86_64__
#define CT_PATH_AVX512
#include "clearance_body.h"
#include "nearest_body.h"
#include "refresh_body.h"
#include "sweep_body.h"
#include "traverse_body.h"
#include "witness_body.h"

const InstructionSet ctAvx512 = {
    .name = "avx512",
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
#else
typedef int NothingHere; /* a file must declare something */
#endif
