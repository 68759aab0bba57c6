/* Shortcuts from absolute angles, in double. */
#define REAL double
#define ABSOLUTE 1

#include "shortcuts.h"

const Kinematics CONTESTANT(kinematicsShortcuts) = SHORTCUTS("shortcuts", "shortcuts from absolute angles, in double",
                                                             angles);
