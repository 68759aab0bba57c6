/* arm.h: a chain whose geometry is known in closed form. */
#ifndef ARM_H_
#define ARM_H_

#include "check.h"

/* A robot's arm in the plane z = 0. Link 0 holds the shoulder, particle 1, at the origin and particle 0 at (-1, 0, 0).
 * Link l > 0 holds its hand, particle 2 l + 1, at (l, 0, 0), and particle 2 l at unit height over the hand before, from
 * which its axis rises: it turns by the sum of all angles up to its own, counterclockwise. Its dihedral is pi at first.
 */
static inline ctChainTree* makeArm(int links, ctJointKind rootJoint, double radius) {
  const int particles = 2 * links;
  double* positions = calloc((size_t)particles, sizeof(double[3]));
  double* radii = calloc((size_t)particles, sizeof(double));
  int* particleLinks = calloc((size_t)particles, sizeof(int));
  int* parents = calloc((size_t)links, sizeof(int));
  uint8_t* joints = calloc((size_t)links, 1);
  int(*torsions)[4] = calloc((size_t)links, sizeof *torsions);
  if (!positions || !radii || !particleLinks || !parents || !joints || !torsions) {
    abort();
  }
  for (int i = 0; i < particles; i++) {
    const int link = i / 2;
    const bool isHand = i % 2 == 1;
    positions[3 * i] = isHand ? link : link - 1;
    positions[3 * i + 2] = isHand || link == 0 ? 0 : 1;
    radii[i] = radius;
    particleLinks[i] = link;
  }
  for (int link = 0; link < links; link++) {
    const int torsion[4] = {2 * link - 2, 2 * link - 1, 2 * link, 2 * link + 1};
    memcpy(torsions[link], torsion, sizeof torsion);
    parents[link] = link - 1;
    joints[link] = (uint8_t)(link == 0 ? rootJoint : ctTorsionJoint);
  }
  const ctDefinition definition = {.particleCount = particles,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = links,
                                   .linkParents = parents,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions};
  ctChainTree* arm = checkedCreate(&definition);
  free(positions);
  free(radii);
  free(particleLinks);
  free(parents);
  free(joints);
  free(torsions);
  return arm;
}

static inline int armHand(int link) {
  return 2 * link + 1;
}

/* Turns one joint for good. */
static inline void turnArm(ctChainTree* arm, int link, double angle) {
  const ctChange change = {.link = link, .angle = angle};
  CHECK_SUCCESS(ctPropose(arm, 1, &change));
  CHECK_SUCCESS(ctCommit(arm, NULL));
}

#endif /* ARM_H_ */
