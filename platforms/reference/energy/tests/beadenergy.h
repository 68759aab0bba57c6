/* beadenergy.h: a long chain of charged beads and its energy, for tests of the calls on an energy. */
#ifndef BEADENERGY_H_
#define BEADENERGY_H_

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../chaintree/tests/check.h"
#include "ctenergy.h"

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
/* c(kind of one bead, kind of the other) / r^2 between beads of even number and all. */
static double kinds[BEADS];
static int allBeads[BEADS];
static int evenBeads[BEADS / 2];
static const double heights[] = {0.3, 0.1, 0.1, 0.2};
static const ctTable heightTable = {.isDiscrete = true, .dimensions = 2, .sizes = {2, 2}, .values = heights};
static const ctOperation pairOperations[] = {{ctInputOperator, {0}, 0},     {ctParameterOperator, {0}, 0},
                                             {ctParameterOperator, {1}, 0}, {ctTableOperator, {1, 2}, 0},
                                             {ctSquareOperator, {0}, 0},    {ctDivideOperator, {3, 4}, 0}};
static const ctInteractionGroup evenGroup = {.counts = {BEADS / 2, BEADS}, .particles = {evenBeads, allBeads}};
static const ctPairSet pairSet = {.operationCount = 6,
                                  .operations = pairOperations,
                                  .tableCount = 1,
                                  .tables = &heightTable,
                                  .parametersPerParticle = 1,
                                  .parameters = kinds,
                                  .cutoff = 1.2,
                                  .switchingDistance = 1,
                                  .exclusionCount = BEADS,
                                  .exclusions = (const int (*)[2])exclusions,
                                  .groupCount = 1,
                                  .groups = &evenGroup};
/* Of each bead the sum of the same over all others, and its square. */
static const ctOperation squareOfValue[] = {{ctParameterOperator, {1}, 0}, {ctSquareOperator, {0}, 0}};
static const ctOperation valueOperations[] = {{ctInputOperator, {0}, 0},     {ctParameterOperator, {0}, 0},
                                              {ctParameterOperator, {2}, 0}, {ctTableOperator, {1, 2}, 0},
                                              {ctSquareOperator, {0}, 0},    {ctDivideOperator, {3, 4}, 0}};
static const ctValueExpression sumOfBead = {
    .extent = ctOfPairs, .operationCount = 6, .operations = valueOperations, .tableCount = 1, .tables = &heightTable};
static const ctValueExpression termOfBead = {.extent = ctOfParticles, .operationCount = 2, .operations = squareOfValue};
static const ctValueEnergy valueEnergy = {.parametersPerParticle = 1,
                                          .parameters = kinds,
                                          .valueCount = 1,
                                          .values = &sumOfBead,
                                          .termCount = 1,
                                          .terms = &termOfBead,
                                          .cutoff = 1.2,
                                          .exclusionCount = BEADS,
                                          .exclusions = (const int (*)[2])exclusions};
static const ctEnergyDefinition definition = {.scene = &scene,
                                              .nonbonded = &nonbonded,
                                              .pairSetCount = 1,
                                              .pairSets = &pairSet,
                                              .termSetCount = 1,
                                              .termSets = &torsionSet,
                                              .valueEnergyCount = 1,
                                              .valueEnergies = &valueEnergy};

/* The same with Born solvation, and so with a stand-in. Some beads have another neck than the others. */
static double bornRadii[BEADS];
static double offsetRadii[BEADS];
static double scaledRadii[BEADS];
static double alphas[BEADS];
static double betas[BEADS];
static double gammas[BEADS];
static int neckTypes[BEADS];
static const double neckHeights[] = {0.1, 0.2, 0.2, 0.3};
static const double neckDistances[] = {0.3, 0.32, 0.32, 0.35};
static const ctBorn bornOfBeads = {.charges = charges,
                                   .radii = bornRadii,
                                   .offsetRadii = offsetRadii,
                                   .scaledRadii = scaledRadii,
                                   .isRescaled = true,
                                   .alphas = alphas,
                                   .betas = betas,
                                   .gammas = gammas,
                                   .neckTypeCount = 2,
                                   .neckTypes = neckTypes,
                                   .neckHeights = neckHeights,
                                   .neckDistances = neckDistances,
                                   .neckScale = 0.8,
                                   .neckCut = 0.2,
                                   .coulomb = 138.935485,
                                   .soluteDielectric = 1,
                                   .solventDielectric = 78.5,
                                   .surfaceEnergy = 28.4,
                                   .probeRadius = 0.14,
                                   .cutoff = INFINITY};
static const ctStandIn standInOfBeads = {.bornCutoff = 0.8, .pairCutoff = 0.9, .gridWidth = 0.05};
static const ctEnergyDefinition definitionWithBorn = {.scene = &scene,
                                                      .nonbonded = &nonbonded,
                                                      .born = &bornOfBeads,
                                                      .standIn = &standInOfBeads,
                                                      .pairSetCount = 1,
                                                      .pairSets = &pairSet,
                                                      .termSetCount = 1,
                                                      .termSets = &torsionSet};
