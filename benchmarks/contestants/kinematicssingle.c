/* Ways to know where particles are, in single precision. */
#define REAL float
#define PRECISE(name) name##Single
#define IN_WORDS(words) words "-single"
#define PRECISION "single"

#include "kinematics_body.h"
