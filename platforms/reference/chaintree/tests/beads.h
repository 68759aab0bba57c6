/* beads.h: scenes of single beads, each a free link. */
#ifndef BEADS_H_
#define BEADS_H_

#include "check.h"

enum { MOST_BEADS = 64 };

typedef struct Beads {
  int count;
  double positions[3 * MOST_BEADS];
  double radii[MOST_BEADS];
  const uint8_t* roles;
  int exclusionCount;
  const int (*exclusions)[2];
  double tolerance;
  double allowance;
} Beads;

static inline ctChainTree* makeBeads(const Beads* beads) {
  int links[MOST_BEADS];
  int parents[MOST_BEADS];
  uint8_t joints[MOST_BEADS];
  for (int i = 0; i < beads->count; i++) {
    links[i] = i;
    parents[i] = CT_NULL;
    joints[i] = ctFreeJoint;
  }
  const ctDefinition definition = {.particleCount = beads->count,
                                   .positions = beads->positions,
                                   .radii = beads->radii,
                                   .hydrogenBondRoles = beads->roles,
                                   .particleLinks = links,
                                   .linkCount = beads->count,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .exclusionCount = beads->exclusionCount,
                                   .exclusions = beads->exclusions,
                                   .overlapTolerance = beads->tolerance,
                                   .hydrogenBondAllowance = beads->allowance};
  return checkedCreate(&definition);
}

/* Opens a trial that shifts a link along x, and returns whether it clashes. */
static inline bool clashesShifted(ctChainTree* tree, int link, double x) {
  const ctChange change = {.link = link, .translation = {x, 0, 0}};
  bool clash = false;
  CHECK_SUCCESS(ctPropose(tree, 1, &change));
  CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
  return clash;
}

static inline void shift(ctChainTree* tree, int link, double x) {
  clashesShifted(tree, link, x);
  CHECK_SUCCESS(ctAccept(tree, NULL));
}

/* Whether two beads are listed as a clash. */
static inline bool isListed(ctChainTree* tree, int i, int j) {
  PairCount pairs = {0};
  CHECK_SUCCESS(ctForEachClash(tree, countPair, &pairs, NULL));
  return pairs.count == 1 && pairs.pair[0] == i && pairs.pair[1] == j;
}

#endif /* BEADS_H_ */
