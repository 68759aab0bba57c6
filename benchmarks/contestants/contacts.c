#define REAL long double

#include "contacts.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "rigid.h"

/* Pairs less than ROOM apart at a contact are looked at near it; no particle goes half as far from there. */
enum { TURNS_TRIED = 2000, HALVINGS = 60, CORRECTIONS = 4 };
#define ROOM 0.05L
#define STEP 1e-7L

/* Overlaps grow at least so fast, nm/rad, and are at most that large where a judge in double sees the contact, nm. */
#define LEAST_SLOPE 1e-2L
#define JUDGE_ERROR 1e-9L

void contactFree(Contact* contact) {
  free(contact->pairs);
  *contact = (Contact){0};
}

/* ---- Overlaps ---- */

static Rigid motionOf(const Scene* scene, const Place* places, int torsion, long double angle) {
  const int* axis = scene->torsions[torsion].axis;
  return rigidTurn(places[axis[0]], places[axis[1]], angle);
}

static long double overlapOf(const Scene* scene, const Place* places, const Rigid* motion, ParticlePair pair) {
  Place moved;
  rigidApply(motion, places[pair.moving], moved);
  return (long double)scene->spheres[pair.resting].radius + scene->spheres[pair.moving].radius -
         sqrt(squaredDistance(places[pair.resting], moved));
}

long double contactOverlap(const Scene* scene, const Place* places, const Contact* contact, double angle) {
  const Rigid motion = motionOf(scene, places, contact->torsion, angle);
  long double largest = -INFINITY;
  for (int p = 0; p < contact->pairCount; p++) {
    largest = fmax(largest, overlapOf(scene, places, &motion, contact->pairs[p]));
  }
  return largest;
}

static long double firstOverlap(const Scene* scene, const Place* places, const Contact* contact, long double angle) {
  const Rigid motion = motionOf(scene, places, contact->torsion, angle);
  return overlapOf(scene, places, &motion, contact->pairs[0]);
}

static long double firstSlope(const Scene* scene, const Place* places, const Contact* contact, long double angle) {
  return (firstOverlap(scene, places, contact, angle + STEP) - firstOverlap(scene, places, contact, angle - STEP)) /
         (2 * STEP);
}

/* ---- Pairs about to touch: a sweep along the first axis ---- */

typedef struct Along {
  double x[3];
  int particle;
} Along;

static int compareAlong(const void* a, const void* b) {
  const double x = ((const Along*)a)->x[0];
  const double y = ((const Along*)b)->x[0];
  return (x > y) - (x < y);
}

static bool addPair(Contact* contact, ParticlePair pair) {
  if (contact->pairCount == contact->capacity) {
    const int capacity = 2 * contact->capacity + 16;
    ParticlePair* pairs = realloc(contact->pairs, (size_t)capacity * sizeof *pairs);
    if (pairs == NULL) {
      return false;
    }
    contact->pairs = pairs;
    contact->capacity = capacity;
  }
  contact->pairs[contact->pairCount++] = pair;
  return true;
}

static bool isNear(const Scene* scene, const Along* a, const Along* b) {
  double squared = 0;
  for (int k = 0; k < 3; k++) {
    squared += (a->x[k] - b->x[k]) * (a->x[k] - b->x[k]);
  }
  const double reach = scene->spheres[a->particle].radius + scene->spheres[b->particle].radius + (double)ROOM;
  return squared < reach * reach && !sceneExcludes(scene, a->particle, b->particle);
}

/* Of particles that rest and that move, `restingCount` and the others of all. */
static bool sweep(const Scene* scene, Along* resting, int restingCount, Along* moving, int movingCount,
                  Contact* contact) {
  const double reach = 2 * sceneLargestRadius(scene) + (double)ROOM;
  qsort(resting, (size_t)restingCount, sizeof *resting, compareAlong);
  qsort(moving, (size_t)movingCount, sizeof *moving, compareAlong);
  int begin = 0;
  for (int j = 0; j < movingCount; j++) {
    while (begin < restingCount && resting[begin].x[0] < moving[j].x[0] - reach) {
      begin++;
    }
    for (int i = begin; i < restingCount && resting[i].x[0] <= moving[j].x[0] + reach; i++) {
      if (isNear(scene, &resting[i], &moving[j]) &&
          !addPair(contact, (ParticlePair){resting[i].particle, moving[j].particle})) {
        return false;
      }
    }
  }
  return true;
}

