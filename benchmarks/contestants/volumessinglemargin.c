/* Volumes in single precision, with room for rounding. */
#define VOLUME_REAL float
#define ROOM 4e-6
#define PARTICLE_VOLUMES 1

#include "roundvolume.h"

const Contestant CONTESTANT(contestantVolumesSingleMargin) = BINARY_TREE("volumes-single-margin",
                                                                         "volumes in single, with a margin");
