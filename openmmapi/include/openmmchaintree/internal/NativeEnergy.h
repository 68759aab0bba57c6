#ifndef OPENMM_CHAINTREE_NATIVEENERGY_H_
#define OPENMM_CHAINTREE_NATIVEENERGY_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/EnergyPlan.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/ForeignForces.h"
#include "openmmchaintree/internal/NativeEnergyCheck.h"
#include "openmmchaintree/internal/OuterSchedule.h"
#include "openmmchaintree/internal/OuterWatch.h"
#include "openmmchaintree/internal/SceneEnergy.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

class StericExclusionForceImpl;

/**
 * The part of U that the scene evaluates, by the EnergyPlan of a Context. Its stages share this object.
 *
 * Forces are translated when the Context is made and when parameters or settings of the integrator have changed. The
 * energy is compared with OpenMM's after each translation, and from time to time.
 */
class NativeEnergy {
public:
    /**
     * Make the plan of a Context whose Forces exist, and prepare the scene for it.
     */
    NativeEnergy(const TorsionMonteCarloIntegrator& integrator, StericExclusionForceImpl& force,
                 OpenMM::ContextImpl& context);
    /**
     * Take notice of a change that the Context has reported.
     */
    void contextWasChanged(OpenMM::State::DataType changed)
    {
        parametersWereChanged |= changed == OpenMM::State::Parameters;
        forcesWereChanged |= changed == OpenMM::State::Energy; // by updateParametersInContext() of a Force
    }
    /**
     * Recompute the energy of the state before its next use. A continued run and a run that resumes from a checkpoint
     * then add the same numbers in the same order.
     */
    void recompute()
    {
        energyIsOld = true;
    }
    /**
     * Translate the Forces again if anything has changed, and give the scene their terms, which another integrator of a
     * CompoundIntegrator may have replaced. Call this before a TrialSession begins.
     */
    void updatePlan();
    /**
     * Get the part that the StericExclusionForce has in U, which is never Automatic.
     */
    TorsionMonteCarloIntegrator::StericMode getStericMode() const
    {
        return plan.resolve(integrator.getStericMode(), integrator.getIntegrationForceGroups());
    }
    /**
     * Get the entries of the plan, with reasons that say how often each Force is evaluated under the present settings
     * and measurements.
     */
    std::vector<EnergyPlan::Entry> describePlan();
    /**
     * Begin a series of trials: update the scene's energy, and compare it with OpenMM's if it is time. Call this after
     * updatePlan(), and before the stages begin.
     */
    void begin(TrialSession& trials);
    /**
     * Get whether moves can change a part.
     */
    bool canChange(ctEnergyPart part) const;
    /**
     * Compute by how much the open trial changes a part, and the parts before it that no move can change.
     */
    double computeEnergyChange(ctEnergyPart part);
    /**
     * Discard the results of the open trial, which has ended.
     */
    void forgetTrial();
    /**
     * Take notice that the open trial was accepted.
     */
    void accept()
    {
        whole.isCurrent = values.isCurrent = false;
        forgetTrial();
    }
    /**
     * Get by how much the open trial changes the parts that were computed.
     */
    double getComputedChange() const
    {
        return computedChange;
    }
    /**
     * Get whether each trial is decided by the energies of values, too. Otherwise the outer test decides by them.
     */
    bool decidesByValues() const
    {
        return valuesCanChange && integrator.getTrialsPerOuterTest() == 0;
    }
    /**
     * Compute by how much the open trial changes the energies of values. Call this after all parts.
     */
    double computeValueEnergyChange();
    /**
     * Take notice that the trial of the last computeValueEnergyChange() was accepted, after accept().
     */
    void acceptValues()
    {
        values.energies.swap(proposedValues);
        values.isCurrent = true;
        forgetTrial();
    }
    /**
     * Get whether a state can have this energy: neither NaN nor minus infinity, which would leave no probability to
     * other states.
     */
    static bool isPossible(double energy);
    /**
     * Throw an exception that names the foreign Forces whose energy of the state is impossible.
     */
    [[noreturn]] void refuseState(TrialSession& trials) const;
    const ForeignForces& getForeign() const
    {
        return foreign;
    }
    /**
     * Get the parts of the foreign Forces that decide each trial of the present series.
     */
    std::vector<int> getForeignOfTrials() const
    {
        return selectForeign(false);
    }
    /**
     * Compute the energy of all Forces of the integration force groups but the StericExclusionForce.
     */
    double computeEnergy(TrialSession& trials);

