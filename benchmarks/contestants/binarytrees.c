/* The ChainTree of 2002: as published, with other volumes, with what makes it better, and in several precisions. */
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "bodies.h"
#include "capsule.h"
#include "obb.h"

enum { MOST_LEVELS = 32, SEVERAL_BODIES = -1 };

static void sortJoints(int* joints, int count) {
  for (int i = 1; i < count; i++) {
    const int joint = joints[i];
    int k = i;
    for (; k > 0 && joints[k - 1] > joint; k--) {
      joints[k] = joints[k - 1];
    }
    joints[k] = joint;
  }
}

/* ---- As published ---- */

#define TREE Published
#define NAME "published"
#define IDEA "the ChainTree of 2002, children tested in the order of its section 2.3"
#define Volume Obb
#define VOLUME(what) obb##what
#include "binarytree_body.h"

#define TREE PublishedSelvesFirst
#define NAME "published-selves-first"
#define IDEA "the ChainTree of 2002, both children tested against themselves first"
#define Volume Obb
#define VOLUME(what) obb##what
#define SELVES_FIRST 1
#include "binarytree_body.h"

/* Its boxes shrunk until they touch particles (section 6.1). */
#define TREE PublishedTight
#define NAME "published-tight"
#define IDEA "the ChainTree of 2002 with tight boxes"
#define Volume Obb
#define VOLUME(what) obb##what
#define SHRINK_DEPTH 32
#include "binarytree_body.h"

#define TREE PublishedCapsules
#define NAME "published-capsules"
#define IDEA "the ChainTree of 2002 with line-swept spheres"
#define Volume Capsule
#define VOLUME(what) capsule##what
#include "binarytree_body.h"

#define TREE PublishedSpheres
#define NAME "published-spheres"
#define IDEA "the ChainTree of 2002 with spheres"
#define Volume Ball
#define VOLUME(what) ball##what
#include "binarytree_body.h"

/* ---- Better ---- */

/* Boxes are fitted to those two levels below, along the best of three sets of axes. */
#define TREE Improved
#define NAME "improved"
#define IDEA "the ChainTree of 2002 with better boxes, and without tests within a rigid piece"
#define Volume Obb
#define VOLUME(what) obb##what
#define volumeOfPair obbByCandidates
#define SHRINK_DEPTH 2
#define SELVES_FIRST 1
#define SKIPS_RIGID 1
#include "binarytree_body.h"

/* ---- In several precisions ---- */

#define TREE VolumesDouble
#define NAME "volumes-double"
#define IDEA "volumes in double, without a margin"
#define VOLUME_REAL double
#define ROOM 0
#include "roundvolume_body.h"
#define SELVES_FIRST 1
#define SKIPS_RIGID 1
#define PARTICLE_VOLUMES 1
#include "binarytree_body.h"

#define TREE VolumesDoubleMargin
#define NAME "volumes-double-margin"
#define IDEA "volumes in double, with a margin"
#define VOLUME_REAL double
#define ROOM 4e-15
#include "roundvolume_body.h"
#define SELVES_FIRST 1
#define SKIPS_RIGID 1
#define PARTICLE_VOLUMES 1
#include "binarytree_body.h"

#define TREE VolumesSingle
#define NAME "volumes-single"
#define IDEA "volumes in single, without a margin"
#define VOLUME_REAL float
#define ROOM 0
#include "roundvolume_body.h"
#define SELVES_FIRST 1
#define SKIPS_RIGID 1
#define PARTICLE_VOLUMES 1
#include "binarytree_body.h"

#define TREE VolumesSingleMargin
#define NAME "volumes-single-margin"
#define IDEA "volumes in single, with a margin"
#define VOLUME_REAL float
#define ROOM 4e-6
#include "roundvolume_body.h"
#define SELVES_FIRST 1
#define SKIPS_RIGID 1
#define PARTICLE_VOLUMES 1
#include "binarytree_body.h"

#define TREE AllSingle
#define NAME "all-single"
#define IDEA "volumes in single, which decide about particles, too"
#define VOLUME_REAL float
#define ROOM 0
#include "roundvolume_body.h"
#define SELVES_FIRST 1
#define SKIPS_RIGID 1
#define PARTICLE_VOLUMES 2
#include "binarytree_body.h"
