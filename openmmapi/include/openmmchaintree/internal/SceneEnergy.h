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
     * Compute the energy of the state, unless the energy that is held is already that of the state. With force, compute
     * it anyway. Returns whether it was computed.
     */
    bool update(bool force);
    /**
     * Get the energy of the last update() or accepted trial. The energy of pairs is that of the stand-in, if there is
     * one.
     */
    void getEnergies(double& pairs, std::vector<double>& pairSets, std::vector<double>& termSets);
    /**
     * Compute by how much the open trial changes a part of the energy, in the order of the parts. If a trial is
     * accepted before all parts were computed, update() computes the whole energy.
     */
    double computeEnergyChange(ctEnergyPart part);
    /**
     * Get the change of near pairs on the way back, after all parts were computed. See ctGetNearChangeBack().
     */
    double getNearChangeBack();
    /**
     * Compute the energies that the stand-in replaces, of the state.
     */
    void computeWhole(double& nonbonded, double& born);
    /**
     * Compute the energies of EnergyTerms::valueEnergies, of the state or of the open trial. They are not held.
     */
    void computeValues(bool inTrial, std::vector<double>& energies);
    /**
     * Make the stand-in of the present state, and compute the energy with it.
     */
    void renewStandIn();
    /**
     * Get or set the numbers of the stand-in; there are none if there is no stand-in. They hold in any state, until
     * setTerms() is called.
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
    void check(ctStatus status) const;
    std::vector<uint8_t> findListed() const;
    int getStandInSize() const;
    /**
     * Forget the energy, because its tree ends.
     */
    void reset();
    void accept();
    void save();
    void restore();
    Scene& scene;
    EnergyTerms terms;
    /** The library's energy. It is made when it is asked for, from the scene's tree. */
    Handle energy;
    /** The numbers of the stand-in, which outlive the tree; empty until they are set or renewed. */
    std::vector<double> standIn;
    /** Whether save() has saved an energy. */
    bool isSaved;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SCENEENERGY_H_*/
