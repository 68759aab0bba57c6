/* Shortcuts over joints on which turns are multiplied, in double. */
#define REAL double
#define ABSOLUTE 0

#include "shortcuts.h"

const Kinematics CONTESTANT(kinematicsMultiplied) = SHORTCUTS("multiplied", "joint matrices multiplied on, in double",
                                                              NULL);
