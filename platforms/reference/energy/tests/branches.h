/* branches.h: random scenes of branched molecules, with parts that are fixed and roots that are free. */
#ifndef BRANCHES_H_
#define BRANCHES_H_

#include <stdint.h>

#include "../../chaintree/tests/check.h"

enum { MOST_ATOMS = 400 };

/* What a definition points to; each atom but the first of a molecule is bonded to one before it. */
typedef struct Branches {
  int atomCount;
  int bondedTo[MOST_ATOMS]; /* CT_NULL: first of its molecule */
  double positions[3 * MOST_ATOMS];
  double radii[MOST_ATOMS];
  int links[MOST_ATOMS];
  int linkCount;
  int parents[MOST_ATOMS];
  uint8_t joints[MOST_ATOMS];
  int torsions[MOST_ATOMS][4];
  bool isFlexible;
  uint64_t chance;
} Branches;

static inline double drawReal(Branches* b) {
  b->chance ^= b->chance << 13;
  b->chance ^= b->chance >> 7;
  b->chance ^= b->chance << 17;
  return (double)(b->chance >> 11) * 0x1p-53;
}

static inline int drawBelow(Branches* b, int end) {
  return (int)(drawReal(b) * end);
}

/* 0.15 nm from another atom, in any direction. */
static inline void placeAtom(Branches* b, int atom, const double from[3]) {
  double v[3];
  double squared;
  do {
    squared = 0;
    for (int d = 0; d < 3; d++) {
      v[d] = 2 * drawReal(b) - 1;
      squared += v[d] * v[d];
    }
  } while (squared > 1 || squared < 0.01);
  for (int d = 0; d < 3; d++) {
    b->positions[3 * atom + d] = from[d] + 0.15 * v[d] / sqrt(squared);
  }
}

/* The bond to an atom becomes a torsion, written from either end. The outer particles are any. */
static inline void addTorsionLink(Branches* b, int first, int atom) {
  const int link = b->linkCount++;
  const int isReversed = drawBelow(b, 2);
  int outer[2];
  for (int i = 0; i < 2; i++) {
    do {
      outer[i] = first + drawBelow(b, atom - first + 3);
    } while (outer[i] == atom || outer[i] == b->bondedTo[atom] || (i == 1 && outer[1] == outer[0]));
  }
  b->links[atom] = link;
  b->parents[link] = b->links[b->bondedTo[atom]];
  b->joints[link] = ctTorsionJoint;
  b->torsions[link][0] = outer[isReversed];
  b->torsions[link][1 + isReversed] = b->bondedTo[atom];
  b->torsions[link][2 - isReversed] = atom;
  b->torsions[link][3] = outer[1 - isReversed];
}

/* Adds a molecule of `size` > 3 atoms. `rootJoint` free: on the world or on any link before. `branching`: how often an
 * atom is not bonded to the one before it; `torsions`: how often a bond turns. */
static inline void addMolecule(Branches* b, int size, ctJointKind rootJoint, double branching, double torsions) {
  const int first = b->atomCount;
  const double origin[3] = {3 * drawReal(b), 3 * drawReal(b), 3 * drawReal(b)};
  const int root = b->linkCount++;
  b->joints[root] = (uint8_t)rootJoint;
  b->parents[root] = rootJoint == ctFreeJoint && root > 0 && drawBelow(b, 2) ? drawBelow(b, root) : CT_NULL;
  for (int atom = first; atom < first + size; atom++) {
    b->bondedTo[atom] = atom == first             ? CT_NULL
                        : drawReal(b) < branching ? first + drawBelow(b, atom - first)
                                                  : atom - 1;
    placeAtom(b, atom, atom == first ? origin : b->positions + 3 * b->bondedTo[atom]);
    b->links[atom] = atom == first ? root : b->links[b->bondedTo[atom]];
    if (atom > first && atom < first + size - 3 && drawReal(b) < torsions) {
      addTorsionLink(b, first, atom);
    }
    b->radii[atom] = drawBelow(b, 4) == 0 ? 0 : 0.1;
  }
  b->atomCount += size;
}

static inline ctDefinition describeBranches(const Branches* b) {
  return (ctDefinition){.particleCount = b->atomCount,
                        .positions = b->positions,
                        .radii = b->radii,
                        .particleLinks = b->links,
                        .linkCount = b->linkCount,
                        .linkParents = b->parents,
                        .linkJoints = b->joints,
                        .linkTorsions = (const int(*)[4])b->torsions,
                        .isFlexible = b->isFlexible};
}

static inline bool isFixed(const Branches* b, int atom) {
  return b->joints[b->links[atom]] == ctFixedJoint;
}

/* Whether a particle stands in a leaf. */
static inline bool hasSlot(const Branches* b, int atom) {
  return b->radii[atom] > 0;
}

/* Any change of a joint. */
static inline ctChange drawChange(Branches* b, int link) {
  ctChange change = {.link = link};
  if (b->joints[link] == ctTorsionJoint) {
    change.angle = drawBelow(b, 4) == 0 ? PI * (2 * drawReal(b) - 1) : 0.2 * (drawReal(b) - 0.5);
    return change;
  }
  for (int d = 0; d < 3; d++) {
    change.rotation[d] = drawReal(b) - 0.5;
    change.pivot[d] = 3 * drawReal(b);
    change.translation[d] = 0.2 * (drawReal(b) - 0.5);
  }
  return change;
}

enum { MOST_DISPLACED = 4 };

/* Displacements of different particles that are not fixed, some by the same shift; returns how many. */
static inline int drawDisplacements(Branches* b, double size, ctDisplacement* displacements) {
  const int wanted = 1 + drawBelow(b, MOST_DISPLACED);
  const int first = drawBelow(b, b->atomCount);
  int count = 0;
  for (int attempt = 0; attempt < 100 && count < wanted; attempt++) {
    /* Mostly neighbours, in either order. */
    const int atom = drawBelow(b, 2) == 0 ? drawBelow(b, b->atomCount) : (first + drawBelow(b, 6)) % b->atomCount;
    bool isNew = !isFixed(b, atom);
    for (int i = 0; i < count; i++) {
      isNew = isNew && displacements[i].particle != atom;
    }
    if (!isNew) {
      continue;
    }
    ctDisplacement* d = &displacements[count++];
    d->particle = atom;
    for (int k = 0; k < 3; k++) {
      d->shift[k] = count > 1 && drawBelow(b, 2) == 0 ? displacements[0].shift[k] : size * (2 * drawReal(b) - 1);
    }
  }
  return count;
}

#endif /* BRANCHES_H_ */
