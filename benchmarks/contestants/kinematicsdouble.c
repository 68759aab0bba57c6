/* Ways to know where particles are, in double. */
#define REAL double
#define PRECISE(name) name
#define IN_WORDS(words) words
#define PRECISION "double"

#include "kinematics_body.h"