/* That of benches, whether their beads may be displaced, and their periodic box. */
static const ctEnergyDefinition* described = &definition;
static bool isFlexible;
static const double (*boxOfBenches)[3];

/* The first three beads are the root. Each link turns about the bond from the bead before it to its first one. */
static void describe(void) {
  for (int i = 0; i < BEADS; i++) {
    positions[3 * i] = 0.1 * i;
    positions[3 * i + 1] = i % 4 < 2 ? 0.1 : 0;
    positions[3 * i + 2] = (i + 1) % 4 < 2 ? 0.1 : 0;
    listed[i] = 1;
    kinds[i] = i % 3 == 0;
    allBeads[i] = i;
    evenBeads[i / 2] = i / 2 * 2;
    charges[i] = i % 2 == 0 ? 0.3 : -0.3;
    sigmas[i] = 0.1;
    epsilons[i] = 0.2;
    bornRadii[i] = 0.15;
    offsetRadii[i] = 0.14;
    scaledRadii[i] = 0.08;
    alphas[i] = 1;
    betas[i] = 0.8;
    gammas[i] = 4.85;
    neckTypes[i] = i % 5 == 0;
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

static inline Bench makeBench(void) {
  Bench bench;
  ctDefinition own = scene;
  own.isFlexible = isFlexible;
  own.box = boxOfBenches;
  ctEnergyDefinition ofOwn = *described;
  ofOwn.scene = &own;
  CHECK(ctCreate(&own, &bench.tree, NULL, 0) == ctSuccess);
  CHECK(ctCreateEnergy(bench.tree, &ofOwn, &bench.energy, NULL, 0) == ctSuccess);
  return bench;
}

static inline void destroyBench(Bench* bench) {
  ctDestroyEnergy(bench->energy);
  ctDestroy(bench->tree);
}

static inline double total(const Bench* bench) {
  const double ofSet = described->pairSetCount > 0 ? ctGetPairSetEnergy(bench->energy, 0) : 0;
  return ctGetPairEnergy(bench->energy) + ofSet + ctGetTermEnergy(bench->energy, 0);
}

/* Folds the chain to a coil, so that some leaves get more neighbours than there is room for. */
static inline void proposeTimes(const Bench* bench, double factor) {
  static ctChange changes[LINKS];
  unsigned chance = 1;
  for (int link = 1; link < LINKS; link++) {
    chance = chance * 1664525u + 1013904223u;
    changes[link - 1] = (ctChange){.link = link, .angle = factor * 1e-3 * (double)(chance >> 20)};
  }
  CHECK(ctPropose(bench->tree, LINKS - 1, changes) == ctSuccess);
}

static inline void propose(const Bench* bench) {
  proposeTimes(bench, 1);
}

/* Turns three torsions; what a number from 0 up says. */
static inline void proposeTurns(const Bench* bench, unsigned number) {
  ctChange changes[3];
  unsigned chance = 12345u + 977u * number;
  for (int i = 0; i < 3; i++) {
    chance = chance * 1664525u + 1013904223u;
    const int link = 1 + (LINKS - 1) / 3 * i + (int)((chance >> 16) % ((LINKS - 1) / 3));
    changes[i] = (ctChange){.link = link, .angle = 0.3 * ((double)(chance >> 8) * 0x1p-24 - 0.5)};
  }
  CHECK(ctPropose(bench->tree, 3, changes) == ctSuccess);
}

/* Displaces one to four beads, consecutive ones or any; what a number says. */
static inline void proposeDisplacements(const Bench* bench, unsigned number) {
  ctDisplacement displacements[4];
  unsigned chance = 54321u + 977u * number;
  const int count = 1 + (int)(number % 4);
  const int step = number % 3 == 0 ? 147 : 1;
  const int first = (int)((chance * 1664525u >> 8) % BEADS);
  for (int i = 0; i < count; i++) {
    displacements[i].particle = (first + i * step) % BEADS;
    for (int d = 0; d < 3; d++) {
      chance = chance * 1664525u + 1013904223u;
      const double shift = 0.03 * ((double)(chance >> 8) * 0x1p-24 - 0.5);
      displacements[i].shift[d] = i % 2 == 1 ? displacements[0].shift[d] : shift;
    }
  }
  CHECK(ctProposeDisplacements(bench->tree, count, displacements) == ctSuccess);
}

/* Turns, and in a flexible scene mostly displacements. */
static inline void proposeNumber(const Bench* bench, unsigned number) {
  if (isFlexible && number % 5 != 0) {
    proposeDisplacements(bench, number);
  } else {
    proposeTurns(bench, number);
  }
}

static inline ctStatus computeChange(const Bench* bench, double* change) {
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

#endif /* BEADENERGY_H_ */
