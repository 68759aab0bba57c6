#ifndef OPENMM_CHAINTREE_TRIALSESSION_H_
#define OPENMM_CHAINTREE_TRIALSESSION_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/Scene.h"
#include <vector>

namespace ChainTreePlugin {

class StericExclusionForceImpl;

/**
 * A TrialSession is a series of trials on the state of a StericExclusionForce, one after another: each is proposed,
 * tested, and accepted or rejected. Trials of TorsionMonteCarloIntegrator and trials that users propose by
 * StericExclusionForce all run in a TrialSession.
 *
 * The session begins and ends with its scope. Until it ends, the scene's state is ahead of the Context's positions and
 * velocities. If an exception ends it, the Context gets the state after the accepted trials.
 */
class TrialSession {
public:
    enum Limits {
        /**
         * A trial clashes if a pair overlaps beyond its limit.
         */
        ApplyLimits,
        /**
         * A trial clashes if spheres of StericExclusionForceImpl::setTrialSpheres() overlap. If some do when the
         * session begins, no trial clashes.
         */
        ApplyTrialSpheres,
        /**
         * No trial clashes. The caller restarts limits if trials of this session may exceed them.
         */
        IgnoreLimits
    };
    /**
     * Take notice of the Context's positions. An open trial of a user remains open until another is proposed.
     *
     * @param scene  the scene of the force for trials of users, getTrialScene() for trials of integrators
     */
    TrialSession(StericExclusionForceImpl& force, OpenMM::ContextImpl& context, Scene& scene, Limits limits);
    TrialSession(const TrialSession&) = delete;
    TrialSession& operator=(const TrialSession&) = delete;
    /**
     * Calls end(), unless it was called.
     */
    ~TrialSession();
    /**
     * Reject the open trial of this session, and move the Context to the state. Nothing may be called afterwards.
     */
    void end();
    /**
     * Keep the trial open when the session ends.
     */
    void leaveOpen();
    /**
     * Propose a trial. This rejects the trial that was open. Returns false, with no trial open, if it scales the
     * periodic box so that this is too narrow for spheres or for the cutoff of a Force; the user is warned once.
     */
    bool propose(const Proposal& proposal);
    /**
     * Test the open trial. Returns true if it is free: no pair whose distance it changes overlaps beyond its limit.
     */
    bool test();
    /**
     * Make the open trial the state. Unless test() has found it free, limits restart from it.
     */
    void accept();
    /**
     * Reject the open trial.
     */
    void reject();
    /**
     * Get the vectors of the periodic box before the open trial, or in it.
     */
    const BoxVectors& getBox() const
    {
        return scene.getBox();
    }
    const BoxVectors& getProposedBox() const
    {
        return scene.getTrialBox();
    }
    /**
     * Get the positions of a few particles before the open trial. Takes O(log N) time for each of them.
     */
    void getPositions(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions) const
    {
        scene.getPositionsOf(particles, positions);
    }
    /**
     * Get the positions of a few particles in the open trial. Takes O(log N) time for each of them and each change.
     */
    void getProposedPositions(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions) const
    {
        scene.getTrialPositionsOf(particles, positions);
    }
    /**
     * Get the centroid of a molecule of the LinkStructure without fixed particles, before the open trial. Takes O(log
     * N) time.
     */
    OpenMM::Vec3 getCentroid(int molecule) const
    {
        return scene.getCentroid(molecule);
    }
    /**
     * Get the value of a torsion before the open trial, in (-pi, pi]. It is an error if it is undefined. Takes constant
     * time.
     */
    double getTorsionAngle(int torsion) const
    {
        return scene.getTorsionAngle(torsion);
    }
    /**
     * Get the energy of the StericExclusionForce before the open trial.
     */
    double computeSoftEnergy();
    /**
     * Get by how much the energy of the StericExclusionForce would change if the open trial became the state.
     */
    double computeSoftEnergyChange()
    {
        return scene.computeSoftEnergyChange();
    }
    /**
     * Move the Context to the open trial, or to the state.
     */
    void showProposal();
    void showState();
    /**
     * Compute the energy of force groups at the Context's positions, leaving out the StericExclusionForce.
     */
    double computeOtherEnergy(int groups);
    /**
     * Save the state, its limits and its energy.
     */
    void save();
    /**
     * Restore the state of the last save(). This rejects the open trial.
     */
    void restore();

private:
    void updateLimits();
    StericExclusionForceImpl& force;
    OpenMM::ContextImpl& context;
    Scene& scene;
    Limits limits;
    /** Whether the open trial, if any, ends with this session. */
    bool ownsTrial;
    /** Whether the Context may not have the positions of the state. */
    bool contextIsBehind;
    /** Whether links may have turned since the session began without the velocities in the Context. */
    bool velocitiesAreBehind;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_TRIALSESSION_H_*/
