/* Volumes in single precision that also decide about particles. */
#define VOLUME_REAL float
#define ROOM 0
#define PARTICLE_VOLUMES 2

#include "roundvolume.h"

const Contestant CONTESTANT(contestantAllSingle) = BINARY_TREE("all-single",
                                                               "volumes in single, which decide about particles, too");
