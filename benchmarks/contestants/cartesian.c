/* Cartesian rotation in double. */
#define REAL double

#include "cartesian.h"

const Kinematics CONTESTANT(kinematicsCartesian) = CARTESIAN("cartesian", "positions turned and kept, in double");
