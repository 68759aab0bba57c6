#ifndef OPENMM_CHAINTREE_NATIVEENERGY_H_
#define OPENMM_CHAINTREE_NATIVEENERGY_H_

#include "openmm/internal/ContextImpl.h"
#include "openmmchaintree/internal/EnergyPlan.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/NativeEnergyCheck.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

class StericExclusionForceImpl;

/**
 * The part of U that the kernel evaluates: the EnergyPlan of a Context, and what the kernel keeps by it. Its stages
 * share one.
 *
 * Forces are translated when the Context is made, when it has told of a change of parameters, and when what is sampled
 * was changed. OpenMM's own energy is compared after each of these, and from time to time.
 */
class NativeEnergy {
public:
    /**
     * Make the plan of a Context whose Forces exist, and prepare the kernel for it.
     */
    NativeEnergy(const TorsionMonteCarloIntegrator& integrator, StericExclusionForceImpl& force,
                 OpenMM::ContextImpl& context);
    /**
     * Take notice that the Context has told of a change.
     */
    void contextWasChanged(OpenMM::State::DataType changed)
    {
        parametersWereChanged |= changed == OpenMM::State::Parameters;
        forcesWereChanged |= changed == OpenMM::State::Energy; // by updateParametersInContext() of a Force
    }
    /**
     * Compute the energy of the state anew before it is used next. A run that goes on and one that is resumed from what
     * was just saved then add up the same numbers in the same order.
     */
    void computeAnew()
    {
        energyIsOld = true;
    }
    /**
     * Get what is evaluated where, as the next trials will have it.
     */
    const EnergyPlan& getPlan();
    /**
     * Begin a series of trials: bring the plan and the kernel's energy up to date, and compare OpenMM's if it is time.
     * This comes before the stages begin.
     */
    void begin(TrialSession& trials);
    /**
     * Get whether moves can change a part. Nothing has to be asked about the others.
     */
    bool canChange(CalcStericExclusionForceKernel::EnergyPart part) const;
    /**
     * Compute by how much the open trial changes a part, and those before it of which no trial asks.
     */
    double computeChange(CalcStericExclusionForceKernel::EnergyPart part);
    /**
     * Take notice that the open trial has come to its end.
     */
    void endTrial();
    /**
     * Get by how much the open trial changes the parts that were computed.
     */
    double getComputedChange() const
    {
        return computedChange;
    }
    /**
     * Get the force groups that OpenMM has to evaluate for the foreign Forces; 0 if there are none.
     */
    int getForeignGroups() const
    {
        return foreignGroups;
    }
    /**
     * Get whether the foreign groups have native Forces, too. Then they are all groups of these.
     */
    bool sharesForeignGroups() const
    {
        return foreignGroupsAreShared;
    }
    /**
     * Compute the energy of all Forces of the integration force groups but the StericExclusionForce.
     */
    double computeEnergy(TrialSession& trials);

private:
    /** What the user has chosen that the plan depends on. */
    class Choice {
    public:
        int groups;
        bool native, soft;
        bool operator==(const Choice& other) const
        {
            return groups == other.groups && native == other.native && soft == other.soft;
        }
    };
    Choice getChoice() const;
    bool hasTerms() const
    {
        return !plan.getTranslatedForces().empty();
    }
    void updatePlan();
    void translate();
    std::vector<double> updateEnergies();
    void checkNumbers(const std::vector<double>& energies) const;
    void compareWithOpenMM(TrialSession& trials, const std::vector<double>& energies);
    const TorsionMonteCarloIntegrator& integrator;
    StericExclusionForceImpl& force;
    OpenMM::ContextImpl& context;
    CalcStericExclusionForceKernel& kernel;
    EnergyPlan plan;
    NativeEnergyCheck check;
    Choice choice;
    bool forcesWereChanged, parametersWereChanged, energyIsOld;
    /** Whether trials can change terms, and pairs. */
    bool termsCanChange, pairsCanChange;
    int foreignGroups;
    bool foreignGroupsAreShared;
    /** The number of trials until OpenMM's energy is compared again, and how many there were to be the last time. */
    long long trialsToCheck, checkInterval;
    /** The number of parts of the open trial that were computed, and the sum of their changes. */
    int numComputed;
    double computedChange;
};

/**
 * A part of U that the kernel evaluates.
 */
class NativeEnergyStage : public EnergyStage {
public:
    NativeEnergyStage(NativeEnergy& energy, CalcStericExclusionForceKernel::EnergyPart part) :
        energy(energy), part(part)
    {
    }
    std::string getName() const;
    bool begin(TrialSession&)
    {
        return energy.canChange(part);
    }
    double computeChange(TrialSession&)
    {
        return energy.computeChange(part);
    }
    void accept()
    {
        energy.endTrial();
    }
    void reject()
    {
        energy.endTrial();
    }

private:
    NativeEnergy& energy;
    const CalcStericExclusionForceKernel::EnergyPart part;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_NATIVEENERGY_H_*/
