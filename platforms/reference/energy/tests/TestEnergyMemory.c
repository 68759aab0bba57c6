/* Every allocation of every call on an energy fails once: the call says so, and the energy is as good as new once the
 * caller has done what the header asks for. By every instruction set.
 *
 * The program puts its own functions before the C library's allocator; where that cannot be done, it is skipped. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../chaintree/tests/check.h"
#include "../../chaintree/tests/failingallocator.h"
#include "ctenergy.h"

#ifndef HAS_GLIBC_ALLOCATOR

int main(void) {
  return 77;
}

#else

/* A chain of beads, each a link, in which those two apart are excluded. */
enum { BEADS = 600, LINKS = BEADS - 3 };

static double positions[3 * BEADS];
static double radii[BEADS];
static int links[BEADS];
static int parents[BEADS];
static uint8_t joints[BEADS];
static uint8_t listed[BEADS];
static int torsions[BEADS][4];
static double charges[BEADS];
static double sigmas[BEADS];
static double epsilons[BEADS];
static int exclusions[BEADS][2];
static int quadruples[4 * BEADS];
static double periodic[3 * BEADS];

static const ctDefinition scene = {.particleCount = BEADS,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = links,
                                   .listed = listed,
                                   .linkCount = LINKS,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int (*)[4])torsions};
static const ctNonbonded nonbonded = {.charges = charges,
                                      .sigmas = sigmas,
                                      .epsilons = epsilons,
                                      .cutoff = 1.8,
                                      .switchingDistance = 1.5,
                                      .dielectric = 78,
                                      .exclusionCount = BEADS,
                                      .exclusions = (const int (*)[2])exclusions};
static const ctTermSet torsionSet = {.kind = ctPeriodicTorsionTerm,
                                     .count = LINKS,
                                     .particlesPerTerm = 4,
                                     .particles = quadruples,
                                     .parametersPerTerm = 3,
                                     .parameters = periodic};
static const ctEnergyDefinition definition = {&scene, &nonbonded, 1, &torsionSet};

/* The first three beads are the root. Each link turns about the bond from the bead before it to its first one. */
static void describe(void) {
  for (int i = 0; i < BEADS; i++) {
    positions[3 * i] = 0.1 * i;
    positions[3 * i + 1] = i % 4 < 2 ? 0.1 : 0;
    positions[3 * i + 2] = (i + 1) % 4 < 2 ? 0.1 : 0;
    listed[i] = 1;
    charges[i] = i % 2 == 0 ? 0.3 : -0.3;
    sigmas[i] = 0.1;
    epsilons[i] = 0.2;
    links[i] = i < 3 ? 0 : i - 2 < LINKS ? i - 2 : LINKS - 1;
    exclusions[i][0] = i;
    exclusions[i][1] = (i + 2) % BEADS;
    periodic[3 * i] = 1;
    periodic[3 * i + 2] = 3;
    for (int k = 0; k < 4 && i < LINKS; k++) {
      quadruples[4 * i + k] = i + k;
    }
  }
  for (int link = 0; link < LINKS; link++) {
    parents[link] = link - 1;
    joints[link] = (uint8_t)(link == 0 ? ctFreeJoint : ctTorsionJoint);
    for (int k = 0; k < 4; k++) {
      torsions[link][k] = link + k;
    }
  }
}

/* ---- Scenes ---- */

typedef struct Bench {
  ctChainTree* tree;
  ctEnergy* energy;
} Bench;

static Bench makeBench(void) {
  Bench bench;
  CHECK(ctCreate(&scene, &bench.tree, NULL, 0) == ctSuccess);
  CHECK(ctCreateEnergy(bench.tree, &definition, &bench.energy, NULL, 0) == ctSuccess);
  return bench;
}

static void destroyBench(Bench* bench) {
  ctDestroyEnergy(bench->energy);
  ctDestroy(bench->tree);
}

static double total(const Bench* bench) {
  return ctGetPairEnergy(bench->energy) + ctGetTermEnergy(bench->energy, 0);
}

/* Folds the chain to a coil, so that some leaves get more neighbours than there is room for. */
static void propose(const Bench* bench) {
  static ctChange changes[LINKS];
  unsigned chance = 1;
  for (int link = 1; link < LINKS; link++) {
    chance = chance * 1664525u + 1013904223u;
    changes[link - 1] = (ctChange){.link = link, .angle = 1e-3 * (double)(chance >> 20)};
  }
  CHECK(ctPropose(bench->tree, LINKS - 1, changes) == ctSuccess);
}

