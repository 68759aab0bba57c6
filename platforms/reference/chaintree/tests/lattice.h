/* lattice.h: SIDE x SIDE x SIDE particles at whole coordinates, whose pairs can be counted by hand. */
#ifndef LATTICE_H_
#define LATTICE_H_

#include "check.h"

enum { SIDE = 9, SITES = SIDE * SIDE * SIDE };

/* Which particles make a link. */
typedef enum LatticeLinks {
  ONE_FIXED_LINK,
  LAYERS,         /* each layer of one z a free link */
  ONE_EACH,       /* each particle a free link */
  ONE_CHAIN,      /* one particle a link, each turning about the bond to the one before */
  LAYERED_CHAINS, /* the same, a chain for each layer of one z */
  ROWS_ON_A_WALL  /* the layer x = 0 fixed, and on each of its particles its row along x, turning about it */
} LatticeLinks;

static const int latticeLinkings = ROWS_ON_A_WALL + 1;

/* Sites in the order of a path from neighbour to neighbour. */
static inline void latticeSite(int index, int site[3]) {
  const int z = index / (SIDE * SIDE);
  const int y = index / SIDE % SIDE;
  const int x = index % SIDE;
  const int row = index / SIDE;
  site[0] = row % 2 == 0 ? x : SIDE - 1 - x;
  site[1] = z % 2 == 0 ? y : SIDE - 1 - y;
  site[2] = z;
}

static inline int siteIndex(int x, int y, int z) {
  const int row = z * SIDE + (z % 2 == 0 ? y : SIDE - 1 - y);
  return row * SIDE + (row % 2 == 0 ? x : SIDE - 1 - x);
}

/* Returns the number of links. */
static inline int linkLattice(LatticeLinks kind, int* particleLinks, int* parents, uint8_t* joints,
                              int (*torsions)[4]) {
  const int layer = SIDE * SIDE;
  for (int i = 0; i < SITES; i++) {
    int site[3];
    latticeSite(i, site);
    parents[i] = CT_NULL;
    joints[i] = kind == ONE_FIXED_LINK ? ctFixedJoint : ctFreeJoint;
    particleLinks[i] = kind == ONE_FIXED_LINK ? 0 : kind == LAYERS ? i / layer : i;
    if ((kind == ONE_CHAIN && i > 0) || (kind == LAYERED_CHAINS && i % layer > 0)) {
      const int torsion[4] = {i - 1, i - 1, i, i};
      memcpy(torsions[i], torsion, sizeof torsion);
      parents[i] = i - 1;
      joints[i] = ctTorsionJoint;
    }
    if (kind == ROWS_ON_A_WALL) {
      const int row = 1 + site[2] * SIDE + site[1];
      const int foot = siteIndex(0, site[1], site[2]);
      particleLinks[i] = site[0] == 0 ? 0 : row;
      if (site[0] == 1) {
        const int torsion[4] = {foot, foot, i, i};
        memcpy(torsions[row], torsion, sizeof torsion);
      }
    }
  }
  if (kind == ROWS_ON_A_WALL) {
    for (int link = 0; link <= layer; link++) {
      parents[link] = link == 0 ? CT_NULL : 0;
      joints[link] = link == 0 ? ctFixedJoint : ctTorsionJoint;
    }
    return layer + 1;
  }
  return kind == ONE_FIXED_LINK ? 1 : kind == LAYERS ? SIDE : SITES;
}

/* Whether lattices that are made are flexible. */
static bool areFlexible = false;

static inline ctChainTree* makeLattice(LatticeLinks kind, double radius, double tolerance) {
  static double positions[3 * SITES];
  static double radii[SITES];
  static int particleLinks[SITES];
  static int parents[SITES];
  static uint8_t joints[SITES];
  static int torsions[SITES][4];
  for (int i = 0; i < SITES; i++) {
    int site[3];
    latticeSite(i, site);
    for (int k = 0; k < 3; k++) {
      positions[3 * i + k] = site[k];
    }
    radii[i] = radius;
  }
  const ctDefinition definition = {.particleCount = SITES,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = linkLattice(kind, particleLinks, parents, joints, torsions),
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions,
                                   .overlapTolerance = tolerance,
                                   .isFlexible = areFlexible};
  return checkedCreate(&definition);
}

/* Pairs a unit apart, and those at the roots of two, three and four. */
static inline int latticePairs(int squaredDistance) {
  const int n = SIDE;
  const int pairs[] = {0, 3 * n * n * (n - 1), 6 * n * (n - 1) * (n - 1), 4 * (n - 1) * (n - 1) * (n - 1),
                       3 * n * n * (n - 2)};
  return pairs[squaredDistance];
}

#endif /* LATTICE_H_ */
