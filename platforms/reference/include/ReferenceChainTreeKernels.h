#ifndef OPENMM_REFERENCECHAINTREEKERNELS_H_
#define OPENMM_REFERENCECHAINTREEKERNELS_H_

#include "chaintree.h"
#include "openmmchaintree/ChainTreeKernels.h"
#include "TrialEnergy.h"
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * This kernel hands everything to the engine, whose manual is chaintree.h. What it adds is the translation of torsions
 * and molecules to links, of callbacks to sorted arrays, and of status codes to exceptions.
 */
class ReferenceCalcStericExclusionForceKernel : public CalcStericExclusionForceKernel {
public:
    ReferenceCalcStericExclusionForceKernel(std::string name, const OpenMM::Platform& platform);
    void initialize(const StericExclusionForce& force, const LinkStructure& structure);
    void copyParameters(const StericExclusionForce& force);
    void setPositions(const std::vector<OpenMM::Vec3>& positions);
    void getPositions(std::vector<OpenMM::Vec3>& positions);
    void getPositionsOf(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions);
    void getState(std::vector<double>& state);
    void setState(const std::vector<double>& state);
    double getTorsionAngle(int torsion);
    void getOrientations(std::vector<std::array<double, 9>>& orientations);
    double computeEnergy(std::vector<OpenMM::Vec3>& forces);
    bool hasClash();
    void getClashes(std::vector<std::pair<int, int>>& pairs, std::vector<double>& overlaps);
    void getNeighborPairs(double cutoff, std::vector<std::pair<int, int>>& pairs, std::vector<double>& distances);
    double getMinimumDistance(const std::vector<int>& particles1, const std::vector<int>& particles2, int& particle1,
                              int& particle2);
    void getClashesWith(const OpenMM::Vec3& position, double radius, std::vector<int>& particles,
                        std::vector<double>& overlaps);
    void clearLimits();
    void raiseLimits();
    int getNumLimits();
    void getLimits(std::vector<std::pair<int, int>>& pairs, std::vector<double>& limits);
    void setLimits(const std::vector<std::pair<int, int>>& pairs, const std::vector<double>& limits);
    void proposeTorsions(const std::vector<int>& torsions, const std::vector<double>& changes);
    void proposeBallRotations(const std::vector<int>& ballJoints, const std::vector<OpenMM::Vec3>& rotations);
    void proposeRigidMotion(int molecule, const OpenMM::Vec3& rotation, const OpenMM::Vec3& translation);
    bool hasProposal();
    bool isProposalFree();
    void getProposedPositions(std::vector<OpenMM::Vec3>& positions);
    void getProposedPositionsOf(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions);
    const std::vector<OpenMM::Vec3>& followProposal();
    const std::vector<OpenMM::Vec3>& followState();
    double getProposedEnergyChange();
    void getChangedNeighborPairs(double cutoff, std::vector<std::pair<int, int>>& pairs, std::vector<double>& before,
                                 std::vector<double>& after);
    void acceptProposal();
    void rejectProposal();
    void setEnergyTerms(const EnergyTerms& terms);
    bool updateEnergy(bool force);
    void getEnergies(double& pairs, std::vector<double>& pairSets, std::vector<double>& termSets);
    void countChangeableTerms(std::vector<int>& counts);
    double getProposedEnergyChange(EnergyPart part);
    double getNearChangeBack();
    void computeWholeEnergy(double& nonbonded, double& born);
    void computeValueEnergies(bool inTrial, std::vector<double>& energies);
    void renewStandIn();
    void getStandIn(std::vector<double>& numbers);
    void setStandIn(const std::vector<double>& numbers);
    void keepState();
    void takeBackState();
    void getTraversalStatistics(long long& queries, long long& volumeTests, long long& particleTests,
                                long long& nodesUpdated);
    void resetTraversalStatistics();

private:
    class Deleter {
    public:
        void operator()(ctChainTree* tree) const
        {
            ctDestroy(tree);
        }
        void operator()(ctSelection* selection) const
        {
            ctFreeSelection(selection);
        }
    };
    typedef std::unique_ptr<ctChainTree, Deleter> Tree;
    typedef std::unique_ptr<ctSelection, Deleter> Selection;
    /** What copyParameters() copies. */
    struct Parameters {
        std::vector<double> radii;
        std::vector<uint8_t> roles;
        double overlapTolerance, hydrogenBondAllowance, forceConstant;
        double getTolerance(int particle1, int particle2) const;
    };
    class SoftTerms;
    TrialEnergy& requireEnergy();
    typedef std::vector<std::array<int, 2>> PairList;
    void readLimits(PairList& pairs, std::vector<double>& limits);
    void copyLimits(ctChainTree* created);
    static Parameters readParameters(const StericExclusionForce& force);
    ctDefinition describe(const Parameters& parameters, const std::vector<OpenMM::Vec3>& positions) const;
    Tree createTree(const Parameters& parameters, const std::vector<OpenMM::Vec3>& positions) const;
    struct KeptSelection {
        std::vector<int> particles;
        Selection selection;
    };
    ctSelection* select(const std::vector<int>& particles, KeptSelection& kept) const;
    void check(ctStatus status) const;
    void setTree(Tree created, std::vector<OpenMM::Vec3> positions);
    // The definition of the scene, in the arrays that the engine takes.
    Parameters parameters;
    std::vector<int> particleLinks;
    std::vector<int> linkParents;
    std::vector<uint8_t> linkJoints;
    std::vector<std::array<int, 4>> linkTorsions;
    std::vector<std::array<int, 2>> exclusions;
    // What torsions, ball joints and molecules are called there.
    std::vector<int> torsionLinks, ballJointLinks;
    std::vector<int> moleculeRoots;
    /** The scene. It is made when there are positions, because the engine arranges it by them. */
    Tree tree;
    /** The energy of trials, made when it is asked for; and what it is made from. */
    std::unique_ptr<TrialEnergy> energy;
    EnergyTerms energyTerms;
    /** The numbers of its stand-in, which outlive the scene; empty until they are set or renewed. */
    std::vector<double> standIn;
    /** What keepState() has kept of the scene. */
    struct KeptState {
        bool exists = false;
        std::vector<double> numbers;
        PairList limitedPairs;
        std::vector<double> limits;
        bool hasEnergy = false;
    };
    KeptState kept;
    /** Which particles stand in leaves whatever their radius, because the energy needs them. */
    std::vector<uint8_t> listed;
    /** The positions that the scene was made from. */
    std::vector<OpenMM::Vec3> arrangement;
    /** The changes of a trial, kept so that trials allocate no memory. */
    std::vector<ctChange> changes;
    /** What followProposal() or followState() returned last; empty if that was of another scene. */
    std::vector<OpenMM::Vec3> followed;
    /** Where neighbour pairs are put, kept so that there is room for as many as the last time. */
    std::vector<int> neighbors1, neighbors2;
    /** The sets of the last minimum distance: mostly the same are asked about again, and the engine gains by that. */
    KeptSelection selection1, selection2;
    ctCounts counts;
    long long numQueries;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_REFERENCECHAINTREEKERNELS_H_*/
