/* wholescene.h: random particles with Lennard-Jones, Coulomb and Born parameters, in rigid bodies of random sizes. */
#ifndef WHOLESCENE_H_
#define WHOLESCENE_H_

#include <stdint.h>

#include "../../chaintree/tests/check.h"
#include "../src/wholeenergy.h"
#include "bornoracle.h"

enum { MOST_PARTICLES = 120, MOST_NECKS = 5 };

typedef struct WholeScene {
  int count;
  int linkCount;
  double positions[3 * MOST_PARTICLES];
  double sphereRadii[MOST_PARTICLES];
  int links[MOST_PARTICLES];
  uint8_t listed[MOST_PARTICLES];
  int parents[MOST_PARTICLES];
  uint8_t joints[MOST_PARTICLES];
  int torsions[MOST_PARTICLES][4];
  double charges[MOST_PARTICLES];
  double sigmas[MOST_PARTICLES];
  double epsilons[MOST_PARTICLES];
  int exclusions[MOST_PARTICLES][2];
  double radii[MOST_PARTICLES];
  double offsetRadii[MOST_PARTICLES];
  double scaledRadii[MOST_PARTICLES];
  double alphas[MOST_PARTICLES];
  double betas[MOST_PARTICLES];
  double gammas[MOST_PARTICLES];
  int neckTypes[MOST_PARTICLES];
  double neckHeights[MOST_NECKS * MOST_NECKS];
  double neckDistances[MOST_NECKS * MOST_NECKS];
  ctDefinition definition;
  ctNonbonded nonbonded;
  ctBorn born;
} WholeScene;

static uint64_t chance = 88172645463325252u;

static inline double draw(double low, double high) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return low + (high - low) * ((double)(chance >> 11) * 0x1p-53);
}

static inline int drawInt(int count) {
  return (int)draw(0, count);
}

/* Positions are multiples of 2^-20 nm, so that single precision holds them. On a lattice, so that few are close; in
 * some scenes so wide that distances are large, measured by Born radii. */
static inline void drawPositions(WholeScene* s) {
  const double spacing = draw(0.15, 0.4) * (drawInt(3) == 0 ? 3 : 1);
  int body = 0;
  for (int i = 0; i < s->count; i++) {
    const int places[] = {i % 5, i / 5 % 5, i / 25};
    for (int d = 0; d < 3; d++) {
      s->positions[3 * i + d] = rint((places[d] * spacing + draw(-0.04, 0.04)) * (1 << 20)) / (1 << 20);
    }
    body += i > 0 && drawInt(12) == 0;
    s->links[i] = body;
  }
  s->linkCount = body + 1;
}

static inline void drawParticles(WholeScene* s) {
  const bool isRescaled = s->born.isRescaled;
  for (int i = 0; i < s->count; i++) {
    s->sphereRadii[i] = 0.05;
    s->listed[i] = 1;
    s->parents[i] = -1;
    s->joints[i] = ctFreeJoint;
    s->charges[i] = drawInt(5) == 0 ? 0 : draw(-0.8, 0.8);
    s->sigmas[i] = draw(0.1, 0.3);
    s->epsilons[i] = drawInt(5) == 0 ? 0 : draw(0, 0.6);
    s->exclusions[i][0] = i;
    s->exclusions[i][1] = (i + 1 + drawInt(3)) % s->count;
    s->radii[i] = draw(0.12, 0.18);
    s->offsetRadii[i] = s->radii[i] - 0.0195;
    s->scaledRadii[i] = drawInt(10) == 0 ? -0.11 : draw(0.4, isRescaled ? 1.5 : 0.6) * s->offsetRadii[i];
    s->alphas[i] = draw(0.5, 1);
    s->betas[i] = draw(0.3, 0.9);
    s->gammas[i] = draw(0.1, 4);
    s->neckTypes[i] = drawInt(MOST_NECKS);
  }
}

static inline void drawWholeScene(WholeScene* s) {
  const double cutoff = draw(0.5, 1.2);
  memset(s, 0, sizeof *s);
  s->count = drawInt(20) == 0 ? 1 : 1 + drawInt(MOST_PARTICLES);
  s->born = (ctBorn){.charges = s->charges,
                     .radii = s->radii,
                     .offsetRadii = s->offsetRadii,
                     .scaledRadii = s->scaledRadii,
                     .isFilled = drawInt(2) == 0,
                     .isRescaled = drawInt(3) != 0,
                     .alphas = s->alphas,
                     .betas = s->betas,
                     .gammas = s->gammas,
                     .neckTypeCount = drawInt(2) * MOST_NECKS,
                     .neckTypes = s->neckTypes,
                     .neckHeights = s->neckHeights,
                     .neckDistances = s->neckDistances,
                     .neckScale = 0.826836,
                     .neckCut = 0.68,
                     .coulomb = 138.935485,
                     .soluteDielectric = draw(1, 2),
                     .solventDielectric = draw(20, 80),
                     .kappa = drawInt(2) * draw(0, 2),
                     .surfaceEnergy = drawInt(2) * 28.39,
                     .probeRadius = 0.14,
                     .cutoff = drawInt(2) == 0 ? INFINITY : cutoff,
                     .shift = drawInt(2) * draw(0, 1)};
  for (int i = 0; i < MOST_NECKS * MOST_NECKS; i++) {
    s->neckHeights[i] = draw(0.05, 0.6);
    s->neckDistances[i] = draw(0.22, 0.43);
  }
  drawPositions(s);
  drawParticles(s);
  s->nonbonded = (ctNonbonded){.charges = s->charges,
                               .sigmas = s->sigmas,
                               .epsilons = s->epsilons,
                               .cutoff = drawInt(2) == 0 ? INFINITY : draw(0.5, 1.2),
                               .switchingDistance = drawInt(2) == 0 ? INFINITY : 0.45,
                               .dielectric = 78,
                               .exclusionCount = s->count > 5 ? s->count : 0,
                               .exclusions = (const int(*)[2])s->exclusions};
  s->definition = (ctDefinition){.particleCount = s->count,
                                 .positions = s->positions,
                                 .radii = s->sphereRadii,
                                 .particleLinks = s->links,
                                 .listed = s->listed,
                                 .linkCount = s->linkCount,
                                 .linkParents = s->parents,
                                 .linkJoints = s->joints,
                                 .linkTorsions = (const int(*)[4])s->torsions};
}

static inline ctChainTree* createTree(const WholeScene* s) {
  char text[200] = "";
  ctChainTree* tree;
  if (ctCreate(&s->definition, &tree, text, sizeof text) != ctSuccess) {
    printf("ctCreate: %s\n", text);
    exit(1);
  }
  return tree;
}

static inline void findWholeSlots(const ctChainTree* tree, int* slotOf) {
  static int particles[CT_LEAF_WIDTH * (MOST_PARTICLES + 1)];
  const int count = CT_LEAF_WIDTH * ctGetLeafCount(tree);
  if (count > (int)(sizeof particles / sizeof *particles)) {
    abort();
  }
  ctGetLeafParticles(tree, particles);
  for (int slot = 0; slot < count; slot++) {
    if (particles[slot] != CT_NULL) {
      slotOf[particles[slot]] = slot;
    }
  }
}

#endif /* WHOLESCENE_H_ */
