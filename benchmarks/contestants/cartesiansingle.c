/* Cartesian rotation in single precision. */
#define REAL float

#include "cartesian.h"

const Kinematics CONTESTANT(kinematicsCartesianSingle) = CARTESIAN("cartesian-single",
                                                                   "positions turned and kept, in single");