/* Particles on the axis keep their distances, so that what moves against what moves not are all others. */
static bool listPairs(const Scene* scene, const Place* places, Contact* contact) {
  const Torsion* torsion = &scene->torsions[contact->torsion];
  const Rigid motion = motionOf(scene, places, contact->torsion, contact->angle);
  Along* all = malloc(((size_t)scene->particleCount + 1) * sizeof *all);
  if (all == NULL) {
    return false;
  }
  int counts[2] = {0, 0}; /* at rest, from the front; moving, from the back */
  for (int i = 0; i < scene->particleCount; i++) {
    const bool moves = i >= torsion->first && i < torsion->last;
    if (i == torsion->axis[0] || i == torsion->axis[1]) {
      continue;
    }
    Along* along = &all[moves ? scene->particleCount - ++counts[1] : counts[0]++];
    Place place;
    memcpy(place, places[i], sizeof place);
    if (moves) {
      rigidApply(&motion, places[i], place);
    }
    *along = (Along){{(double)place[0], (double)place[1], (double)place[2]}, i};
  }
  const bool success = sweep(scene, all, counts[0], all + scene->particleCount - counts[1], counts[1], contact);
  free(all);
  return success;
}

static void putDeepestFirst(const Scene* scene, const Place* places, Contact* contact) {
  const Rigid motion = motionOf(scene, places, contact->torsion, contact->angle);
  for (int p = 1; p < contact->pairCount; p++) {
    const ParticlePair pair = contact->pairs[p];
    if (overlapOf(scene, places, &motion, pair) > overlapOf(scene, places, &motion, contact->pairs[0])) {
      contact->pairs[p] = contact->pairs[0];
      contact->pairs[0] = pair;
    }
  }
}

/* ---- Finding ---- */

static int ask(const Contestant* judge, void* self, int torsion, double angle) {
  const Turn turn = {torsion, angle};
  const int clash = judge->test(self, 1, &turn);
  judge->reject(self);
  return clash;
}

/* The first place, or one of them, on the way to a clash at `angle`. */
static bool halve(const Contestant* judge, void* self, Contact* contact, double angle) {
  double isFree = 0;
  contact->angle = angle;
  for (int i = 0; i < HALVINGS; i++) {
    const double middle = 0.5 * (isFree + contact->angle);
    const int clash = ask(judge, self, contact->torsion, middle);
    if (clash < 0) {
      return false;
    }
    *(clash ? &contact->angle : &isFree) = middle;
  }
  return true;
}

static bool isSharp(const Scene* scene, const Place* places, const Contact* contact) {
  return contact->pairCount > 0 && fabs(firstOverlap(scene, places, contact, contact->angle)) <= JUDGE_ERROR &&
         fabs(firstSlope(scene, places, contact, contact->angle)) >= LEAST_SLOPE;
}

ContactStatus contactFind(const Scene* scene, const Place* places, const Contestant* judge, void* self, Random* random,
                          Contact* contact) {
  *contact = (Contact){0};
  for (int i = 0; i < TURNS_TRIED; i++) {
    const double angle = PI * (2 * randomReal(random) - 1);
    contact->torsion = randomInt(random, scene->torsionCount);
    contact->pairCount = 0;
    const int clash = ask(judge, self, contact->torsion, angle);
    if (clash == 0) {
      continue;
    }
    if (clash < 0 || !halve(judge, self, contact, angle) || !listPairs(scene, places, contact)) {
      return contactNoMemory;
    }
    putDeepestFirst(scene, places, contact);
    if (isSharp(scene, places, contact)) {
      return contactFound;
    }
  }
  return contactNone;
}

/* How far a particle can be from the axis. */
static long double leverOf(const Scene* scene, const Place* places, int torsion) {
  const Torsion* t = &scene->torsions[torsion];
  long double farthest = 0;
  for (int i = t->first; i < t->last; i++) {
    farthest = fmax(farthest, squaredDistance(places[t->axis[1]], places[i]));
  }
  return sqrt(farthest);
}

bool contactAngle(const Scene* scene, const Place* places, const Contact* contact, double overlap, double* angle) {
  long double exact = contact->angle;
  for (int i = 0; i < CORRECTIONS; i++) {
    exact += (overlap - firstOverlap(scene, places, contact, exact)) / firstSlope(scene, places, contact, exact);
  }
  *angle = (double)exact;
  return fabs(exact - contact->angle) * leverOf(scene, places, contact->torsion) < ROOM / 2;
}
