/* Forward kinematics in double. */
#define REAL double

#include "sequential.h"

const Kinematics CONTESTANT(kinematicsSequential) = SEQUENTIAL("sequential",
                                                               "link after link by absolute angles, in double");
