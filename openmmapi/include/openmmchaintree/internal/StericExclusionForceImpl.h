#ifndef OPENMM_STERICEXCLUSIONFORCEIMPL_H_
#define OPENMM_STERICEXCLUSIONFORCEIMPL_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/CustomCPPForceImpl.h"
#include "openmm/Kernel.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/ContextLock.h"
#include "openmmchaintree/internal/CoreSpheres.h"
#include "openmmchaintree/internal/KeptGeometry.h"
#include "openmmchaintree/internal/LimitPolicy.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Scene.h"
#include "openmmchaintree/internal/VelocityTurner.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <memory>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * The internal implementation of StericExclusionForce in one Context.
 *
 * The kernel makes the Scene, which holds the geometry. This class keeps the scene's state and the Context's positions
 * equal, and checks arguments. A LimitPolicy decides when limits restart, and a TrialSession runs trials.
 * CustomCPPForceImpl brings energy and forces to every Platform.
 */
class OPENMM_EXPORT_CHAINTREE StericExclusionForceImpl : public OpenMM::CustomCPPForceImpl {
public:
    explicit StericExclusionForceImpl(const StericExclusionForce& owner);
    void initialize(OpenMM::ContextImpl& context);
    const StericExclusionForce& getOwner() const
    {
        return owner;
    }
    /**
     * Throw an exception unless initialize() has succeeded. Context::reinitialize() leaves an incomplete Context if a
     * Force or the Integrator throws an exception.
     */
    void requireInitialized() const;
    /**
     * Get a pointer that expires when this object is destroyed.
     */
    std::weak_ptr<const void> getLife() const
    {
        return life;
    }
    /**
     * Get the lock that lets one thread at a time use the Context.
     */
    const std::shared_ptr<ContextLock>& getLock() const
    {
        return lock;
    }
    double calcForcesAndEnergy(OpenMM::ContextImpl& context, bool includeForces, bool includeEnergy, int groups);
    double computeForce(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions,
                        std::vector<OpenMM::Vec3>& forces);
    /**
     * Integrators call this when a step begins.
     */
    void updateContextState(OpenMM::ContextImpl& context, bool& forcesInvalid);
    std::vector<std::pair<int, int>> getBondedParticles() const;
    void updateParametersInContext(OpenMM::ContextImpl& context);
    const LinkStructure& getLinkStructure() const
    {
        return *structure;
    }
    /**
     * Get the scene that tests the trials of an integrator and computes their energies: the force's own, or one with
     * other spheres. Only this object and a TrialSession may change its state.
     */
    Scene& getTrialScene()
    {
        return *trialScene;
    }
    /**
     * Set the spheres that test the trials of an integrator; empty: the spheres of the force. Call this before
     * setEnergyTerms().
     */
    void setTrialSpheres(const CoreSpheres& spheres);
    /**
     * Get whether there are spheres of setTrialSpheres() and none overlap. Until then, they cannot test trials.
     */
    bool trialSpheresAreFree();
    /**
     * Get numbers that two Contexts share if, and only if, a state of the one can be a state of the other.
     */
    std::vector<int> describeStructure() const;
    /**
     * Make another scene of the force as it was when the Context was created, in the same box, without positions.
     */
    std::unique_ptr<Scene> createScene() const
    {
        return createScene(*original);
    }
    /**
     * Give the scene of trials the terms of their energy.
     *
     * @param owner  the integrator that sets them; several integrators may use one force in turns
     */
    void setEnergyTerms(const EnergyTerms& terms, const void* owner);
    /**
     * Get the owner of the scene's terms, or NULL.
     */
    const void* getOwnerOfEnergyTerms() const
    {
        return energyTermsOwner;
    }

    // The calls of StericExclusionForce. Each first takes notice of the Context's positions.

    /**
     * Get the scene with the force's spheres, for queries about the Context's positions.
     */
    Scene& queryState(OpenMM::ContextImpl& context);
    /**
     * Get the same for queries about the open trial of a user. It is an error if there is none.
     */
    Scene& queryTrial(OpenMM::ContextImpl& context);
    bool proposeTorsions(OpenMM::ContextImpl& context, const std::vector<int>& torsions,
                         const std::vector<double>& changes);
    bool proposeBallRotations(OpenMM::ContextImpl& context, const std::vector<int>& ballJoints,
                              const std::vector<OpenMM::Vec3>& rotations);
    bool proposeRigidMotion(OpenMM::ContextImpl& context, int particle, const OpenMM::Vec3& rotation,
                            const OpenMM::Vec3& translation);
    void acceptProposal(OpenMM::ContextImpl& context);
    void rejectProposal();
    void getTraversalStatistics(long long& queries, long long& volumeTests, long long& particleTests,
                                long long& nodesUpdated);
    void resetTraversalStatistics();

