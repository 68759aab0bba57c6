#ifndef OPENMM_CHAINTREE_FOREIGNENERGY_H_
#define OPENMM_CHAINTREE_FOREIGNENERGY_H_

#include "openmm/Integrator.h"
#include "openmm/System.h"
#include "openmmchaintree/internal/EnergyStage.h"

namespace ChainTreePlugin {

/**
 * The energy of all other Forces in the integration force groups, by an OpenMM evaluation for each trial.
 */
class ForeignEnergy : public EnergyStage {
public:
    ForeignEnergy(const OpenMM::Integrator& integrator, const OpenMM::System& system);
    bool begin(TrialSession& trials);
    double computeChange(TrialSession& trials);
    void accept();

private:
    const OpenMM::Integrator& integrator;
    /** The groups of all Forces that can contribute to U, as a bit mask. */
    const int groupsWithEnergy;
    /** Those of them whose energy is sampled. */
    int groups;
    /** The energies of the state and of the open trial. */
    double energy, proposedEnergy;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FOREIGNENERGY_H_*/
