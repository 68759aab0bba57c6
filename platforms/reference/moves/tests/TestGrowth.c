/* Growth of loops: they close, their pairs do not clash, and the mean weight does not depend on the population; wrong
 * definitions; no memory. */
#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "../../chaintree/tests/failingallocator.h"
#include "ctgrowth.h"

#define RESIDUES 6
#define PATH (2 * RESIDUES)
#define JOINTS (PATH + 1)            /* one of a side chain */
#define ATOMS (3 * RESIDUES + 3 + 2) /* a chain with fixed ends, and two atoms of the side chain */
#define SIDE (3 * RESIDUES + 3)      /* its first atom */
#define MOVING (3 * RESIDUES + 1)    /* A and C of each residue, N of all but the first, and the side chain */
#define FIXED (ATOMS - MOVING + 1)   /* and an obstacle */
#define TOLERANCE 0.04
#define RADIUS 0.08

static uint64_t chance = 88172645463325252u;

static double draw(void* context) {
  (void)context;
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return (double)(chance >> 11) * 0x1p-53;
}

/* A loop of residues N, A, C between C of a fixed residue and N of another; A of the third has a side chain. */
typedef struct Loop {
  double x[ATOMS][3];
  double joints[JOINTS][4][3];
  int parents[1];
  int atoms[MOVING]; /* that move */
  double moving[MOVING][3];
  double radii[ATOMS];
  uint8_t roles[ATOMS];
  int pieces[MOVING];
  double fixed[ATOMS][3];
  int fixedCount;
  int exclusions[ATOMS * ATOMS][2];
  int fixedExclusions[ATOMS * ATOMS][2];
  int setSizes[RESIDUES + 1];
  int setJoints[JOINTS];
  const ctDensity* densities[RESIDUES + 1];
  ctDensity* pair;
  ctDensity* single;
  ctGrowthDefinition definition;
} Loop;

/* The point at a bond length, angle and dihedral from three others. */
static void placeNext(const double a[3], const double b[3], const double c[3], double dihedral, double* d) {
  double u[3], v[3], n[3], m[3], length = 0, normal = 0;
  for (int k = 0; k < 3; k++) {
    u[k] = c[k] - b[k];
    v[k] = b[k] - a[k];
    length += u[k] * u[k];
  }
  for (int k = 0; k < 3; k++) {
    u[k] /= sqrt(length);
  }
  for (int k = 0; k < 3; k++) {
    n[k] = v[(k + 1) % 3] * u[(k + 2) % 3] - v[(k + 2) % 3] * u[(k + 1) % 3];
    normal += n[k] * n[k];
  }
  for (int k = 0; k < 3; k++) {
    n[k] /= sqrt(normal);
  }
  for (int k = 0; k < 3; k++) {
    m[k] = n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3];
  }
  const double bend = 70 * PI / 180;
  for (int k = 0; k < 3; k++) {
    d[k] = c[k] + 0.15 * (cos(bend) * u[k] + sin(bend) * (cos(dihedral) * m[k] + sin(dihedral) * n[k]));
  }
}

/* Bonds along the chain, and to the side chain, between two atoms. */
static int bondsBetween(int i, int j) {
  const int root = 8; /* A of the third residue */
  const int i0 = i >= SIDE ? root : i, j0 = j >= SIDE ? root : j;
  const int side = (i >= SIDE ? i - SIDE + 1 : 0) + (j >= SIDE ? j - SIDE + 1 : 0);
  return i >= SIDE && j >= SIDE ? abs(i - j) : abs(i0 - j0) + side;
}

/* The place of an atom of the loop among those that move, or of another among those that are fixed. */
static int placeOf(const Loop* loop, int atom, bool* moves) {
  int before = 0;
  for (int i = 0; i < MOVING; i++) {
    if (loop->atoms[i] == atom) {
      *moves = true;
      return i;
    }
    before += loop->atoms[i] < atom ? 1 : 0;
  }
  *moves = false;
  return atom - before;
}

static void addJoint(Loop* loop, int joint, int a, int b, int c, int d) {
  const int atoms[4] = {a, b, c, d};
  for (int i = 0; i < 4; i++) {
    memcpy(loop->joints[joint][i], loop->x[atoms[i]], sizeof loop->x[0]);
  }
}

