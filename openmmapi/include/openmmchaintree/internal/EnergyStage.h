#ifndef OPENMM_CHAINTREE_ENERGYSTAGE_H_
#define OPENMM_CHAINTREE_ENERGYSTAGE_H_

#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * An EnergyStage accepts or rejects clash-free trials by a part of the energy U. It may keep data of the state.
 */
class OPENMM_EXPORT_CHAINTREE EnergyStage {
public:
    virtual ~EnergyStage()
    {
    }
    /**
     * Get a name of a word or two, for messages.
     */
    virtual std::string getName() const = 0;
    /**
     * Begin a series of trials from any state. Returns whether trials can change this part of U; if not, the stage is
     * not asked until the next series.
     */
    virtual bool begin(TrialSession& trials) = 0;
    /**
     * Compute by how much this part of U changes if the open trial becomes the state, in kJ/mol. NaN if the trial has
     * no energy, so that it has to be rejected.
     */
    virtual double computeEnergyChange(TrialSession& trials) = 0;
    /**
     * Get whether the reverse trial has the opposite change, as for a function of the state. If not, a later stage has
     * to correct it; see EnergyStages::DecideOneByOne.
     */
    virtual bool isAntisymmetric() const
    {
        return true;
    }
    /**
     * Get the term that this stage adds to its change under DecideOneByOne, to correct an earlier stage that is not
     * antisymmetric. Call this after computeEnergyChange().
     */
    virtual double getCorrection()
    {
        return 0;
    }
    /**
     * Take notice that the trial of computeEnergyChange() was accepted.
     */
    virtual void accept()
    {
    }
    /**
     * Take notice that it was rejected.
     */
    virtual void reject()
    {
    }
    /**
     * Save the data of the state.
     */
    virtual void save()
    {
    }
    /**
     * Take notice that the state of the last save() was restored, in the same series of trials.
     */
    virtual void restore()
    {
    }
};

/**
 * The stages of U, in the order in which they are asked: cheapest first. Later stages
 * do not see a trial that an earlier one rejects.
 */
class OPENMM_EXPORT_CHAINTREE EnergyStages {
public:
    /**
     * How the stages decide about a trial.
     */
    enum Rule {
        /**
         * The sum of all changes decides, once.
         */
        DecideBySum,
        /**
         * Each stage decides by its own change and its own random number, which is drawn before the change is computed
         * (delayed acceptance).
         *
         * This samples the same distribution exactly. A trial from x to y is accepted if it passes all stages, with the
         * probability a(x, y) = product over i of min(1, r_i(x, y)). Here r_i = exp(-change_i / kT), and the first
         * stage's r is multiplied by the ratio of backward and forward proposal. Each change is the difference of a
         * function of the state, or at least antisymmetric: r_i(y, x) = 1 / r_i(x, y). Since min(1, r) / min(1, 1 / r)
         * = r, a(x, y) / a(y, x) is the product of all r_i, as detailed balance requires. (Christen and Fox, J. Comput.
         * Graph. Stat. 14, 795 (2005).) It accepts less than the sum would: a stage may reject a trial that a later one
         * would have favoured.
         *
         * A stage n may have a change d(x, y) that is not the opposite of d(y, x), if a later stage l, with a change c
         * for which d + c is antisymmetric, adds the correction
         *
         *     max(0, d(y, x)) - max(0, -d(x, y))
         *
         * to c. It is 0 if d(y, x) = -d(x, y). Proof: since x - max(0, x) = -max(0, -x), c and the correction are
         *
         *     C(x, y) = (d + c)(x, y) + max(0, d(y, x)) - max(0, d(x, y)),
         *
         * which is antisymmetric, so l contributes exp(-C(x, y) / kT) to a(x, y) / a(y, x). Stage n contributes min(1,
         * exp(-d(x, y) / kT)) / min(1, exp(-d(y, x) / kT)) = exp(-(max(0, d(x, y)) - max(0, d(y, x))) / kT). The
         * product is exp(-(d + c) / kT), as if both were antisymmetric. The ratio of proposals must not enter stage n,
         * where it would change the maxima: if n is the first stage, the ratio is tested alone before it.
         */
        DecideOneByOne
    };
    /**
     * Counts of the trials that reached a stage.
     */
    class Statistics {
    public:
        /** The number of trials whose change was computed. */
        long long computed;
        /** The number of trials that the stage rejected. */
        long long rejected;
    };
    EnergyStages();
    void add(std::unique_ptr<EnergyStage> stage);
    int size() const
    {
        return entries.size();
    }
    const EnergyStage& get(int stage) const
    {
        return *entries[stage].stage;
    }
    /**
     * Get the counts of a stage since it was added or resetStatistics() was called.
     */
    const Statistics& getStatistics(int stage) const
    {
        return entries[stage].statistics;
    }
    void resetStatistics();
    /**
     * Get or set the counts of all stages.
     */
    std::vector<Statistics> getAllStatistics() const;
    void setAllStatistics(const std::vector<Statistics>& statistics);
    /**
     * Begin a series of trials.
     */
    void begin(TrialSession& trials);
    /**
     * Decide about the open trial, which is free of clashes. Follow this by accept() or reject(). A trial whose change
     * of U is not a number is rejected.
     *
     * @param trials       the session of the trial
     * @param logRatio     the result of MonteCarloMove::computeLogRatio()
     * @param temperature  in Kelvin
     * @param rule         how to decide. At a temperature of 0 the sum always decides: stages that each had to go down
     *                     would stop at states where the sum can still decrease.
     * @param random       draws nothing if no stage takes part and logRatio is not negative
     */
    bool decide(TrialSession& trials, double logRatio, double temperature, Rule rule, RandomNumberGenerator& random);
    void accept();
    void reject();
    /**
     * Save the stages' data of the state, or take notice that the state was restored.
     */
    void save();
    void restore();

private:
    class Entry {
    public:
        std::unique_ptr<EnergyStage> stage;
        bool takesPart;
        Statistics statistics;
    };
    bool decideBySum(TrialSession& trials, double logRatio, double temperature, RandomNumberGenerator& random);
    bool decideOneByOne(TrialSession& trials, double logRatio, double temperature, RandomNumberGenerator& random);
    std::vector<Entry> entries;
    /** The number of stages that the open trial has reached. */
    size_t numAsked;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ENERGYSTAGE_H_*/
