#ifndef OPENMM_CHAINTREE_SCENEENERGY_H_
#define OPENMM_CHAINTREE_SCENEENERGY_H_

#include "ctenergy.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <cstdint>
#include <memory>
#include <vector>

namespace ChainTreePlugin {

class Scene;

/**
 * The energy of the trials of a Scene, as ctenergy.h computes it. This class turns EnergyTerms into the library's
 * arrays and status codes into exceptions.
 */
class OPENMM_EXPORT_CHAINTREE SceneEnergy {
public:
    explicit SceneEnergy(Scene& scene);
    ~SceneEnergy();
    SceneEnergy(const SceneEnergy&) = delete;
    SceneEnergy& operator=(const SceneEnergy&) = delete;
    /**
     * Make these the terms of the energy. They may be empty.
     */
    void setTerms(const EnergyTerms& terms);
    /**
     * Get how many terms of each set some move could change.
     */
    void countChangeableTerms(std::vector<int>& counts);
    /**
     * Compute the energy of the state, unless it is known. With `force`, compute it anyway. Returns whether it was
     * computed.
     */
    bool update(bool force);
    /**
     * Get the energy after the last update() or accepted trial. The energy of pairs is the stand-in's, if there is one.
     */
    void getEnergies(double& pairs, std::vector<double>& pairSets, std::vector<double>& termSets);
    /**
     * Compute by how much the open trial changes a part of the energy. Call this in the order of the parts. If a trial
     * is accepted before all parts were computed, the next update() computes the whole energy.
     */
    double computeEnergyChange(ctEnergyPart part);
    /**
     * Get the change of near pairs in the reverse trial, after all parts were computed. See ctGetNearChangeBack().
     */
    double getNearChangeBack();
    /**
     * Compute the energies that the stand-in replaces, of the state.
     */
    void computeWhole(double& nonbonded, double& born);
    /**
     * Compute the energies of EnergyTerms::valueEnergies, of the state or of the open trial. The results are not kept.
     */
    void computeValues(bool inTrial, std::vector<double>& energies);
    /**
     * Compute the stand-in for the present state, and the energy with it.
     */
    void renewStandIn();
    /**
     * Get or set the numbers of the stand-in; empty if there is none. They apply in any state, until setTerms() is
     * called.
     */
    void getStandIn(std::vector<double>& numbers);
    void setStandIn(const std::vector<double>& numbers);

private:
    friend class Scene;
    class Deleter {
    public:
        void operator()(ctEnergy* energy) const;
    };
    typedef std::unique_ptr<ctEnergy, Deleter> Handle;
    Handle create(ctChainTree* tree, const ctDefinition& definition) const;
    ctEnergy* require();
    ctEnergy* require(ctChainTree* tree, Handle& handle) const;
    void readEnergies(const ctEnergy* energy, const ctChainTree* tree, double& pairs, std::vector<double>& pairSets,
                      std::vector<double>& termSets) const;
    double sumPart(const ctEnergy* energy, const ctChainTree* tree, ctEnergyPart part) const;
    double computeScaledChange(ctEnergyPart part);
    void check(ctStatus status) const;
    void check(ctStatus status, const ctEnergy* failed) const;
    std::vector<uint8_t> findListed() const;
    int getStandInSize() const;
    /**
     * Free the energy, because its tree ends.
     */
    void reset();
    /**
     * Take notice that the scene has exchanged its trees.
     */
    void exchange()
    {
        energy.swap(otherEnergy);
    }
    void accept();
    void save();
    void restore();
    Scene& scene;
    EnergyTerms terms;
    /** The library's energy, which is made from the scene's tree at its first use. */
    Handle energy;
    /** The same for the scene's other tree. */
    Handle otherEnergy;
    /** The numbers of the stand-in, which outlive the tree; empty until they are set or renewed. */
    std::vector<double> standIn;
    /** Whether save() has saved an energy. */
    bool isSaved;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SCENEENERGY_H_*/
