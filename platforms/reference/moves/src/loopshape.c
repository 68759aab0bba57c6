#include "loopshape.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "turning.h"

/* nm. A particle this near to an axis keeps its distances when its joint turns. */
#define ON_AXIS 1e-5

static const char* const NO_MEMORY = "there is no memory";

static void* allocate(int count, size_t size) {
  return calloc((size_t)count + 1, size);
}

/* ---- Joints ---- */

static double dihedralOf(const double x[4][3]) {
  double a[3], b[3], c[3], n[3], m[3], side[3];
  subtract(x[1], x[0], a);
  subtract(x[2], x[1], b);
  subtract(x[3], x[2], c);
  cross(a, b, n);
  cross(b, c, m);
  cross(n, m, side);
  return atan2(dot(side, b) / sqrt(dot(b, b)), dot(n, m));
}

static bool readJoints(const ctGrowthDefinition* d, LoopShape* s) {
  for (int j = 0; j < d->jointCount; j++) {
    const double(*x)[3] = d->jointPositions[j];
    subtract(x[2], x[1], s->axes[j]);
    const double length = sqrt(dot(s->axes[j], s->axes[j]));
    scale(s->axes[j], 1 / length);
    memcpy(s->points[j], x[2], sizeof s->points[j]);
    s->angles[j] = dihedralOf(x);
    if (!(length > 0 && isfinite(s->angles[j]))) {
      return false;
    }
  }
  for (int p = 0; p < d->jointCount; p++) {
    const bool isOnPath = p < d->pathCount;
    s->parents[p] = isOnPath ? p - 1 : d->parents[p - d->pathCount];
    if (!isOnPath && (s->parents[p] < 1 || s->parents[p] >= p)) {
      return false;
    }
    s->bodies[p] = isOnPath ? p : s->bodies[s->parents[p]];
  }
  return true;
}

static bool readSets(const ctGrowthDefinition* d, LoopShape* s) {
  int* joints = s->setJoints;
  for (int j = 0; j < d->jointCount; j++) {
    s->setOf[j] = -1;
  }
  for (int i = 0; i < d->setCount; i++) {
    const int count = d->setSizes[i];
    JointSet set = {joints, count, d->densities[i], ctCountUniforms(d->densities[i]), -1};
    if (count < 1 || count > CT_DENSITY_MOST) {
      return false;
    }
    for (int k = 0; k < count; k++) {
      const int j = d->setJoints[joints - s->setJoints + k];
      if (j < 0 || j >= d->jointCount || s->setOf[j] != -1) {
        return false;
      }
      s->setOf[j] = i;
      joints[k] = j;
      const bool isOnPath = j < d->pathCount;
      const int body = isOnPath ? -1 : s->bodies[j];
      if (k > 0 && (body != set.body || (isOnPath && j != joints[k - 1] + 1))) {
        return false;
      }
      set.body = body;
    }
    s->sets[i] = set;
    joints += count;
  }
  return true;
}

/* ---- Particles ---- */

static bool readParticles(const ctGrowthDefinition* d, LoopShape* s) {
  for (int i = 0; i < d->particleCount; i++) {
    if (d->pieces[i] < 1 || d->pieces[i] >= d->jointCount) {
      return false;
    }
    s->firsts[d->pieces[i] + 1]++;
  }
  for (int p = 0; p < d->jointCount; p++) {
    s->firsts[p + 1] += s->firsts[p];
  }
  int n = 0;
  for (int p = 1; p < d->jointCount; p++) {
    for (int i = 0; i < d->particleCount; i++) {
      if (d->pieces[i] == p) {
        s->order[n] = i;
        memcpy(s->spheres[n].x, d->positions[i], sizeof s->spheres[n].x);
        s->spheres[n].radius = d->radii[i];
        s->roles[n] = d->roles[i];
        n++;
      }
    }
  }
  for (int i = 0; i < d->fixedCount; i++) {
    memcpy(s->fixedSpheres[i].x, d->fixedPositions[i], sizeof s->fixedSpheres[i].x);
    s->fixedSpheres[i].radius = d->fixedRadii[i];
    s->fixedRoles[i] = d->fixedRoles[i];
  }
  return true;
}

static double squaredDistance(const double a[3], const double b[3]) {
  double between[3];
  subtract(a, b, between);
  return dot(between, between);
}

static void boundPieces(LoopShape* s) {
  for (int p = 1; p < s->jointCount; p++) {
    const int count = s->firsts[p + 1] - s->firsts[p];
    Sphere* bound = &s->bounds[p];
    for (int i = s->firsts[p]; i < s->firsts[p + 1]; i++) {
      addScaled(bound->x, 1.0 / count, s->spheres[i].x);
    }
    for (int i = s->firsts[p]; i < s->firsts[p + 1]; i++) {
      const double reach = sqrt(squaredDistance(s->spheres[i].x, bound->x)) + s->spheres[i].radius;
      bound->radius = fmax(bound->radius, reach);
    }
  }
}

