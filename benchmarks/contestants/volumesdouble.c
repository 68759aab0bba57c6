/* Volumes in double, without room for rounding. */
#define VOLUME_REAL double
#define ROOM 0
#define PARTICLE_VOLUMES 1

#include "roundvolume.h"

const Contestant CONTESTANT(contestantVolumesDouble) = BINARY_TREE("volumes-double",
                                                                   "volumes in double, without a margin");
