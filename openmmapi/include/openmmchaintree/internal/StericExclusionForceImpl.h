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
 * This is the internal implementation of StericExclusionForce: its life in one Context.
 *
 * The kernel makes the Scene, which holds the geometry. This class keeps the scene's state and the Context's positions
 * the same and checks arguments. A LimitPolicy decides when limits restart, and a TrialSession runs trials.
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
     * Throw an exception unless initialize() has succeeded. Context::reinitialize() leaves a Context half made if a
     * Force or the Integrator refuses it.
     */
    void requireInitialized() const;
    /**
     * Get what expires when this object is destroyed.
     */
    std::weak_ptr<const void> getLife() const
    {
        return life;
    }
    /**
     * Get what keeps calls on the Context to one thread at a time.
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
     * Get the scene that tests the trials of an integrator and computes their energies: that of the force, or one with
     * other spheres. Only this object and a TrialSession may change its state.
     */
    Scene& getTrialScene()
    {
        return *trialScene;
    }
    /**
     * Set the spheres by which the trials of an integrator are tested; empty: the spheres of the force. If they differ
     * from those before, call this before setEnergyTerms().
     */
    void setTrialSpheres(const CoreSpheres& spheres);
    /**
     * Get whether no spheres of setTrialSpheres() overlap. Until then, trials cannot be tested by them.
     */
    bool trialSpheresAreFree();
    /**
     * Make another scene of the structure that the Context was made with, without a state.
     */
    std::unique_ptr<Scene> createScene() const
    {
        return std::unique_ptr<Scene>(new Scene(*original, *structure));
    }
    /**
     * Give the scene of trials the terms of their energy.
     *
     * @param owner  whose they are; several integrators may drive one force in turns
     */
    void setEnergyTerms(const EnergyTerms& terms, const void* owner);
    /**
     * Get whose terms the scene has, or NULL.
     */
    const void* getOwnerOfEnergyTerms() const
    {
        return energyTermsOwner;
    }

    // The calls of StericExclusionForce. Each first takes notice of the Context's positions.

    bool hasClash(OpenMM::ContextImpl& context);
    void getClashes(OpenMM::ContextImpl& context, std::vector<std::pair<int, int>>& pairs,
                    std::vector<double>& overlaps);
    void getNeighborPairs(OpenMM::ContextImpl& context, double cutoff, std::vector<std::pair<int, int>>& pairs,
                          std::vector<double>& distances);
    double getMinimumDistance(OpenMM::ContextImpl& context, const std::vector<int>& particles1,
                              const std::vector<int>& particles2, int& particle1, int& particle2);
    void getClashesWith(OpenMM::ContextImpl& context, const OpenMM::Vec3& position, double radius,
                        std::vector<int>& particles, std::vector<double>& overlaps);
    bool proposeTorsions(OpenMM::ContextImpl& context, const std::vector<int>& torsions,
                         const std::vector<double>& changes);
    bool proposeBallRotations(OpenMM::ContextImpl& context, const std::vector<int>& ballJoints,
                              const std::vector<OpenMM::Vec3>& rotations);
    bool proposeRigidMotion(OpenMM::ContextImpl& context, int particle, const OpenMM::Vec3& rotation,
                            const OpenMM::Vec3& translation);
    void getProposedPositions(OpenMM::ContextImpl& context, std::vector<OpenMM::Vec3>& positions);
    void getChangedNeighborPairs(OpenMM::ContextImpl& context, double cutoff, std::vector<std::pair<int, int>>& pairs,
                                 std::vector<double>& before, std::vector<double>& after);
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
    /**
     * Get the number of pairs whose limit is not their tolerance.
     */
    int getNumToleratedClashes(OpenMM::ContextImpl& context);

    // The calls of TorsionMonteCarloIntegrator. Its trials are those of a TrialSession.

    /**
     * Get the policy of the limits. They depend on the scene's state, so take notice of the Context's positions first.
     */
    LimitPolicy& getLimitPolicy()
    {
        return limits;
    }
    /**
     * Get what turns the Context's velocities with links.
     */
    VelocityTurner& getVelocityTurner()
    {
        return *velocities;
    }
    /**
     * Restart limits because positions were set, unless this object or a checkpoint has set them.
     *
     * @param restored  the positions that a checkpoint has just restored, or empty if none has
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
     * Write everything that decides how sampling continues, except the open trial and the structure.
     */
    void createCheckpoint(CheckpointWriter& writer);
    /**
     * Throw an exception if loadCheckpoint() could not take over what createCheckpoint() wrote for the same structure.
     */
    void checkCheckpoint(OpenMM::ContextImpl& context, const KeptGeometry& kept) const;
    /**
     * Get whether the Context has the positions of a checkpoint, but for periodic images. Throws an exception if it can
     * only have damaged ones.
     */
    bool havePositionsOf(OpenMM::ContextImpl& context, const KeptGeometry& kept) const;
    /**
     * Use what checkCheckpoint() has checked, in a Context whose positions were restored already.
     */
    void loadCheckpoint(const KeptGeometry& kept);
    /**
     * Take notice of the Context's positions, before a step begins in which Forces may change them.
     */
    void takeNoticeOfPositions(OpenMM::ContextImpl& context);

private:
    friend class TrialSession;
    OpenMM::Kernel createKernel(OpenMM::ContextImpl& context) const;
    void updatePositions(OpenMM::ContextImpl& context);
    void updateState(OpenMM::ContextImpl& context);
    void adoptPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
    bool propose(OpenMM::ContextImpl& context, const Proposal& proposal);
    void requireProposal() const;
    void computeVirtualSites(OpenMM::ContextImpl& context);
    void setContextPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
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
    /** Whether trialSpheresAreFree() has found so since the state was changed by something else than trials. */
    bool trialSpheresWereFree;
    const void* energyTermsOwner;
    LimitPolicy limits;
    std::unique_ptr<VelocityTurner> velocities;
    /** The Context's positions when they and the scene's state were last known to agree; empty before. */
    std::vector<OpenMM::Vec3> agreedPositions;
    std::vector<OpenMM::Vec3> buffer;
    /** Whether the open trial was found to be free of clashes. */
    bool proposalIsFree;
    bool settingPositions, energyIsSuppressed, hasVirtualSites;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_STERICEXCLUSIONFORCEIMPL_H_*/