    /**
     * Get the values of all torsions, in (-pi, pi].
     */
    void getTorsionAngles(OpenMM::ContextImpl& context, std::vector<double>& angles);
    /**
     * Turn all torsions to given values and restart limits.
     */
    void setTorsionAngles(OpenMM::ContextImpl& context, const std::vector<double>& angles);
    // The calls of TorsionMonteCarloIntegrator. Its trials are those of a TrialSession.

    /**
     * Get the policy of the limits. They depend on the scene's state, so take notice of the Context's positions first.
     */
    LimitPolicy& getLimitPolicy()
    {
        return limits;
    }
    /**
     * Get the VelocityTurner of the Context.
     */
    VelocityTurner& getVelocityTurner()
    {
        return *velocities;
    }
    /**
     * Restart limits if the user has set positions, not this object or a checkpoint.
     *
     * @param restored  the positions that a checkpoint has just restored, or empty
     */
    void positionsWereSet(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& restored);
    /**
     * Get the pairs whose limit is not their tolerance, and these limits.
     */
    void getLimits(std::vector<std::pair<int, int>>& pairs, std::vector<double>& limits);
    /**
     * Set all limits. They may still grow at the next trial.
     */
    void setLimits(OpenMM::ContextImpl& context, const std::vector<std::pair<int, int>>& pairs,
                   const std::vector<double>& limits);
    /**
     * Write everything on which further sampling depends, except the open trial and the structure.
     */
    void createCheckpoint(CheckpointWriter& writer);
    /**
     * Throw an exception if loadCheckpoint() could not use the geometry of a checkpoint.
     */
    void checkCheckpoint(OpenMM::ContextImpl& context, const KeptGeometry& kept) const;
    /**
     * Get whether the Context has the positions of a checkpoint, up to periodic images. Throws an exception if its
     * positions are damaged.
     */
    bool havePositionsOf(OpenMM::ContextImpl& context, const KeptGeometry& kept) const;
    /**
     * Use the geometry of a checkpoint that checkCheckpoint() has checked, in a Context whose positions are restored
     * already.
     */
    void loadCheckpoint(const KeptGeometry& kept);
    /**
     * Take notice of the Context's positions, before a step begins in which Forces may change them.
     */
    void takeNoticeOfPositions(OpenMM::ContextImpl& context);

private:
    friend class TrialSession;
    OpenMM::Kernel createKernel(OpenMM::ContextImpl& context) const;
    std::unique_ptr<Scene> createScene(const StericExclusionForce& spheres) const;
    void updatePositions(OpenMM::ContextImpl& context);
    void adoptPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
    bool propose(OpenMM::ContextImpl& context, const Proposal& proposal);
    void requireProposal() const;
    void computeVirtualSites(OpenMM::ContextImpl& context);
    void setContextPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions,
                             const BoxVectors& box);
    bool mayScaleBox(const Scene& scaled, double factor) const;
    void warnOfNarrowBox();
    void showState(OpenMM::ContextImpl& context, Scene& shown);
    void setTrialScene(Scene& wanted);
    void bringUpToDate(Scene& behind);
    void stateWasChanged(Scene& changed);
    bool hasEnergy(OpenMM::ContextImpl& context) const;
    double computeOtherEnergy(OpenMM::ContextImpl& context, int groups);
    const StericExclusionForce& owner;
    const std::shared_ptr<const void> life;
    const std::shared_ptr<ContextLock> lock;
    bool isInitialized;
    /** The force as it was when the Context was created. */
    std::unique_ptr<StericExclusionForce> original;
    std::unique_ptr<LinkStructure> structure;
    OpenMM::Kernel kernel;
    /** The kernel's scene with the force's spheres, for queries and the trials of users. */
    Scene* scene;
    /** A scene with other spheres, if an integrator has set some, and these spheres. */
    std::unique_ptr<Scene> coreScene;
    CoreSpheres cores;
    /** The scene for the trials of integrators: one of the two. */
    Scene* trialScene;
    /** The scene whose state was changed last, and whether the other one lacks that state. */
    Scene* newest;
    bool otherIsBehind;
    /** Whether trialSpheresAreFree() was true since something other than trials changed the state. */
    bool trialSpheresWereFree;
    const void* energyTermsOwner;
    LimitPolicy limits;
    std::unique_ptr<VelocityTurner> velocities;
    /** The Context's positions when they and the scene's state were last known to agree; empty before. The box that the
     *  Context had then is that of the newest scene. */
    std::vector<OpenMM::Vec3> agreedPositions;
    std::vector<OpenMM::Vec3> buffer;
    /** Whether the open trial was found to be free of clashes. */
    bool proposalIsFree;
    bool settingPositions, energyIsSuppressed, hasVirtualSites;
    /** The least width of a periodic box for the cutoffs of all Forces, in nm. */
    double leastBoxWidth;
    bool hasWarnedOfNarrowBox;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_STERICEXCLUSIONFORCEIMPL_H_*/
