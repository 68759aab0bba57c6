#include "descent_body.h"
#include "refresh_body.h"

const InstructionSet ctPortable = {"portable", refreshLeaf, refreshNode, traverse, traverseProbe};
