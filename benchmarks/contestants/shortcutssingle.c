/* Shortcuts from absolute angles, in single precision. */
#define REAL float
#define ABSOLUTE 1

#include "shortcuts.h"

const Kinematics CONTESTANT(kinematicsShortcutsSingle) = SHORTCUTS("shortcuts-single",
                                                                   "shortcuts from absolute angles, in single", angles);
