#ifndef OPENMM_CHAINTREE_FREECHAIN_H_
#define OPENMM_CHAINTREE_FREECHAIN_H_

/**
 * Chains of beads that turn freely at each bond, and random directions that owe nothing to the plugin.
 */

#include "TestSupport.h"
#include <random>

namespace ChainTreePlugin {

/**
 * Beads in a row, 1 nm apart, with a ball joint for each bond: joint i turns what is behind bead i about it. They begin
 * as a flight of stairs, four a turn. Exclusions reach over a number of bonds, and no overlap is tolerated.
 */
class FreeChain {
public:
    FreeChain(int length, double radius, int bondCutoff = 1) : force(new StericExclusionForce())
    {
        system.addForce(force);
        force->setOverlapTolerance(0);
        OpenMM::Vec3 position;
        for (int i = 0; i < length; i++) {
            system.addParticle(1);
            force->addParticle(radius);
            positions.push_back(position);
            position += i % 2 == 0 ? OpenMM::Vec3(0.6, 0, 0.8) : OpenMM::Vec3(0, i % 4 == 1 ? 0.6 : -0.6, 0.8);
            if (i > 0) {
                force->addBond(i - 1, i);
                force->addBallJoint(i - 1, i);
            }
        }
        force->createExclusionsFromBonds(bondCutoff);
    }
    /**
     * Draw the positions of a chain of which each bond has any direction.
     */
    std::vector<OpenMM::Vec3> drawPositions(std::mt19937_64& random) const
    {
        std::uniform_real_distribution<double> uniform(-1, 1);
        std::vector<OpenMM::Vec3> drawn(1, positions[0]);
        while (drawn.size() < positions.size()) {
            const double z = uniform(random), angle = M_PI * uniform(random), r = std::sqrt(1 - z * z);
            drawn.push_back(drawn.back() + OpenMM::Vec3(r * std::cos(angle), r * std::sin(angle), z));
        }
        return drawn;
    }
    OpenMM::System system;
    StericExclusionForce* force;
    std::vector<OpenMM::Vec3> positions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FREECHAIN_H_*/
