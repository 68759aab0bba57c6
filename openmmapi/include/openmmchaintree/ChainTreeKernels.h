#ifndef OPENMM_CHAINTREEKERNELS_H_
#define OPENMM_CHAINTREEKERNELS_H_

#include "openmm/KernelImpl.h"
#include "openmm/Platform.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * This kernel is invoked by StericExclusionForceImpl for everything that has to do with geometry. It holds the state:
 * the positions, the open trial, and the limits of pairs.
 *
 * It exchanges nothing but host arrays and never looks into a Context, so that a Context of any Platform can use the
 * kernel of the Reference platform. Indices of torsions and molecules, and what is proposed for them, were checked by
 * the caller, who knows their names; the kernel checks all else. Errors are thrown as OpenMMException and leave the
 * state as it was.
 */
class CalcStericExclusionForceKernel : public OpenMM::KernelImpl {
public:
    static std::string Name()
    {
        return "CalcStericExclusionForce";
    }
    CalcStericExclusionForceKernel(std::string name, const OpenMM::Platform& platform) :
        OpenMM::KernelImpl(name, platform)
    {
    }
    /**
     * Initialize the kernel. Most of the rest may be called once setPositions() or setState() has been; at any time,
     * copyParameters(), getState(), clearLimits(), getNumLimits(), getLimits() and rejectProposal().
     *
     * @param force      the StericExclusionForce this kernel will be used for
     * @param structure  its links
     */
    virtual void initialize(const StericExclusionForce& force, const LinkStructure& structure) = 0;
    /**
     * Copy radii, roles, tolerances and the force constant. Drops the open trial, keeps limits. If it throws an
     * exception, nothing has changed.
     */
    virtual void copyParameters(const StericExclusionForce& force) = 0;

    /**
     * Make these positions the state. Drops the open trial, keeps limits.
     */
    virtual void setPositions(const std::vector<OpenMM::Vec3>& positions) = 0;
    /**
     * Get the positions of the state.
     */
    virtual void getPositions(std::vector<OpenMM::Vec3>& positions) = 0;
    /**
     * Get the positions of a few particles of the state, of which the caller knows that they exist.
     */
    virtual void getPositionsOf(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions) = 0;
    /**
     * Get the state in numbers, limits and the open trial left out. They are none before there are positions.
     */
    virtual void getState(std::vector<double>& state) = 0;
    /**
     * Make numbers that getState() gave, for the same LinkStructure, the state. From then on everything has the bits
     * that it has in the kernel they came from. Drops the open trial and all limits.
     */
    virtual void setState(const std::vector<double>& state) = 0;
    /**
     * Get the value of a torsion, in (-pi, pi]. It is an error if it is undefined.
     */
    virtual double getTorsionAngle(int torsion) = 0;

    /**
     * Get the rotation of each link of the LinkStructure, row-major, since the last setPositions(). What setState() and
     * takeBackState() bring back has the rotations that it had.
     */
    virtual void getOrientations(std::vector<std::array<double, 9>>& orientations) = 0;

    /**
     * Compute the energy of the state and replace forces by its negative gradient.
     */
    virtual double computeEnergy(std::vector<OpenMM::Vec3>& forces) = 0;
    virtual bool hasClash() = 0;
    virtual void getClashes(std::vector<std::pair<int, int>>& pairs, std::vector<double>& overlaps) = 0;
    virtual void getNeighborPairs(double cutoff, std::vector<std::pair<int, int>>& pairs,
                                  std::vector<double>& distances) = 0;
    virtual double getMinimumDistance(const std::vector<int>& particles1, const std::vector<int>& particles2,
                                      int& particle1, int& particle2) = 0;
    virtual void getClashesWith(const OpenMM::Vec3& position, double radius, std::vector<int>& particles,
                                std::vector<double>& overlaps) = 0;

    /**
     * Make the tolerance the limit of every pair.
     */
    virtual void clearLimits() = 0;
    /**
     * Make the present overlap the limit of every pair that overlaps beyond its limit.
     */
    virtual void raiseLimits() = 0;
    virtual int getNumLimits() = 0;
    /**
     * Get the pairs with a limit of their own, sorted, and these limits.
     */
    virtual void getLimits(std::vector<std::pair<int, int>>& pairs, std::vector<double>& limits) = 0;
    /**
     * Make these the only pairs with a limit of their own. A limit below the tolerance of its pair is passed over.
     */
    virtual void setLimits(const std::vector<std::pair<int, int>>& pairs, const std::vector<double>& limits) = 0;

