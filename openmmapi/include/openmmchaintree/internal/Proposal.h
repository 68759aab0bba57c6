#ifndef OPENMM_CHAINTREE_PROPOSAL_H_
#define OPENMM_CHAINTREE_PROPOSAL_H_

#include "openmm/Vec3.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * The changes of a trial: each of another torsion, ball joint or molecule of the LinkStructure; or displacements, each
 * of another particle; or the scaling of the periodic box. A trial is of one of these three.
 */
class Proposal {
public:
    enum Kind { Torsion, BallJoint, Molecule };
    struct Change {
        Kind kind = Torsion;
        int index = 0;
        double angle = 0;
        OpenMM::Vec3 rotation, translation;
    };
    /**
     * Add to the value of a torsion, in radians.
     */
    Proposal& addTorsion(int torsion, double change)
    {
        add(Torsion, torsion).angle = change;
        return *this;
    }
    /**
     * Turn a ball joint about its particle by a rotation vector in the world.
     */
    Proposal& addBallRotation(int ballJoint, const OpenMM::Vec3& rotation)
    {
        add(BallJoint, ballJoint).rotation = rotation;
        return *this;
    }
    /**
     * Rotate a molecule about its centroid, then translate it.
     */
    Proposal& addRigidMotion(int molecule, const OpenMM::Vec3& rotation, const OpenMM::Vec3& translation)
    {
        Change& change = add(Molecule, molecule);
        change.rotation = rotation;
        change.translation = translation;
        return *this;
    }
    /** A particle, and by how much it moves in the world, in nm. */
    struct Displacement {
        int particle;
        OpenMM::Vec3 shift;
    };
    /**
     * Displace a particle, which all others do not follow. This needs a flexible LinkStructure.
     */
    Proposal& addDisplacement(int particle, const OpenMM::Vec3& shift)
    {
        displacements.push_back({particle, shift});
        return *this;
    }
    /**
     * Multiply the vectors of the periodic box, and the centroid of each molecule, which moves as a rigid body.
     */
    Proposal& scaleBox(double factor)
    {
        boxFactor = factor;
        return *this;
    }
    /**
     * Get the factor of the periodic box; 1 if it keeps its vectors.
     */
    double getBoxFactor() const
    {
        return boxFactor;
    }
    /**
     * Remove all changes. Their memory stays allocated for the next trial.
     */
    void clear()
    {
        changes.clear();
        displacements.clear();
        boxFactor = 1;
    }
    const std::vector<Change>& getChanges() const
    {
        return changes;
    }
    const std::vector<Displacement>& getDisplacements() const
    {
        return displacements;
    }

private:
    /**
     * Add a change in place: a processor waits for whole loads of what was just stored in parts, as a copy would do.
     */
    Change& add(Kind kind, int index)
    {
        Change& change = changes.emplace_back();
        change.kind = kind;
        change.index = index;
        return change;
    }
    std::vector<Change> changes;
    std::vector<Displacement> displacements;
    double boxFactor = 1;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_PROPOSAL_H_*/
