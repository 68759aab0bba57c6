#ifndef OPENMM_CHAINTREE_SOFTSPHEREENERGY_H_
#define OPENMM_CHAINTREE_SOFTSPHEREENERGY_H_

#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/NativeEnergy.h"

namespace ChainTreePlugin {

/**
 * The energy of the StericExclusionForce itself, a part of U if its spheres are soft.
 */
class SoftSphereEnergy : public EnergyStage {
public:
    explicit SoftSphereEnergy(const NativeEnergy& native) : native(native)
    {
    }
    std::string getName() const
    {
        return "soft spheres";
    }
    bool begin(TrialSession&)
    {
        return native.getStericMode() == TorsionMonteCarloIntegrator::Soft;
    }
    double computeEnergyChange(TrialSession& trials)
    {
        return trials.computeSoftEnergyChange();
    }

private:
    const NativeEnergy& native;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SOFTSPHEREENERGY_H_*/
