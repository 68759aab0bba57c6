#ifndef OPENMM_CHAINTREE_SCENE_H_
#define OPENMM_CHAINTREE_SCENE_H_

#include "chaintree.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Proposal.h"
#include "openmmchaintree/internal/SceneDefinition.h"
#include "openmmchaintree/internal/SceneEnergy.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * The spheres of a StericExclusionForce in the engine, whose manual is chaintree.h: the positions, the open trial, the
 * limits of pairs, and the energy of trials. This class turns torsions and molecules into links, results of the engine
 * into sorted arrays, and status codes into exceptions. It knows no Context.
 *
 * The caller checks indices of torsions, ball joints and molecules, and the values of proposals. The engine checks
 * everything else. A call that throws an exception does not change the state.
 *
 * Before setPositions() or setState(), only copyParameters(), setBox(), getState(), clearLimits(), getNumLimits(),
 * getLimits(), reject(), and setTerms() and countChangeableTerms() of the energy may be called.
 */
class OPENMM_EXPORT_CHAINTREE Scene {
public:
    Scene(const StericExclusionForce& force, const LinkStructure& structure);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    /**
     * Copy radii, roles, tolerances and the force constant. Drops the open trial, keeps limits.
     */
    void copyParameters(const StericExclusionForce& force);
    /**
     * Get the energy of trials.
     */
    SceneEnergy& getEnergy()
    {
        return energy;
    }

    // ---- State ----

    /**
     * Get whether pairs count in all images of a periodic box.
     */
    bool isPeriodic() const
    {
        return definition.isPeriodic;
    }
    /**
     * Set the box of a periodic scene that has no positions yet.
     */
    void setBox(const BoxVectors& box);
    /**
     * Get whether the box has exactly these vectors, or the scene is not periodic.
     */
    bool hasBox(const BoxVectors& box) const;
    const BoxVectors& getBox() const
    {
        return definition.box;
    }
    /**
     * Get the box of the open trial.
     */
    const BoxVectors& getTrialBox() const
    {
        return isScaled ? scaledBox : definition.box;
    }
    /**
     * Make these positions the state. Drops the open trial, keeps limits.
     */
    void setPositions(const std::vector<OpenMM::Vec3>& positions)
    {
        setPositions(positions, definition.box);
    }
    /**
     * The same with another box, if the scene is periodic.
     */
    void setPositions(const std::vector<OpenMM::Vec3>& positions, const BoxVectors& box);
    /**
     * Get the positions of the state.
     */
    void getPositions(std::vector<OpenMM::Vec3>& positions);
    /**
     * Get the positions of some particles of the state.
     */
    void getPositionsOf(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions);
    /**
     * Get the state as numbers, with the box, without limits and the open trial; empty before there are positions.
     */
    void getState(std::vector<double>& state);
    /**
     * Set the state from numbers that getState() returned for the same LinkStructure, periodic or not, bit for bit.
     * Drops the open trial and all limits.
     */
    void setState(const std::vector<double>& state);
    /**
     * Save the state, its limits and its energy. Until restore(), only trials may change them.
     */
    void save();
    /**
     * Restore the saved state, bit for bit. It remains saved. Drops the open trial.
     */
    void restore();
    /**
     * Get the centroid of a molecule without fixed particles.
     */
    OpenMM::Vec3 getCentroid(int molecule) const;
    /**
     * Get the value of a torsion, in (-pi, pi]. It is an error if it is undefined.
     */
    double getTorsionAngle(int torsion);
    /**
     * Get the rotation of each link of the LinkStructure since the last setPositions(), row-major. setState() and
     * restore() set the rotations that the state had.
     */
    void getOrientations(std::vector<std::array<double, 9>>& orientations);

    // ---- Queries about the state ----

    /**
     * Compute the energy of overlapping spheres and replace forces by its negative gradient.
     */
    double computeEnergy(std::vector<OpenMM::Vec3>& forces);
    bool hasClash();
    void getClashes(std::vector<std::pair<int, int>>& pairs, std::vector<double>& overlaps);
    void getNeighborPairs(double cutoff, std::vector<std::pair<int, int>>& pairs, std::vector<double>& distances);
    double getMinimumDistance(const std::vector<int>& particles1, const std::vector<int>& particles2, int& particle1,
                              int& particle2);
    void getClashesWith(const OpenMM::Vec3& position, double radius, std::vector<int>& particles,
                        std::vector<double>& overlaps);
    /**
     * Add the operation counts of this scene to others.
     */
    void addTraversalStatistics(long long& queries, long long& volumeTests, long long& particleTests,
                                long long& nodesUpdated) const;
    void resetTraversalStatistics();

    // ---- Limits ----

