/* Volumes in double, with room for rounding. */
#define VOLUME_REAL double
#define ROOM 4e-15
#define PARTICLE_VOLUMES 1

#include "roundvolume.h"

const Contestant CONTESTANT(contestantVolumesDoubleMargin) = BINARY_TREE("volumes-double-margin",
                                                                         "volumes in double, with a margin");
