/* arm.h: a chain whose geometry is known in closed form. */
#ifndef ARM_H_
#define ARM_H_

#include "chain.h"

/* A robot's arm in the plane z = 0. Link 0 holds the shoulder, particle 1, at the origin and particle 0 at (-1, 0, 0).
 * Link l > 0 holds its hand, particle 2 l + 1, at (l, 0, 0), and particle 2 l at unit height over the hand before, from
 * which its axis rises: it turns by the sum of all angles up to its own, counterclockwise. Its dihedral is pi at first.
 */
static inline ctChainTree* makeArm(int links, ctJointKind rootJoint, double radius) {
  const Chain chain = allocateChain(2 * links, links, rootJoint);
  for (int i = 0; i < chain.particleCount; i++) {
    const int link = i / 2;
    const bool isHand = i % 2 == 1;
    chain.positions[3 * i] = isHand ? link : link - 1;
    chain.positions[3 * i + 2] = isHand || link == 0 ? 0 : 1;
    chain.radii[i] = radius;
    chain.particleLinks[i] = link;
  }
  for (int link = 0; link < links; link++) {
    const int torsion[4] = {2 * link - 2, 2 * link - 1, 2 * link, 2 * link + 1};
    memcpy(chain.torsions[link], torsion, sizeof torsion);
  }
  return createChain(&chain);
}

static inline int armHand(int link) {
  return 2 * link + 1;
}

/* Turns one joint for good. */
static inline void turnArm(ctChainTree* arm, int link, double angle) {
  const ctChange change = {.link = link, .angle = angle};
  CHECK_SUCCESS(ctPropose(arm, 1, &change));
  CHECK_SUCCESS(ctAccept(arm, NULL));
}

#endif /* ARM_H_ */
