#ifndef OPENMM_CHAINTREE_VELOCITYTURNER_H_
#define OPENMM_CHAINTREE_VELOCITYTURNER_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/ChainTreeKernels.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include <array>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class turns the velocities in a Context with the links that trials have turned, so that dynamics may go on from
 * there: v' = R v, R being the rotation of the particle's link from before a series of trials to after it. Where a
 * CMMotionRemover takes the momentum of the System away, the velocities keep it; ctvelocities.h says how, and why it is
 * exact.
 *
 * Kinetic energy stays, and so do constraints within a link and along the axis of a torsion, with the determinant of
 * their Jacobian. Other constraints do not, and then no velocities can be turned: beside dynamics that is an error.
 */
class VelocityTurner {
public:
    VelocityTurner(const OpenMM::System& system, const LinkStructure& structure);
    /**
     * Take notice that no other Integrator than those that make trials are in the Context. Until velocitiesWereSet(),
     * they are taken for 0. If they cannot be turned, the user is warned.
     */
    void expectNoDynamics();
    /**
     * Throw an exception that names the constraint because of which velocities cannot be turned, if there is one.
     */
    void requireTurnable() const;
    /**
     * Take notice that the velocities of the Context were set.
     */
    void velocitiesWereSet();
    /**
     * Get whether there are velocities in the Context.
     */
    bool findVelocities(OpenMM::ContextImpl& context);
    /**
     * Begin a series of trials, before the first of them becomes the state. Throws an exception if there are velocities
     * that cannot be turned.
     */
    void begin(OpenMM::ContextImpl& context, CalcStericExclusionForceKernel& kernel);
    /**
     * End a series: turn the velocities in the Context by what has become of the state since begin().
     */
    void end(OpenMM::ContextImpl& context, CalcStericExclusionForceKernel& kernel);

private:
    bool canBeTurned();
    const std::vector<int> particleLinks;
    std::vector<double> masses;
    bool keepsMomentum;
    /** Why velocities cannot be turned; empty if they can. */
    std::string refusal;
    bool dynamicsIsExpected, mayHaveVelocities, hasWarned;
    /** What begin() has found, if there is anything to turn. */
    bool hasBegun;
    std::vector<OpenMM::Vec3> velocities;
    std::vector<std::array<double, 9>> before, turns;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_VELOCITYTURNER_H_*/
