#ifndef OPENMM_CHAINTREE_TRIALENERGY_H_
#define OPENMM_CHAINTREE_TRIALENERGY_H_

#include "ctenergy.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include <memory>
#include <vector>

namespace ChainTreePlugin {

/**
 * The energy of one scene, as ctenergy.h computes it. What this adds is the translation of EnergyTerms to the library's
 * arrays, of status codes to exceptions, and the knowledge whether what is kept belongs to the state.
 */
class TrialEnergy {
public:
    /**
     * Make the energy of a scene.
     *
     * @param tree   the scene, which has to outlive this object
     * @param scene  what it was made from
     * @param terms  the energy
     */
    TrialEnergy(ctChainTree* tree, const ctDefinition& scene, const EnergyTerms& terms);
    /**
     * Get whether a particle has to stand in a leaf of the scene, for each of them.
     */
    static std::vector<uint8_t> findListed(const EnergyTerms& terms, int numParticles);
    /**
     * Compute everything anew, unless what is kept belongs to the state. With force, do so anyway. Returns whether
     * it was done.
     */
    bool update(bool force, ctCounts& counts);
    double computeChange(ctEnergyPart part, ctCounts& counts);
    /**
     * Take notice that the open trial has become the state.
     */
    void accept();
    void getEnergies(double& pairs, std::vector<double>& pairSets, std::vector<double>& termSets) const;
    double getNearChangeBack() const;
    void computeWhole(double& nonbonded, double& born, ctCounts& counts);
    void computeValues(bool inTrial, std::vector<double>& energies);
    void renewStandIn(ctCounts& counts);
    void getStandIn(std::vector<double>& numbers) const;
    void setStandIn(const std::vector<double>& numbers);
    void countChangeableTerms(std::vector<int>& counts) const;
    /**
     * Keep what is known of the state, or bring it back once the scene has been.
     */
    void keep();
    void takeBack();

private:
    class Deleter {
    public:
        void operator()(ctEnergy* energy) const
        {
            ctDestroyEnergy(energy);
        }
    };
    void check(ctStatus status) const;
    std::unique_ptr<ctEnergy, Deleter> energy;
    int numPairSets, numTermSets, numValueEnergies;
    /** How many numbers the stand-in has; 0 if there is none. */
    int sizeOfStandIn;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_TRIALENERGY_H_*/
