#ifndef OPENMM_CHAINTREE_VELOCITYTURNER_H_
#define OPENMM_CHAINTREE_VELOCITYTURNER_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Scene.h"
#include <array>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class turns the velocities in a Context with the links that trials have turned, so that dynamics can continue
 * from there: v' = R v, R being the rotation of the particle's link from before a series of trials to after it. Where a
 * CMMotionRemover takes the momentum of the System away, the velocities keep it; ctvelocities.h says how, and why it is
 * exact.
 *
 * Most integrators keep velocities of half a step before the positions, which depend on the forces there. So when
 * dynamics resumes, the velocities are also rotated from the accelerations where it paused, turned with the links, to
 * those where it resumes; ctvelocities.h says how. That takes two evaluations of forces for each turn of the two, and
 * is as exact as leaving it out: it only avoids the heat that each such turn would else bring, of the second order in
 * the time step.
 *
 * Kinetic energy stays, and so do constraints within a link and along the axis of a torsion, with the determinant of
 * their Jacobian. Other constraints do not, and then no velocities can be turned: beside dynamics that is an error.
 */
class VelocityTurner {
public:
    VelocityTurner(const OpenMM::System& system, const LinkStructure& structure);
    /**
     * Take notice that all Integrators in the Context make trials. Until velocitiesWereSet(),
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
     * Take notice that steps of trials begin, where dynamics may have paused.
     */
    void pauseDynamics(OpenMM::ContextImpl& context);
    /**
     * Take notice that an Integrator is about to begin a step, and whether it is one of trials.
     */
    void announceStep(bool isOfTrials)
    {
        trialsFollow = isOfTrials;
    }
    /**
     * Take notice that an Integrator begins a step. Returns whether that has changed velocities.
     */
    bool beginStep(OpenMM::ContextImpl& context);
    /**
     * Forget where dynamics has paused.
     */
    void forgetPause()
    {
        hasPaused = false;
    }
    /**
     * Begin a series of trials, before the first of them becomes the state. Throws an exception if there are velocities
     * that cannot be turned.
     */
    void begin(OpenMM::ContextImpl& context, Scene& scene);
    /**
     * End a series: turn the velocities in the Context by what has become of the state since begin().
     */
    void end(OpenMM::ContextImpl& context, Scene& scene);

private:
    bool canBeTurned();
    bool computePush(OpenMM::ContextImpl& context, std::vector<OpenMM::Vec3>& push);
    void setVelocities(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& values);
    void turn(std::vector<OpenMM::Vec3>& vectors) const;
    const std::vector<int> particleLinks;
    std::vector<double> masses;
    bool hasConstraints, keepsMomentum;
    /** Why velocities cannot be turned; empty if they can. */
    std::string refusal;
    bool dynamicsIsExpected, mayHaveVelocities, hasWarned, isSetting, trialsFollow;
    /** Accelerations where dynamics has paused, in any unit, turned with the links since. */
    bool hasPaused;
    std::vector<OpenMM::Vec3> push;
    /** What begin() has found, if there is anything to turn. */
    bool hasBegun;
    std::vector<OpenMM::Vec3> velocities;
    mutable std::vector<std::array<double, 9>> before, turns;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_VELOCITYTURNER_H_*/
