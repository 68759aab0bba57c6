#ifndef OPENMM_CHAINTREE_SOFTSPHEREENERGY_H_
#define OPENMM_CHAINTREE_SOFTSPHEREENERGY_H_

#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"

namespace ChainTreePlugin {

/**
 * The energy of the StericExclusionForce itself, a part of U if its spheres are soft.
 */
class SoftSphereEnergy : public EnergyStage {
public:
    explicit SoftSphereEnergy(const TorsionMonteCarloIntegrator& integrator) : integrator(integrator)
    {
    }
    std::string getName() const
    {
        return "soft spheres";
    }
    bool begin(TrialSession&)
    {
        return integrator.getStericMode() == TorsionMonteCarloIntegrator::Soft;
    }
    double computeChange(TrialSession& trials)
    {
        return trials.computeSoftEnergyChange();
    }

private:
    const TorsionMonteCarloIntegrator& integrator;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SOFTSPHEREENERGY_H_*/
