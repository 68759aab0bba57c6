#include "clearance_body.h"
#include "nearest_body.h"
#include "refresh_body.h"
#include "sweep_body.h"
#include "traverse_body.h"
#include "witness_body.h"

const InstructionSet ctPortable = {"portable",       refreshLeaf,   refreshTwig,  refreshNode,       putLeafToRest,
                                   traverse,         traverseProbe, askWitnesses, measureClearances, testByClearance,
                                   commitClearances, boundSnapshot, sweepClashes, sweepNeighbors,    neighborDistances,
                                   boundPoints,      findNearest};