static double distanceFromAxis(const LoopShape* s, int joint, const double x[3]) {
  double arm[3], across[3];
  subtract(x, s->points[joint], arm);
  cross(arm, s->axes[joint], across);
  return sqrt(dot(across, across));
}

/* True if a joint between two pieces that it joins cannot change the distance of two particles of these. */
static bool keepsDistance(const LoopShape* s, int joint, const double x1[3], const double x2[3]) {
  return distanceFromAxis(s, joint, x1) < ON_AXIS || distanceFromAxis(s, joint, x2) < ON_AXIS;
}

/* The joint between two pieces that it joins; -1 if there is none. Piece 0 lies at both ends of the path. */
static int jointBetween(const LoopShape* s, int piece1, int piece2) {
  const int low = piece1 < piece2 ? piece1 : piece2, high = piece1 < piece2 ? piece2 : piece1;
  if (low == 0 && high == s->pathCount - 1) {
    return high;
  }
  if (s->parents[high] != low) {
    return -1;
  }
  return high < s->pathCount ? high - 1 : high;
}

/* Collects pairs (particle, partner) into lists by particle. */
typedef struct PairList {
  int count;
  int capacity;
  int (*pairs)[2];
  bool hasMemory;
} PairList;

static void addPair(PairList* list, int i, int j) {
  if (list->count == list->capacity) {
    const int capacity = 2 * list->capacity + 64;
    int(*grown)[2] = realloc(list->pairs, (size_t)capacity * sizeof *grown);
    if (grown == NULL) {
      list->hasMemory = false;
      return;
    }
    list->pairs = grown;
    list->capacity = capacity;
  }
  list->pairs[list->count][0] = i;
  list->pairs[list->count++][1] = j;
}

/* Frees the list. */
static bool makePartners(PairList* list, int count, Partners* partners) {
  partners->firsts = allocate(count + 1, sizeof(int));
  partners->items = allocate(list->count, sizeof(int));
  const bool isMade = list->hasMemory && partners->firsts != NULL && partners->items != NULL;
  if (isMade) {
    for (int k = 0; k < list->count; k++) {
      partners->firsts[list->pairs[k][0] + 1]++;
    }
    for (int i = 0; i < count; i++) {
      partners->firsts[i + 1] += partners->firsts[i];
    }
    for (int k = list->count - 1; k >= 0; k--) {
      const int i = list->pairs[k][0];
      partners->items[--partners->firsts[i + 1]] = list->pairs[k][1];
    }
    /* Each end has become the beginning of its own list. */
    memmove(partners->firsts, partners->firsts + 1, (size_t)count * sizeof(int));
    partners->firsts[count] = list->count;
  }
  free(list->pairs);
  return isMade;
}

static int pieceOf(const LoopShape* s, int particle) {
  int p = 1;
  while (s->firsts[p + 1] <= particle) {
    p++;
  }
  return p;
}

/* Excluded pairs, and pairs whose distance no joint changes. */
static bool listPartners(const ctGrowthDefinition* d, LoopShape* s) {
  PairList moving = {.hasMemory = true}, fixed = {.hasMemory = true};
  int* placeOf = allocate(d->particleCount, sizeof(int));
  bool isRight = placeOf != NULL;
  for (int i = 0; isRight && i < d->particleCount; i++) {
    placeOf[s->order[i]] = i;
  }
  for (int k = 0; isRight && k < d->exclusionCount; k++) {
    const int i = d->exclusions[k][0], j = d->exclusions[k][1];
    isRight = i >= 0 && j >= 0 && i < d->particleCount && j < d->particleCount;
    if (isRight) {
      addPair(&moving, placeOf[i], placeOf[j]);
      addPair(&moving, placeOf[j], placeOf[i]);
    }
  }
  for (int k = 0; isRight && k < d->fixedExclusionCount; k++) {
    const int i = d->fixedExclusions[k][0], j = d->fixedExclusions[k][1];
    isRight = i >= 0 && j >= 0 && i < d->particleCount && j < d->fixedCount;
    if (isRight) {
      addPair(&fixed, placeOf[i], j);
    }
  }
  for (int i = 0; isRight && i < s->particleCount; i++) {
    const int piece = pieceOf(s, i);
    for (int j = 0; j < s->particleCount; j++) {
      const int joint = jointBetween(s, piece, pieceOf(s, j));
      if (joint != -1 && keepsDistance(s, joint, s->spheres[i].x, s->spheres[j].x)) {
        addPair(&moving, i, j);
      }
    }
    const int* near;
    const int count = spheresNear(&s->grid, s->spheres[i].x, &near);
    const int joint = jointBetween(s, 0, piece);
    for (int k = 0; joint != -1 && k < count; k++) {
      if (keepsDistance(s, joint, s->spheres[i].x, s->fixedSpheres[near[k]].x)) {
        addPair(&fixed, i, near[k]);
      }
    }
  }
  free(placeOf);
  const bool areMade = makePartners(&moving, s->particleCount, &s->partners);
  return makePartners(&fixed, s->particleCount, &s->fixedPartners) && areMade && isRight;
}

