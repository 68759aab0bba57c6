/* Forward kinematics in single precision. */
#define REAL float

#include "sequential.h"

const Kinematics CONTESTANT(kinematicsSequentialSingle) = SEQUENTIAL("sequential-single",
                                                                     "link after link by absolute angles, in single");
