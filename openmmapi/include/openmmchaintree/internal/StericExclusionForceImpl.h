#ifndef OPENMM_STERICEXCLUSIONFORCEIMPL_H_
#define OPENMM_STERICEXCLUSIONFORCEIMPL_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/CustomCPPForceImpl.h"
#include "openmm/Kernel.h"
#include "openmmchaintree/ChainTreeKernels.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/ContextLock.h"
#include "openmmchaintree/internal/CoreSpheres.h"
#include "openmmchaintree/internal/KeptGeometry.h"
#include "openmmchaintree/internal/LimitPolicy.h"
#include "openmmchaintree/internal/LinkStructure.h"
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
 * The geometry is the business of a CalcStericExclusionForceKernel. This class keeps the kernel's state and the
 * Context's positions in step and checks arguments. A LimitPolicy decides when limits start anew, and trials are those
 * of a TrialSession. Energy and forces reach every Platform by the way of CustomCPPForceImpl.
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
     * Get the kernel that tests the trials of an integrator and computes their energies: the force's own, or one that
     * has other spheres. Its state is not for others to change.
     */
    CalcStericExclusionForceKernel& getTrialKernel()
    {
        return *trialEngine;
    }
    /**
     * Set the spheres by which the trials of an integrator are tested; if there are none, those of the force. If they
     * are others than before, this comes before setEnergyTerms().
     */
    void setTrialSpheres(const CoreSpheres& spheres, OpenMM::ContextImpl& context);
    /**
     * Get whether no spheres of setTrialSpheres() overlap. Until then, trials cannot be tested by them.
     */
    bool trialSpheresAreFree();
    /**
     * Make one more kernel of the structure that the Context was made with, initialized, without a state.
     */
    OpenMM::Kernel createKernel(OpenMM::ContextImpl& context) const;
    /**
     * Give the kernel the terms of energies of trials.
     *
     * @param owner  whose they are; several integrators may drive one force in turns
     */
    void setEnergyTerms(const EnergyTerms& terms, const void* owner);
    /**
     * Get whose terms the kernel has, or NULL.
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
     * Turn all torsions to given values and start limits anew.
     */
    void setTorsionAngles(OpenMM::ContextImpl& context, const std::vector<double>& angles);
    /**
     * Get the number of pairs whose limit is not their tolerance.
     */
    int getNumToleratedClashes(OpenMM::ContextImpl& context);

    // The calls of TorsionMonteCarloIntegrator. Its trials are those of a TrialSession.

    /**
     * Get the policy of the limits. The kernel's state is theirs, so take notice of the Context's positions first.
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
     * Start limits anew because positions were set, unless it was this object that set them, or a checkpoint.
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
     * Write all that decides how sampling goes on, the open trial and the structure left out.
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
     * Go on from what checkCheckpoint() has found to be good, in a Context whose positions were restored already.
     */
    void loadCheckpoint(const KeptGeometry& kept);
    /**
     * Take notice of the Context's positions, before a step begins in which Forces may change them.
     */
    void takeNoticeOfPositions(OpenMM::ContextImpl& context);

private:
    friend class TrialSession;
    OpenMM::Kernel createKernel(OpenMM::ContextImpl& context, const StericExclusionForce& spheres) const;
    void updatePositions(OpenMM::ContextImpl& context);
    void updateState(OpenMM::ContextImpl& context);
    void adoptPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
    void requireProposal() const;
    void computeVirtualSites(OpenMM::ContextImpl& context);
    void setContextPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
    void showState(OpenMM::ContextImpl& context, CalcStericExclusionForceKernel& shown);
    void setTrialKernel(CalcStericExclusionForceKernel& wanted);
    void bringUpToDate(CalcStericExclusionForceKernel& behind);
    void stateWasChanged(CalcStericExclusionForceKernel& changed);
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
    /** The kernel with the force's spheres, for queries and the trials of users. */
    CalcStericExclusionForceKernel* engine;
    /** A kernel with other spheres, if an integrator has set some, and these. */
    OpenMM::Kernel coreKernel;
    CoreSpheres cores;
    /** The kernel for the trials of integrators: one of the two. */
    CalcStericExclusionForceKernel* trialEngine;
    /** The kernel whose state was changed last, and whether the other one has that state, too. */
    CalcStericExclusionForceKernel* newest;
    bool otherIsBehind;
    /** Whether trialSpheresAreFree() has found so since the state was changed by something else than trials. */
    bool trialSpheresWereFree;
    const void* energyTermsOwner;
    LimitPolicy limits;
    std::unique_ptr<VelocityTurner> velocities;
    /** The Context's positions when they and the kernel's state were last known to agree; empty before. */
    std::vector<OpenMM::Vec3> agreedPositions;
    std::vector<OpenMM::Vec3> buffer;
    /** Whether the open trial was found to be free of clashes. */
    bool proposalIsFree;
    bool settingPositions, energyIsSuppressed, hasVirtualSites;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_STERICEXCLUSIONFORCEIMPL_H_*/