static void makeLoop(Loop* loop) {
  memset(loop, 0, sizeof *loop);
  double(*x)[3] = loop->x;
  x[1][0] = 0.15;
  x[2][0] = 0.2;
  x[2][1] = 0.14;
  for (int i = 3; i < SIDE; i++) {
    placeNext(x[i - 3], x[i - 2], x[i - 1], i % 3 == 0 ? -0.9 : i % 3 == 1 ? PI : -1.1, x[i]);
  }
  placeNext(x[6], x[7], x[8], 2.5, x[SIDE]);
  placeNext(x[7], x[8], x[SIDE], 1, x[SIDE + 1]);
  int n = 0;
  for (int r = 0; r < RESIDUES; r++) { /* atom 3 r + 1 is N, 3 r + 2 is A, 3 r + 3 is C */
    addJoint(loop, 2 * r, 3 * r, 3 * r + 1, 3 * r + 2, 3 * r + 3);
    addJoint(loop, 2 * r + 1, 3 * r + 1, 3 * r + 2, 3 * r + 3, 3 * r + 4);
    for (int k = 2; k < 5 && 3 * r + k <= 3 * RESIDUES; k++) {
      loop->atoms[n] = 3 * r + k;
      loop->pieces[n++] = k == 4 ? 2 * r + 2 : 2 * r + 1;
    }
  }
  addJoint(loop, PATH, 7, 8, SIDE, SIDE + 1);
  loop->parents[0] = 5;
  for (int k = 0; k < 2; k++) {
    loop->atoms[n] = SIDE + k;
    loop->pieces[n++] = k == 0 ? 5 : PATH;
  }
  CHECK(n == MOVING);
  bool moves;
  for (int i = 0; i < ATOMS; i++) {
    const int place = placeOf(loop, i, &moves);
    memcpy(moves ? loop->moving[place] : loop->fixed[place], x[i], sizeof x[i]);
    loop->radii[i] = RADIUS;
  }
  for (int k = 0; k < 3; k++) { /* an obstacle near the middle */
    loop->fixed[FIXED - 1][k] = x[11][k] + (k == 2 ? 0.35 : 0.1);
  }
  ctGrowthDefinition* d = &loop->definition;
  for (int i = 0; i < ATOMS; i++) {
    for (int j = 0; j < ATOMS; j++) {
      bool movesToo;
      const int place = placeOf(loop, i, &moves), other = placeOf(loop, j, &movesToo);
      if (moves && bondsBetween(i, j) <= 3 && (!movesToo || i < j)) {
        int* pair = movesToo ? loop->exclusions[d->exclusionCount++] : loop->fixedExclusions[d->fixedExclusionCount++];
        pair[0] = place;
        pair[1] = other;
      }
    }
  }
  const int bins[2] = {3, 2};
  const double values[6] = {1, 2, 3, 2, 1, 1};
  loop->pair = ctCreateTable(2, bins, values, 0);
  loop->single = ctCreateTable(1, bins, values, 0);
  for (int i = 0; i <= RESIDUES; i++) {
    loop->setSizes[i] = i < RESIDUES ? 2 : 1;
    loop->densities[i] = i < RESIDUES ? loop->pair : loop->single;
  }
  for (int j = 0; j < JOINTS; j++) {
    loop->setJoints[j] = j;
  }
  d->pathCount = PATH;
  d->jointCount = JOINTS;
  d->jointPositions = (const double(*)[4][3])loop->joints;
  d->parents = loop->parents;
  d->particleCount = MOVING;
  d->positions = (const double(*)[3])loop->moving;
  d->radii = loop->radii;
  d->roles = loop->roles;
  d->pieces = loop->pieces;
  d->fixedCount = FIXED;
  d->fixedPositions = (const double(*)[3])loop->fixed;
  d->fixedRadii = loop->radii;
  d->fixedRoles = loop->roles;
  d->exclusions = (const int(*)[2])loop->exclusions;
  d->fixedExclusions = (const int(*)[2])loop->fixedExclusions;
  d->tolerance = TOLERANCE;
  d->setCount = RESIDUES + 1;
  d->setSizes = loop->setSizes;
  d->setJoints = loop->setJoints;
  d->densities = loop->densities;
}

static void freeLoop(Loop* loop) {
  ctDestroyDensity(loop->pair);
  ctDestroyDensity(loop->single);
}