    /**
     * Open a trial that adds to the values of different torsions. Drops one that was open.
     */
    virtual void proposeTorsions(const std::vector<int>& torsions, const std::vector<double>& changes) = 0;
    /**
     * Open a trial that turns different ball joints by rotation vectors in the world. Drops one that was open.
     */
    virtual void proposeBallRotations(const std::vector<int>& ballJoints,
                                      const std::vector<OpenMM::Vec3>& rotations) = 0;
    /**
     * Open a trial that rotates a molecule about its centroid and then translates it. Drops one that was open.
     */
    virtual void proposeRigidMotion(int molecule, const OpenMM::Vec3& rotation, const OpenMM::Vec3& translation) = 0;
    virtual bool hasProposal() = 0;
    /**
     * Get whether no pair whose distance the open trial changes overlaps beyond its limit.
     */
    virtual bool isProposalFree() = 0;
    virtual void getProposedPositions(std::vector<OpenMM::Vec3>& positions) = 0;
    /**
     * Get the positions of a few particles in the open trial, of which the caller knows that they exist.
     */
    virtual void getProposedPositionsOf(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions) = 0;
    /**
     * The same in an array that belongs to the kernel and follows one trial after another, so that only what has moved
     * since the last call is computed.
     */
    virtual const std::vector<OpenMM::Vec3>& followProposal() = 0;
    /**
     * Get the positions of the state in that same array.
     */
    virtual const std::vector<OpenMM::Vec3>& followState() = 0;
    /**
     * Get by how much the energy would change if the open trial became the state.
     */
    virtual double getProposedEnergyChange() = 0;
    virtual void getChangedNeighborPairs(double cutoff, std::vector<std::pair<int, int>>& pairs,
                                         std::vector<double>& before, std::vector<double>& after) = 0;
    /**
     * Make the open trial the state.
     */
    virtual void acceptProposal() = 0;
    /**
     * Drop the open trial, if there is one.
     */
    virtual void rejectProposal() = 0;

    /** The parts of an energy, in the order in which a trial computes them. */
    enum EnergyPart { BondedPart, NearPairsPart, OtherPairsPart };
    /**
     * Make these the terms of the energy that the following calls are about. They may be empty.
     */
    virtual void setEnergyTerms(const EnergyTerms& terms) = 0;
    /**
     * Compute the energy of the state anew, unless what is kept of it is that of the state. With force, compute it
     * anyway. Returns whether it was computed.
     */
    virtual bool updateEnergy(bool force) = 0;
    /**
     * Get the energy as it is kept, of the state that updateEnergy() or the last accepted trial has left. That of pairs
     * is that of the stand-in, if there is one.
     */
    virtual void getEnergies(double& pairs, std::vector<double>& pairSets, std::vector<double>& termSets) = 0;
    /**
     * Get how many terms of each set some move could change.
     */
    virtual void countChangeableTerms(std::vector<int>& counts) = 0;
    /**
     * Compute by how much the open trial changes a part of the energy. Parts are asked for in their order. A trial that
     * is accepted before all were asked for leaves an energy that updateEnergy() computes anew.
     */
    virtual double getProposedEnergyChange(EnergyPart part) = 0;
    /**
     * Get the change of near pairs on the way back, once all parts were computed. See ctGetNearChangeBack().
     */
    virtual double getNearChangeBack() = 0;
    /**
     * Compute the energies that the stand-in stands for, of the state.
     */
    virtual void computeWholeEnergy(double& nonbonded, double& born) = 0;
    /**
     * Compute the energies of EnergyTerms::valueEnergies, of the state or of the open trial. Nothing is kept of them.
     */
    virtual void computeValueEnergies(bool inTrial, std::vector<double>& energies) = 0;
    /**
     * Make the stand-in what it is in this state, and compute the energy anew.
     */
    virtual void renewStandIn() = 0;
    /**
     * Get or set the numbers of the stand-in, which are none if there is none. They stay what they are in any state,
     * until the terms are set anew.
     */
    virtual void getStandIn(std::vector<double>& numbers) = 0;
    virtual void setStandIn(const std::vector<double>& numbers) = 0;
    /**
     * Keep the state, its limits and its energy. In between, nothing but trials may change them.
     */
    virtual void keepState() = 0;
    /**
     * Bring back what keepState() has kept, bit for bit. It stays kept. Drops the open trial.
     */
    virtual void takeBackState() = 0;

    virtual void getTraversalStatistics(long long& queries, long long& volumeTests, long long& particleTests,
                                        long long& nodesUpdated) = 0;
    virtual void resetTraversalStatistics() = 0;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREEKERNELS_H_*/
