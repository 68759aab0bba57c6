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
 * Turns the velocities in a Context with the links that trials have turned, so that dynamics can continue: v' = R v,
 * where R is the rotation of the particle's link by a series of trials. If the System has a CMMotionRemover, the turned
 * velocities keep the momentum; ctvelocities.h explains the method.
 *
 * Most integrators keep the velocities of half a step before the positions, which depend on the forces there. So when
 * dynamics resumes, the velocities are also rotated from the turned accelerations at the pause to the accelerations at
 * the resumption; see ctvelocities.h. This takes two evaluations of forces per change between dynamics and trials.
 * Sampling is exact without it, but each change would heat the System, in second order of the time step.
 *
 * This keeps the kinetic energy, and constraints within a link and along the axis of a torsion with the determinant of
 * their Jacobian. With other constraints, velocities cannot be turned, which is an error beside dynamics.
 */
class VelocityTurner {
public:
    VelocityTurner(const OpenMM::System& system, const LinkStructure& structure);
    /**
     * Take notice that all Integrators in the Context make trials. Until velocitiesWereSet(), velocities are taken for
     * 0. If they cannot be turned, the user is warned.
     */
    void expectNoDynamics();
    /**
     * Throw an exception if a constraint, which it names, prevents turning velocities.
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
     * Take notice that steps of trials begin: dynamics may pause here.
     */
    void pauseDynamics(OpenMM::ContextImpl& context);
    /**
     * Set whether the step that an Integrator is about to begin consists of trials.
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
     * Forget the pause of dynamics.
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
     * End a series: turn the velocities in the Context by the rotations since begin().
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
    /** Accelerations at the pause of dynamics, in any unit, turned with the links since. */
    bool hasPaused;
    std::vector<OpenMM::Vec3> push;
    /** The velocities and orientations at begin(), if there are velocities to turn. */
    bool hasBegun;
    std::vector<OpenMM::Vec3> velocities;
    mutable std::vector<std::array<double, 9>> before, turns;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_VELOCITYTURNER_H_*/