    // ---- The energy U and its approximation U1, which decides trials; see OuterTest ----

    /**
     * Get whether trials use a stand-in for a part of U.
     */
    bool hasStandIn() const
    {
        return !plan.getTerms().born.empty() && pairsCanChange;
    }
    /**
     * Get the term that the change of other pairs adds to correct the change of near pairs; see
     * EnergyStage::getCorrection().
     */
    double getNearCorrection();
    /**
     * Get the number of trials per outer test in the present series; 0 without outer tests.
     */
    int getTrialsPerOuterTest() const;
    /** U - U1 of a state, for an outer test. */
    class Difference {
    public:
        /** U - U1; infinite if U is. */
        double whole;
        /** The energy of each part of the foreign Forces, while the schedule measures them. */
        std::vector<double> foreign;
    };
    Difference computeDifference(TrialSession& trials);
    /**
     * Take notice of a complete block of trials, with its first and last state.
     */
    void takeNoticeOfTest(const Difference& before, const Difference& after);
    /**
     * Warn if outer tests accept few trials.
     */
    void judgeOuterTests()
    {
        watch.judge();
    }
    /**
     * Get U1 of the state, without terms that moves cannot change and without soft spheres.
     */
    double getInnerEnergy();
    /**
     * Save the data of the state, or take notice that the state was restored.
     */
    void save()
    {
        savedWhole = whole;
        savedValues = values;
    }
    void restore()
    {
        forgetTrial();
        whole = savedWhole;
        values = savedValues;
    }
    /**
     * Compute the stand-in for the present state, if there is one, and measure foreign Forces for outer tests again.
     */
    void renewStandIn();
    /**
     * Get the numbers of the stand-in; empty if there is none, or it was never computed.
     */
    const std::vector<double>& getStandIn() const
    {
        return standIn;
    }
    /**
     * Set the numbers that getStandIn() returned. If they do not fit the Forces, the next series of trials computes the
     * stand-in.
     */
    void setStandIn(const std::vector<double>& numbers);
    /**
     * Get whether numbers can be those of a stand-in: all are finite, in single precision too.
     */
    static bool isStandIn(const std::vector<double>& numbers);
    /**
     * Get or set the numbers of the OuterSchedule.
     */
    std::vector<double> getSchedule() const
    {
        return schedule.getNumbers();
    }
    void setSchedule(const std::vector<double>& numbers)
    {
        schedule.setNumbers(numbers);
    }
    /**
     * Write the numbers of the stand-in and of the OuterSchedule, or read them, for setStandIn() and setSchedule().
     * Reading throws an exception if numbers cannot be those of a stand-in.
     */
    void writeStandIn(OpenMM::SerializationNode& node) const;
    static std::vector<double> readStandIn(const OpenMM::SerializationNode& node);
    static std::vector<double> readSchedule(const OpenMM::SerializationNode& node);

private:
    /** The user's settings on which the plan depends. */
    class Choice {
    public:
        int groups;
        bool native;
        TorsionMonteCarloIntegrator::StericMode stericMode;
        /** The energy that overlapping CoreSpheres exceed. */
        double coreEnergy;
        EnergyTerms::StandIn standIn;
        bool operator==(const Choice& other) const
        {
            return groups == other.groups && native == other.native && stericMode == other.stericMode &&
                   coreEnergy == other.coreEnergy && standIn == other.standIn;
        }
    };
    /** The energies of the state for which trials use the stand-in. */
    class WholeEnergy {
    public:
        bool isCurrent;
        double nonbonded, born;
    };
    /** The energies of values in the state. */
    class ValueEnergies {
    public:
        bool isCurrent;
        std::vector<double> energies;
    };
    /** The energy of the state as the scene holds it. */
    class HeldEnergy {
    public:
        double pairs;
        std::vector<double> pairSets, termSets;
    };
    Choice getChoice() const;
    int getUsualTrials() const;
    bool hasTerms() const
    {
        return !plan.getTranslatedForces().empty();
    }
    bool choosesForeign() const;
    bool isLeftToTests(int part) const;
    std::vector<int> selectForeign(bool leftToTests) const;
    void beginSchedule();
    Difference computeForeignDifference(TrialSession& trials);
    void translate();
    void setTerms();
    SceneEnergy& getEnergy() const;
    void updateStandIn();
    void computeStandIn();
    const HeldEnergy& updateHeld();
    const WholeEnergy& updateWhole();
    const std::vector<double>& updateValues();
    std::vector<double> updateEnergies();
    void checkNumbers(const std::vector<double>& energies) const;
    void compareWithOpenMM(TrialSession& trials, const std::vector<double>& energies);
    const TorsionMonteCarloIntegrator& integrator;
    StericExclusionForceImpl& force;
    OpenMM::ContextImpl& context;
    EnergyPlan plan;
    NativeEnergyCheck check;
    Choice choice;
    CoreSpheres cores;
    bool forcesWereChanged, parametersWereChanged, energyIsOld;
    /** Whether trials can change terms, pairs, and energies of values. */
    bool termsCanChange, pairsCanChange, valuesCanChange;
    ForeignForces foreign;
    OuterSchedule schedule;
    OuterWatch watch;
    /** The number of trials until OpenMM's energy is compared again, and its last initial value. */
    long long trialsToCheck, checkInterval;
    /** The number of parts of the open trial that were computed, and the sum of their changes. */
    int numComputed;
    double computedChange;
    /** The change of near pairs in the open trial. */
    double nearChange;
    /** The numbers of the stand-in, the cutoff beyond which they replace Born sums, and whether the scene has them. */
    std::vector<double> standIn;
    double standInCutoff;
    bool standInIsSet;
    HeldEnergy held;
    WholeEnergy whole, savedWhole;
    ValueEnergies values, savedValues;
    /** The energies of values in the open trial. */
    std::vector<double> proposedValues;
};