/* The largest distance of a particle of a piece from the path. */
static double reachOf(const LoopShape* s, int piece) {
  double base = 0, most = 0;
  for (int p = piece; p >= s->pathCount; p = s->parents[p]) {
    base += sqrt(squaredDistance(s->points[p], s->points[s->parents[p]]));
  }
  for (int i = s->firsts[piece]; i < s->firsts[piece + 1]; i++) {
    most = fmax(most, sqrt(squaredDistance(s->spheres[i].x, s->points[piece])));
  }
  return base + most;
}

/* A grid of all that a loop may meet: no point of the path is farther from the middle of its ends than half its length.
 */
static bool makeGrid(const ctGrowthDefinition* d, LoopShape* s) {
  double center[3], length = 0, reach = 0, largest = 0;
  for (int k = 0; k < 3; k++) {
    center[k] = 0.5 * (s->points[0][k] + s->points[s->pathCount - 1][k]);
  }
  for (int j = 1; j < s->pathCount; j++) {
    length += sqrt(squaredDistance(s->points[j], s->points[j - 1]));
  }
  for (int p = 1; p < s->jointCount; p++) {
    reach = fmax(reach, reachOf(s, p));
  }
  for (int i = 0; i < s->particleCount; i++) {
    largest = fmax(largest, s->spheres[i].radius);
  }
  return makeSphereGrid(d->fixedCount, s->fixedSpheres, center, 0.5 * length + reach, largest - d->tolerance, &s->grid);
}

static bool allocateShape(const ctGrowthDefinition* d, LoopShape* s) {
  const int joints = d->jointCount, particles = d->particleCount;
  int setJoints = 0;
  for (int i = 0; i < d->setCount; i++) {
    setJoints += d->setSizes[i];
  }
  s->points = allocate(joints, sizeof *s->points);
  s->axes = allocate(joints, sizeof *s->axes);
  s->angles = allocate(joints, sizeof *s->angles);
  s->parents = allocate(joints, sizeof *s->parents);
  s->bodies = allocate(joints, sizeof *s->bodies);
  s->firsts = allocate(joints + 1, sizeof *s->firsts);
  s->bounds = allocate(joints, sizeof *s->bounds);
  s->setOf = allocate(joints, sizeof *s->setOf);
  s->order = allocate(particles, sizeof *s->order);
  s->spheres = allocate(particles, sizeof *s->spheres);
  s->roles = allocate(particles, sizeof *s->roles);
  s->fixedSpheres = allocate(d->fixedCount, sizeof *s->fixedSpheres);
  s->fixedRoles = allocate(d->fixedCount, sizeof *s->fixedRoles);
  s->sets = allocate(d->setCount, sizeof *s->sets);
  s->setJoints = allocate(setJoints, sizeof *s->setJoints);
  return s->points && s->axes && s->angles && s->parents && s->bodies && s->firsts && s->bounds && s->setOf &&
         s->order && s->spheres && s->roles && s->fixedSpheres && s->fixedRoles && s->sets && s->setJoints;
}

bool makeLoopShape(const ctGrowthDefinition* d, LoopShape* s, const char** problem) {
  *s = (LoopShape){.pathCount = d->pathCount,
                   .jointCount = d->jointCount,
                   .particleCount = d->particleCount,
                   .tolerance = d->tolerance,
                   .allowance = d->allowance,
                   .setCount = d->setCount};
  *problem = "the definition of the loop contradicts its comments";
  if (d->pathCount < 1 || d->jointCount < d->pathCount || d->particleCount < 0 || d->fixedCount < 0 ||
      d->setCount < 0) {
    return false;
  }
  if (!allocateShape(d, s)) {
    *problem = NO_MEMORY;
    return false;
  }
  if (!readJoints(d, s) || !readSets(d, s) || !readParticles(d, s)) {
    return false;
  }
  boundPieces(s);
  if (!makeGrid(d, s)) {
    *problem = NO_MEMORY;
    return false;
  }
  return listPartners(d, s);
}

void freeLoopShape(LoopShape* s) {
  void* arrays[] = {s->points,
                    s->axes,
                    s->angles,
                    s->parents,
                    s->bodies,
                    s->firsts,
                    s->bounds,
                    s->setOf,
                    s->order,
                    s->spheres,
                    s->roles,
                    s->fixedSpheres,
                    s->fixedRoles,
                    s->sets,
                    s->setJoints,
                    s->partners.firsts,
                    s->partners.items,
                    s->fixedPartners.firsts,
                    s->fixedPartners.items};
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
    free(arrays[i]);
  }
  freeSphereGrid(&s->grid);
}
