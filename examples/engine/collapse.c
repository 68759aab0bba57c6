/* Collapse of a chain of beads that attract each other: Metropolis Monte Carlo of its torsions with the engine alone.
 *
 * Hard spheres are tested first, since most trials of a dense chain clash. The energy change is computed only for
 * trials without a clash. */
#include <ctenergy.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BEADS = 100, TRIALS = 20000 };

static const double kT = 2.494;   /* kJ/mol, at 300 K */
static const double radius = 0.2; /* nm */

/* A torsion rotates everything behind the bond between two beads. So each bead is a link, except that the first two
 * and the last two form one link each, since no torsion moves them relative to each other. */
typedef struct Chain {
  double positions[BEADS][3];
  double radii[BEADS];
  double charges[BEADS];
  double sigmas[BEADS];
  double epsilons[BEADS];
  int links[BEADS];
  int parents[BEADS];
  uint8_t joints[BEADS];
  int torsions[BEADS][4];
  int exclusions[2 * BEADS][2];
} Chain;

static void stop(const char* what) {
  fprintf(stderr, "%s\n", what);
  exit(1);
}

/* Describes a zigzag chain. */
static void describe(Chain* chain, ctDefinition* scene, ctNonbonded* pairs) {
  int exclusions = 0;
  for (int i = 0; i < BEADS; i++) {
    chain->positions[i][0] = 0.32 * i;
    chain->positions[i][1] = i % 2 == 0 ? 0.1 : -0.1;
    chain->positions[i][2] = 0;
    chain->radii[i] = radius;
    chain->charges[i] = 0;
    chain->sigmas[i] = 2 * radius;
    chain->epsilons[i] = 2;
    const int link = i < 2 ? 0 : i < BEADS - 1 ? i - 1 : BEADS - 3;
    chain->links[i] = link;
    chain->parents[link] = link - 1;
    chain->joints[link] = (uint8_t)(link == 0 ? ctFreeJoint : ctTorsionJoint);
    for (int k = 0; k < 4 && link > 0; k++) {
      chain->torsions[link][k] = link - 1 + k;
    }
    for (int other = i - 2; other < i; other++) {
      if (other >= 0) {
        chain->exclusions[exclusions][0] = other;
        chain->exclusions[exclusions++][1] = i;
      }
    }
  }
  *scene = (ctDefinition){.particleCount = BEADS,
                          .positions = chain->positions[0],
                          .radii = chain->radii,
                          .particleLinks = chain->links,
                          .linkCount = BEADS - 2,
                          .linkParents = chain->parents,
                          .linkJoints = chain->joints,
                          .linkTorsions = (const int(*)[4])chain->torsions,
                          .exclusionCount = exclusions,
                          .exclusions = (const int(*)[2])chain->exclusions,
                          .overlapTolerance = 0.04};
  *pairs = (ctNonbonded){.charges = chain->charges,
                         .sigmas = chain->sigmas,
                         .epsilons = chain->epsilons,
                         .cutoff = 1,
                         .switchingDistance = 0.8,
                         .dielectric = 1,
                         .exclusionCount = exclusions,
                         .exclusions = (const int(*)[2])chain->exclusions};
}

/* Returns a number uniform in [0, 1) by splitmix64, which is the same on every machine. */
static double draw(uint64_t* state) {
  uint64_t z = *state += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* Returns whether to accept the open trial, and its energy change in kJ/mol: the Metropolis criterion. */
static bool decide(ctEnergy* energy, uint64_t* random, double* change) {
  *change = 0;
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    double ofPart;
    if (ctComputeEnergyChange(energy, (ctEnergyPart)part, &ofPart, NULL) != ctSuccess) {
      stop(ctGetEnergyErrorText(energy));
    }
    *change += ofPart;
  }
  return draw(random) < exp(-*change / kT);
}

static double radiusOfGyration(ctChainTree* tree) {
  double positions[BEADS][3];
  double centre[3] = {0, 0, 0};
  double sum = 0;
  ctGetPositions(tree, positions[0]);
  for (int i = 0; i < 3 * BEADS; i++) {
    centre[i % 3] += positions[i / 3][i % 3] / BEADS;
  }
  for (int i = 0; i < 3 * BEADS; i++) {
    const double offset = positions[i / 3][i % 3] - centre[i % 3];
    sum += offset * offset;
  }
  return sqrt(sum / BEADS);
}

int main(void) {
  static Chain chain;
  ctDefinition scene;
  ctNonbonded pairs;
  describe(&chain, &scene, &pairs);
  char text[256];
  ctChainTree* tree;
  if (ctCreate(&scene, &tree, text, sizeof text) != ctSuccess) {
    stop(text);
  }
  ctEnergy* energy;
  if (ctCreateEnergy(tree, &(ctEnergyDefinition){.scene = &scene, .nonbonded = &pairs}, &energy, text, sizeof text) !=
          ctSuccess ||
      ctRefreshEnergy(energy, NULL) != ctSuccess) {
    stop(text);
  }

  double held = ctGetPairEnergy(energy);
  printf("at the start: %.2f kJ/mol, radius of gyration %.2f nm\n", held, radiusOfGyration(tree));
  uint64_t random = 1;
  int clashed = 0;
  int accepted = 0;
  for (int trial = 0; trial < TRIALS; trial++) {
    const int link = 1 + (int)(draw(&random) * (BEADS - 3));
    const ctChange turn = {.link = link, .angle = 2 * (draw(&random) - 0.5)};
    bool clash;
    if (ctPropose(tree, 1, &turn) != ctSuccess || ctTestTrial(tree, &clash, NULL, NULL) != ctSuccess) {
      stop(ctGetErrorText(tree));
    }
    clashed += clash;
    double change;
    if (clash || !decide(energy, &random, &change)) {
      ctReject(tree);
      continue;
    }
    if (ctAccept(tree, NULL) != ctSuccess || ctAcceptEnergyChange(energy) != ctSuccess) {
      stop(ctGetErrorText(tree));
    }
    held += change;
    accepted++;
  }

  bool clash;
  if (ctHasClash(tree, &clash, NULL, NULL) != ctSuccess || ctRefreshEnergy(energy, NULL) != ctSuccess) {
    stop(ctGetErrorText(tree));
  }
  printf("%d trials, %d clashed, %d accepted\n", TRIALS, clashed, accepted);
  printf("at the end: %.1f kJ/mol, radius of gyration %.2f nm, %s\n", ctGetPairEnergy(energy), radiusOfGyration(tree),
         clash ? "with a clash" : "no clash");
  printf("sum of all accepted changes: %.1f kJ/mol\n", held);
  ctDestroyEnergy(energy);
  ctDestroy(tree);
  return 0;
}
