/* Spheres as volumes, around particles too, in some precision. Before binarytrees.c includes this, it defines
 *
 *   TREE         what names end with
 *   VOLUME_REAL  double or float
 *   ROOM         what volumes are larger by for rounding, as a part of the coordinates; 0: not at all */

#define OWN(name) CONTESTANT_JOIN(name, TREE)
#define RoundVolume OWN(RoundVolume)
#define roundOfSphere OWN(roundOfSphere)
#define roundDistance OWN(roundDistance)
#define roomFor OWN(roomFor)
#define roundsOverlap OWN(roundsOverlap)
#define roundOfPair OWN(roundOfPair)

typedef struct RoundVolume {
  VOLUME_REAL centre[3];
  VOLUME_REAL radius;
} RoundVolume;

static RoundVolume roundOfSphere(double radius) {
  return (RoundVolume){{0, 0, 0}, (VOLUME_REAL)radius};
}

/* b's centre, moved, and its distance from a's. */
static VOLUME_REAL roundDistance(const RoundVolume* a, const RoundVolume* b, const Rigid* motion,
                                 VOLUME_REAL centre[3]) {
  VOLUME_REAL squared = 0;
  for (int k = 0; k < 3; k++) {
    centre[k] = (VOLUME_REAL)motion->t[k];
    for (int j = 0; j < 3; j++) {
      centre[k] += (VOLUME_REAL)motion->r[3 * k + j] * b->centre[j];
    }
    squared += (centre[k] - a->centre[k]) * (centre[k] - a->centre[k]);
  }
  return sqrt(squared);
}

/* For what is rounded when b is moved and compared with a. */
static VOLUME_REAL roomFor(const RoundVolume* a, const RoundVolume* b, const VOLUME_REAL centre[3]) {
  const VOLUME_REAL x = fabs(centre[0]) + fabs(centre[1]) + fabs(centre[2]);
  return (VOLUME_REAL)ROOM * (x + a->radius + b->radius);
}

static bool roundsOverlap(const RoundVolume* a, const RoundVolume* b, const Rigid* motion) {
  VOLUME_REAL centre[3];
  const VOLUME_REAL distance = roundDistance(a, b, motion, centre);
  return distance < a->radius + b->radius + roomFor(a, b, centre);
}

static RoundVolume roundOfPair(const RoundVolume* a, const RoundVolume* b, const Rigid* motion) {
  RoundVolume moved = {.radius = b->radius};
  const VOLUME_REAL distance = roundDistance(a, b, motion, moved.centre);
  const VOLUME_REAL room = roomFor(a, b, moved.centre);
  RoundVolume volume = {.radius = (distance + a->radius + b->radius) / 2};
  if (distance + b->radius <= a->radius) {
    volume = *a;
  } else if (distance + a->radius <= b->radius) {
    volume = moved;
  } else {
    const VOLUME_REAL share = (volume.radius - a->radius) / distance;
    for (int k = 0; k < 3; k++) {
      volume.centre[k] = a->centre[k] + share * (moved.centre[k] - a->centre[k]);
    }
  }
  volume.radius += room;
  return volume;
}

#define Volume RoundVolume
#define VOLUME(what) round##what

#undef VOLUME_REAL
#undef ROOM