static double distanceOf(const double a[3], const double b[3]) {
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* Bond lengths and angles stay, and no pair clashes. */
static void checkLoop(const Loop* loop, const double (*grown)[3]) {
  double x[ATOMS + 1][3];
  bool moves, movesToo;
  for (int i = 0; i < ATOMS; i++) {
    const int place = placeOf(loop, i, &moves);
    memcpy(x[i], moves ? grown[place] : loop->fixed[place], sizeof x[i]);
  }
  memcpy(x[ATOMS], loop->fixed[FIXED - 1], sizeof x[ATOMS]);
  for (int i = 0; i < ATOMS; i++) {
    placeOf(loop, i, &moves);
    for (int j = 0; j < i; j++) {
      placeOf(loop, j, &movesToo);
      const double distance = distanceOf(x[i], x[j]);
      if (bondsBetween(i, j) <= 2) {
        CHECK_NEAR(distance, distanceOf(loop->x[i], loop->x[j]), 1e-10);
      } else if (bondsBetween(i, j) > 3 && (moves || movesToo)) {
        CHECK(distance >= 2 * RADIUS - TOLERANCE - 1e-12);
      }
    }
    CHECK(!moves || distanceOf(x[i], x[ATOMS]) >= 2 * RADIUS - TOLERANCE - 1e-12);
  }
}

static void testLoops(void) {
  Loop loop;
  makeLoop(&loop);
  const char* problem = NULL;
  ctGrowth* growth = ctCreateGrowth(&loop.definition, &problem);
  CHECK(growth != NULL);
  double positions[MOVING][3], angles[JOINTS], logWeight, logDensity;
  bool hasMemory;
  double means[2], errors[2];
  for (int study = 0; study < 2; study++) {
    const ctGrowthRun run = {study == 0 ? 3 : 30, study == 0 ? 6 : 16, 2, draw, NULL};
    const int count = study == 0 ? 1000 : 120;
    double sum = 0, squares = 0;
    for (int i = 0; i < count; i++) {
      if (ctGrow(growth, &run, positions, angles, &logWeight, &logDensity, &hasMemory)) {
        checkLoop(&loop, (const double(*)[3])positions);
        sum += exp(logWeight);
        squares += exp(2 * logWeight);
      }
      CHECK(hasMemory);
    }
    means[study] = sum / count;
    errors[study] = sqrt((squares / count - means[study] * means[study]) / count);
  }
  CHECK(means[0] > 0 && errors[0] < 0.3 * means[0] && errors[1] < 0.3 * means[1]);
  CHECK(fabs(means[0] - means[1]) < 4 * sqrt(errors[0] * errors[0] + errors[1] * errors[1]));
  ctDestroyGrowth(growth);
  freeLoop(&loop);
}

static void testWrongDefinitions(void) {
  Loop loop;
  const char* problem;
  for (int fault = 0; fault < 7; fault++) {
    makeLoop(&loop);
    loop.parents[0] = fault == 0 ? PATH : loop.parents[0];
    loop.pieces[3] = fault == 1 ? JOINTS : loop.pieces[3];
    loop.setJoints[4] = fault == 2 ? 5 : loop.setJoints[4];
    loop.setJoints[4] = fault == 3 ? PATH : loop.setJoints[4];
    loop.exclusions[0][1] = fault == 4 ? MOVING : loop.exclusions[0][1];
    loop.definition.setCount = fault == 5 ? 2 : loop.definition.setCount;
    memset(loop.joints[1], 0, fault == 6 ? sizeof loop.joints[1] : 0);
    CHECK(ctCreateGrowth(&loop.definition, &problem) == NULL);
    CHECK((strstr(problem, "no three residues") != NULL) == (fault == 5));
    CHECK(ctCreateGrowth(&loop.definition, NULL) == NULL);
    freeLoop(&loop);
  }
  ctDestroyGrowth(NULL);
}

static void testNoMemory(void) {
#ifdef HAS_GLIBC_ALLOCATOR
  Loop loop;
  makeLoop(&loop);
  const int before = live;
  ctGrowth* growth = NULL;
  for (int n = 0; growth == NULL && n < 200; n++) {
    failAllocation(n);
    growth = ctCreateGrowth(&loop.definition, NULL);
    CHECK(hasFailed == (growth == NULL));
    CHECK(growth != NULL || live == before);
  }
  CHECK(growth != NULL);
  const int made = live;
  const ctGrowthRun run = {2, 2, 1, draw, NULL};
  double positions[MOVING][3], angles[JOINTS], logWeight, logDensity;
  bool hasMemory = false;
  for (int n = 0; !hasMemory && n < 200; n++) {
    failAllocation(n);
    ctGrow(growth, &run, positions, angles, &logWeight, &logDensity, &hasMemory);
    CHECK(hasFailed != hasMemory && live == made);
  }
  CHECK(hasMemory);
  failAllocation(-1);
  ctDestroyGrowth(growth);
  freeLoop(&loop);
#endif
}

int main(void) {
  testLoops();
  testWrongDefinitions();
  testNoMemory();
  return checkResult();
}
