#ifndef OPENMM_CHAINTREE_FOREIGNENERGY_H_
#define OPENMM_CHAINTREE_FOREIGNENERGY_H_

#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/NativeEnergy.h"

namespace ChainTreePlugin {

/**
 * The energy of foreign Forces that decide each trial, evaluated by OpenMM in each trial. Foreign Forces that
 * are left to outer tests have no part in it.
 *
 * If ForeignForces can only evaluate them together with native Forces, the scene's energy of the native Forces is
 * subtracted.
 */
class ForeignEnergy : public EnergyStage {
public:
    explicit ForeignEnergy(const NativeEnergy& native) : native(native), energy(0), proposedEnergy(0), keptEnergy(0)
    {
    }
    std::string getName() const
    {
        return "foreign forces";
    }
    bool begin(TrialSession& trials);
    double computeEnergyChange(TrialSession& trials);
    void accept();
    void save()
    {
        keptEnergy = energy;
    }
    void restore()
    {
        energy = keptEnergy;
    }

private:
    const NativeEnergy& native;
    /** The parts of ForeignForces that are evaluated. */
    std::vector<int> parts;
    /** The energies of the state and of the open trial. */
    double energy, proposedEnergy;
    /** The energy of the saved state. */
    double keptEnergy;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FOREIGNENERGY_H_*/