static ctStatus computeChange(const Bench* bench, double* change) {
  *change = 0;
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    double ofPart;
    const ctStatus status = ctComputeEnergyChange(bench->energy, (ctEnergyPart)part, &ofPart, NULL);
    if (status != ctSuccess) {
      return status;
    }
    *change += ofPart;
  }
  return ctSuccess;
}

/* What comes out where nothing fails. */
typedef struct Expected {
  double start;
  double change;
  double end;
} Expected;

static Expected findExpected(void) {
  Expected expected;
  Bench bench = makeBench();
  CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
  expected.start = total(&bench);
  propose(&bench);
  CHECK(computeChange(&bench, &expected.change) == ctSuccess);
  CHECK(ctCommit(bench.tree, NULL) == ctSuccess);
  CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
  expected.end = total(&bench);
  CHECK(fabs(expected.end - expected.start - expected.change) < 1e-9);
  CHECK(fabs(expected.change) > 1);
  destroyBench(&bench);
  return expected;
}

static void checkRefusal(const Bench* bench, ctStatus status) {
  CHECK(hasFailed && status == ctOutOfMemory);
  CHECK(strcmp(ctGetEnergyErrorText(bench->energy), "out of memory") == 0);
}

/* ---- Calls: sorting does without memory if it has to, so that not each allocation that fails is noticed ---- */

static void testCreate(void) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    ctChainTree* tree;
    ctEnergy* energy = NULL;
    char text[100] = "";
    CHECK(ctCreate(&scene, &tree, NULL, 0) == ctSuccess);
    failAllocation(n);
    const ctStatus status = ctCreateEnergy(tree, &definition, &energy, text, sizeof text);
    allocationsLeft = -1;
    goesOn = hasFailed;
    CHECK((status == ctSuccess) == (energy != NULL));
    if (status != ctSuccess) {
      refused++;
      CHECK(hasFailed && status == ctOutOfMemory && strcmp(text, "out of memory") == 0);
      /* The scene is none the worse for it. */
      CHECK(ctCreateEnergy(tree, &definition, &energy, text, sizeof text) == ctSuccess);
      CHECK(ctRefreshEnergy(energy, NULL) == ctSuccess);
    }
    ctDestroyEnergy(energy);
    ctDestroy(tree);
    CHECK(live == before);
  }
  CHECK(refused > 20);
}

static void testRefresh(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    Bench bench = makeBench();
    failAllocation(n);
    const ctStatus status = ctRefreshEnergy(bench.energy, NULL);
    allocationsLeft = -1;
    goesOn = hasFailed;
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    }
    CHECK(total(&bench) == expected->start);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 5);
}

/* A change that was refused memory can be asked for again, in the same trial or in another. */
static void testChange(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    double change;
    Bench bench = makeBench();
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    propose(&bench);
    failAllocation(n);
    const ctStatus status = computeChange(&bench, &change);
    allocationsLeft = -1;
    goesOn = hasFailed;
    CHECK(total(&bench) == expected->start);
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      if (n % 2 == 0) {
        ctDiscard(bench.tree);
        propose(&bench);
      }
      CHECK(computeChange(&bench, &change) == ctSuccess);
    }
    CHECK(change == expected->change);
    CHECK(ctCommit(bench.tree, NULL) == ctSuccess);
    CHECK(ctAcceptEnergyChange(bench.energy) == ctSuccess);
    CHECK(total(&bench) == expected->end);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 3);
}

/* A change that was refused memory when the trial was accepted is not of the state: that is computed anew. */
static void testAccept(const Expected* expected) {
  const int before = live;
  int refused = 0;
  bool goesOn = true;
  for (int n = 0; goesOn; n++) {
    double change;
    Bench bench = makeBench();
    CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    propose(&bench);
    CHECK(computeChange(&bench, &change) == ctSuccess);
    CHECK(ctCommit(bench.tree, NULL) == ctSuccess);
    failAllocation(n);
    const ctStatus status = ctAcceptEnergyChange(bench.energy);
    allocationsLeft = -1;
    goesOn = hasFailed;
    if (status != ctSuccess) {
      refused++;
      checkRefusal(&bench, status);
      CHECK(ctRefreshEnergy(bench.energy, NULL) == ctSuccess);
    }
    CHECK(fabs(total(&bench) - expected->end) < 1e-4);
    destroyBench(&bench);
    CHECK(live == before);
  }
  CHECK(refused > 0);
}

int main(void) {
  printf("\n"); /* its buffer is no leak of ours */
  describe();
  const char* const sets[] = {"avx512", "avx2", "portable"};
  for (int i = 0; i < 3; i++) {
    setenv("CHAINTREE_SIMD", sets[i], 1);
    const Expected expected = findExpected();
    testCreate();
    testRefresh(&expected);
    testChange(&expected);
    testAccept(&expected);
  }
  return checkResult();
}

#endif
