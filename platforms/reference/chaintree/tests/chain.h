/* chain.h: chains of any length, each link on the one before. */
#ifndef CHAIN_H_
#define CHAIN_H_

#include "check.h"

/* The arrays of a definition. */
typedef struct Chain {
  int particleCount;
  int linkCount;
  double* positions;
  double* radii;
  int* particleLinks;
  int* parents;
  uint8_t* joints;
  int (*torsions)[4];
  int exclusionCount;
  const int (*exclusions)[2]; /* not the chain's to free */
} Chain;

/* Positions, radii, particles' links and torsions are 0, and there are no exclusions, until they are set. */
static inline Chain allocateChain(int particleCount, int linkCount, ctJointKind rootJoint) {
  const size_t particles = (size_t)particleCount;
  const size_t links = (size_t)linkCount;
  const Chain chain = {.particleCount = particleCount,
                       .linkCount = linkCount,
                       .positions = calloc(particles, sizeof(double[3])),
                       .radii = calloc(particles, sizeof(double)),
                       .particleLinks = calloc(particles, sizeof(int)),
                       .parents = calloc(links, sizeof(int)),
                       .joints = calloc(links, 1),
                       .torsions = calloc(links, sizeof(int[4]))};
  if (!chain.positions || !chain.radii || !chain.particleLinks || !chain.parents || !chain.joints || !chain.torsions) {
    abort();
  }
  for (int link = 0; link < linkCount; link++) {
    chain.parents[link] = link - 1;
    chain.joints[link] = (uint8_t)(link == 0 ? rootJoint : ctTorsionJoint);
  }
  return chain;
}

/* Particle i is all of link i, which turns about the bond between the two before. */
static inline void setBead(const Chain* chain, int i, const double position[3], double radius) {
  const int torsion[4] = {i > 1 ? i - 2 : 0, i - 1, i, i + 1 < chain->linkCount ? i + 1 : i};
  memcpy(chain->positions + 3 * (size_t)i, position, sizeof(double[3]));
  memcpy(chain->torsions[i], torsion, sizeof torsion);
  chain->radii[i] = radius;
  chain->particleLinks[i] = i;
}

/* Whether scenes of chains are flexible. */
static bool chainsAreFlexible = false;

/* Makes a scene of it, and frees it. */
static inline ctChainTree* createChain(const Chain* chain) {
  const ctDefinition definition = {.particleCount = chain->particleCount,
                                   .positions = chain->positions,
                                   .radii = chain->radii,
                                   .particleLinks = chain->particleLinks,
                                   .linkCount = chain->linkCount,
                                   .linkParents = chain->parents,
                                   .linkJoints = chain->joints,
                                   .linkTorsions = (const int(*)[4])chain->torsions,
                                   .exclusionCount = chain->exclusionCount,
                                   .exclusions = chain->exclusions,
                                   .isFlexible = chainsAreFlexible};
  ctChainTree* tree = checkedCreate(&definition);
  free(chain->positions);
  free(chain->radii);
  free(chain->particleLinks);
  free(chain->parents);
  free(chain->joints);
  free(chain->torsions);
  return tree;
}

#endif /* CHAIN_H_ */