/**
 * A part of U that the scene evaluates.
 */
class NativeEnergyStage : public EnergyStage {
public:
    NativeEnergyStage(NativeEnergy& energy, ctEnergyPart part) : energy(energy), part(part)
    {
    }
    std::string getName() const;
    bool begin(TrialSession&)
    {
        return energy.canChange(part);
    }
    double computeEnergyChange(TrialSession&)
    {
        return energy.computeEnergyChange(part);
    }
    bool isAntisymmetric() const
    {
        return part != ctNearPairsPart || !energy.hasStandIn();
    }
    double getCorrection()
    {
        return part == ctOtherPairsPart ? energy.getNearCorrection() : 0;
    }
    void accept()
    {
        energy.accept();
    }
    void reject()
    {
        energy.forgetTrial();
    }

private:
    NativeEnergy& energy;
    const ctEnergyPart part;
};

/**
 * The energies of values, which the scene always evaluates as a whole. If outer tests evaluate them, the stage takes no
 * part in trials. It comes after all other stages of the scene.
 */
class ValueEnergyStage : public EnergyStage {
public:
    explicit ValueEnergyStage(NativeEnergy& energy) : energy(energy)
    {
    }
    std::string getName() const
    {
        return "computed values";
    }
    bool begin(TrialSession&)
    {
        return energy.decidesByValues();
    }
    double computeEnergyChange(TrialSession&)
    {
        return energy.computeValueEnergyChange();
    }
    void accept()
    {
        energy.acceptValues();
    }
    void reject()
    {
        energy.forgetTrial();
    }

private:
    NativeEnergy& energy;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_NATIVEENERGY_H_*/
