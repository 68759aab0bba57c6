/* Volumes in single precision, without room for rounding. */
#define VOLUME_REAL float
#define ROOM 0
#define PARTICLE_VOLUMES 1

#include "roundvolume.h"

const Contestant CONTESTANT(contestantVolumesSingle) = BINARY_TREE("volumes-single",
                                                                   "volumes in single, without a margin");