    /**
     * Make the tolerance the limit of every pair.
     */
    void clearLimits();
    /**
     * Raise the limit of every pair that overlaps beyond it to the present overlap.
     */
    void raiseLimits();
    int getNumLimits() const;
    /**
     * Get the pairs whose limit is not the tolerance, sorted, and these limits.
     */
    void getLimits(std::vector<std::pair<int, int>>& pairs, std::vector<double>& limits) const;
    /**
     * Set the limits of these pairs, and make the tolerance the limit of all others. A limit below the tolerance of its
     * pair has no effect.
     */
    void setLimits(const std::vector<std::pair<int, int>>& pairs, const std::vector<double>& limits);

    // ---- Trials. Each proposal drops the trial that was open ----

    /**
     * Propose a trial. Returns false, with no trial open, if it scales the box so that this is narrower than twice the
     * distance at which spheres can clash.
     */
    bool propose(const Proposal& proposal);
    bool hasTrial() const;
    /**
     * Test the open trial. Returns true if it is free: no pair whose distance it changes overlaps beyond its limit, or
     * no pair at all if it scales the box.
     */
    bool test();
    void getTrialPositions(std::vector<OpenMM::Vec3>& positions);
    void getTrialPositionsOf(const std::vector<int>& particles, std::vector<OpenMM::Vec3>& positions);
    /**
     * Get the positions of the open trial in an array of this object, which the next call of this function or of
     * followState() changes. Only particles that have moved since the last such call are computed.
     */
    const std::vector<OpenMM::Vec3>& followTrial();
    /**
     * Get the positions of the state in the same array.
     */
    const std::vector<OpenMM::Vec3>& followState();
    /**
     * Compute by how much the open trial changes the energy of overlapping spheres.
     */
    double computeSoftEnergyChange();
    /**
     * Get the pairs whose distance the open trial changes and that are within the cutoff before or after it, sorted. It
     * is an error if the trial scales the box.
     */
    void getChangedNeighborPairs(double cutoff, std::vector<std::pair<int, int>>& pairs, std::vector<double>& before,
                                 std::vector<double>& after);
    /**
     * Make the open trial the state.
     */
    void accept();
    /**
     * Drop the open trial, if there is one.
     */
    void reject();

private:
    friend class SceneEnergy;
    class Deleter {
    public:
        void operator()(ctChainTree* tree) const;
        void operator()(ctSelection* selection) const;
    };
    typedef std::unique_ptr<ctChainTree, Deleter> Tree;
    /** Particles that the engine has prepared for distances from them. */
    struct PreparedSet {
        std::vector<int> particles;
        std::unique_ptr<ctSelection, Deleter> selection;
    };
    typedef std::vector<std::array<int, 2>> PairList;
    /** The saved state, without the energy. */
    struct SavedState {
        bool exists = false;
        std::vector<double> numbers;
        BoxVectors box;
        PairList limitedPairs;
        std::vector<double> limits;
        /** Whether the tree that was saved, with its energy, is now the other one. */
        bool isInOther = false;
    };
    bool proposeScaled(double factor);
    void proposeDisplacements(const std::vector<Proposal::Displacement>& proposed);
    void exchangeTrees();
    bool testScaled();
    const std::vector<OpenMM::Vec3>& getScaledPositions();
    double computeSoftEnergy(ctChainTree& tree);
    static Tree createTree(const SceneDefinition& definition, const std::vector<OpenMM::Vec3>& positions);
    void setTree(Tree created, std::vector<OpenMM::Vec3> positions);
    void setListed(std::vector<uint8_t> needed);
    void check(ctStatus status) const;
    void describe(const Proposal::Change& proposed, ctChange& change) const;
    void readLimits(PairList& pairs, std::vector<double>& limits) const;
    void copyLimits(ctChainTree* created) const;
    void check(ctStatus status, const ctChainTree* failed) const;
    ctSelection* prepare(const std::vector<int>& particles, PreparedSet& set) const;
    SceneDefinition definition;
    /** The engine's scene. It is made when there are positions, because its layout depends on them. */
    Tree tree;
    /** The positions from which it was made. */
    std::vector<OpenMM::Vec3> arrangement;
    /** A second tree of the same layout, in which trials that scale the box are made; NULL until the first. */
    Tree other;
    /** Whether the open trial is the state of the other tree; then its box and positions. */
    bool isScaled = false;
    BoxVectors scaledBox;
    std::vector<OpenMM::Vec3> scaledPositions;
    SceneEnergy energy;
    SavedState saved;
    /** The changes of a trial in the engine's form. They stay allocated from trial to trial. */
    std::vector<ctChange> changes;
    std::vector<ctDisplacement> displacements;
    /** The last result of followTrial() or followState(); empty if it was of another tree. */
    std::vector<OpenMM::Vec3> followed;
    /** The pairs of the last getNeighborPairs(). They stay allocated, since the next list is about as long. */
    std::vector<int> neighbors1, neighbors2;
    /** The sets of the last getMinimumDistance(), since the next call is mostly about the same. */
    PreparedSet set1, set2;
    ctCounts counts;
    long long numQueries;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SCENE_H_*/
