#ifdef __x86_64__
#define CT_PATH_AVX512
#include "clearance_body.h"
#include "nearest_body.h"
#include "refresh_body.h"
#include "sweep_body.h"
#include "traverse_body.h"
#include "witness_body.h"

const InstructionSet ctAvx512 = {"avx512",         refreshLeaf,   refreshTwig,  refreshNode,       putLeafToRest,
                                 traverse,         traverseProbe, askWitnesses, measureClearances, testByClearance,
                                 commitClearances, boundSnapshot, sweepClashes, sweepNeighbors,    neighborDistances,
                                 boundPoints,      findNearest};
#else
typedef int NothingHere; /* a file must declare something */
#endif
