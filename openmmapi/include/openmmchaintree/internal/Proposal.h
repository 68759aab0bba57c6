#ifndef OPENMM_CHAINTREE_PROPOSAL_H_
#define OPENMM_CHAINTREE_PROPOSAL_H_

#include "openmm/Vec3.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * The changes of a trial, each of another torsion, ball joint or molecule of the LinkStructure.
 */
class Proposal {
public:
    enum Kind { Torsion, BallJoint, Molecule };
    struct Change {
        Kind kind;
        int index;
        double angle;
        OpenMM::Vec3 rotation, translation;
    };
    /**
     * Add to the value of a torsion, in radians.
     */
    Proposal& addTorsion(int torsion, double change)
    {
        changes.push_back({Torsion, torsion, change, OpenMM::Vec3(), OpenMM::Vec3()});
        return *this;
    }
    /**
     * Turn a ball joint about its particle by a rotation vector in the world.
     */
    Proposal& addBallRotation(int ballJoint, const OpenMM::Vec3& rotation)
    {
        changes.push_back({BallJoint, ballJoint, 0, rotation, OpenMM::Vec3()});
        return *this;
    }
    /**
     * Rotate a molecule about its centroid, then translate it.
     */
    Proposal& addRigidMotion(int molecule, const OpenMM::Vec3& rotation, const OpenMM::Vec3& translation)
    {
        changes.push_back({Molecule, molecule, 0, rotation, translation});
        return *this;
    }
    /**
     * Remove all changes. Their memory stays allocated for the next trial.
     */
    void clear()
    {
        changes.clear();
    }
    const std::vector<Change>& getChanges() const
    {
        return changes;
    }

private:
    std::vector<Change> changes;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_PROPOSAL_H_*/
