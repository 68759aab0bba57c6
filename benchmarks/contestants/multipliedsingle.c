/* Shortcuts over joints on which turns are multiplied, in single precision. */
#define REAL float
#define ABSOLUTE 0

#include "shortcuts.h"

const Kinematics CONTESTANT(kinematicsMultipliedSingle) = SHORTCUTS("multiplied-single",
                                                                    "joint matrices multiplied on, in single", NULL);
