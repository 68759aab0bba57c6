#ifndef OPENMM_STERICEXCLUSIONFORCEIMPL_H_
#define OPENMM_STERICEXCLUSIONFORCEIMPL_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/CustomCPPForceImpl.h"
#include "openmm/Kernel.h"
#include "openmmchaintree/ChainTreeKernels.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/LinkStructure.h"
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
 * Context's positions in step, decides when limits start anew, and checks arguments. Energy and forces reach every
 * Platform by the way of CustomCPPForceImpl.
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
    // The calls of TorsionMonteCarloIntegrator.

    /**
     * Let limits only grow when the step of an Integrator, or a Force at its beginning, has moved particles. Every
     * other change of positions starts limits anew; the caller says by positionsWereSet() when positions were set.
     * Without this call, steps start limits anew too.
     *
     * @param announced  whether all Integrators of the Context call updateContextState() when they begin a step. If
     *                   not, whatever moves particles in silence may have been one of them.
     */
    void expectDynamics(bool announced);
    /**
     * Start limits anew because positions were set, unless it was this object that set them, or a checkpoint.
     *
     * @param restored  the positions that a checkpoint has just restored, or empty if none has
     */
    void positionsWereSet(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& restored);
    /**
     * Forget all limits; they start anew with the next trial.
     */
    void restartLimits();
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
     * Go on from what createCheckpoint() wrote for the same structure, in a Context whose positions were restored
     * already.
     */
    void loadCheckpoint(CheckpointReader& reader);
    /**
     * Take notice of the Context's positions, before a step begins in which Forces may change them.
     */
    void takeNoticeOfPositions(OpenMM::ContextImpl& context);
    /**
     * Take notice of the Context's positions, drop the open trial, and bring limits up to date. From now on trials may
     * be proposed, accepted and rejected by the kernel alone, until finishTrials() is called.
     */
    void beginTrials(OpenMM::ContextImpl& context);
    /**
     * The same for trials that know no limits: there are none afterwards.
     */
    void beginTrialsWithoutLimits(OpenMM::ContextImpl& context);
    /**
     * Throw an exception that names the first pair whose limit is not its tolerance, if there is one.
     */
    void refuseToleratedClashes();
    /**
     * Get the kernel, for trials between beginTrials() and finishTrials().
     */
    CalcStericExclusionForceKernel& getKernel()
    {
        return *engine;
    }
    /**
     * Give the Context the positions of the open trial, so that its energy can be computed. The trial stays open.
     */
    void showProposal(OpenMM::ContextImpl& context);
    /**
     * Compute the energy of force groups at the Context's positions, leaving out this force.
     */
    double computeOtherEnergy(OpenMM::ContextImpl& context, int groups);
    /**
     * Drop the open trial and move the Context to the kernel's state.
     */
    void finishTrials(OpenMM::ContextImpl& context);

private:
    void updatePositions(OpenMM::ContextImpl& context);
    void adoptPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
    void prepareTrial(OpenMM::ContextImpl& context);
    bool testProposal();
    void requireProposal() const;
    void computeVirtualSites(OpenMM::ContextImpl& context);
    void setContextPositions(OpenMM::ContextImpl& context, const std::vector<OpenMM::Vec3>& positions);
    void showState(OpenMM::ContextImpl& context);
    const StericExclusionForce& owner;
    const std::shared_ptr<const void> life;
    bool isInitialized;
    /** The force as it was when the Context was created. */
    std::unique_ptr<StericExclusionForce> original;
    std::unique_ptr<LinkStructure> structure;
    OpenMM::Kernel kernel;
    CalcStericExclusionForceKernel* engine;
    /** The Context's positions when they and the kernel's state were last known to agree; empty before. */
    std::vector<OpenMM::Vec3> agreedPositions;
    std::vector<OpenMM::Vec3> buffer;
    /** The step count at which the last step began whose changes of positions may not all have been seen, or NO_STEP.
     *  Positions that differ without such a step were changed between steps: by the minimizer, of which OpenMM tells
     *  nothing on GPU platforms, or by Context::applyConstraints(). */
    long long stepBegun;
    bool limitsAreCurrent, dynamicsIsExpected, stepsAreAnnounced, settingPositions, energyIsSuppressed;
    bool proposalIsFree, hasVirtualSites;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_STERICEXCLUSIONFORCEIMPL_H_*/
