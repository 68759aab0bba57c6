#ifndef OPENMM_CHAINTREE_ENERGYSTAGE_H_
#define OPENMM_CHAINTREE_ENERGYSTAGE_H_

#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <cstddef>
#include <memory>
#include <vector>

namespace ChainTreePlugin {

/**
 * An EnergyStage is a part of the energy U by which a trial is decided once it is known to be free of clashes. It keeps
 * whatever it has to know about the state.
 */
class OPENMM_EXPORT_CHAINTREE EnergyStage {
public:
    virtual ~EnergyStage()
    {
    }
    /**
     * Begin a series of trials: find out what has to be known about the state, which may be any. Returns whether this
     * part of U can be anything but 0 in these trials; if not, the stage is left alone until the next series.
     */
    virtual bool begin(TrialSession& trials) = 0;
    /**
     * Compute by how much this part of U changes if the open trial becomes the state, in kJ/mol. NaN if the trial has
     * no energy, so that it has to be refused.
     */
    virtual double computeChange(TrialSession& trials) = 0;
    /**
     * Take notice that the trial that computeChange() was asked about has become the state.
     */
    virtual void accept()
    {
    }
    /**
     * Take notice that it was dropped.
     */
    virtual void reject()
    {
    }
};

/**
 * The stages of U, in the order in which they are asked: cheapest first. A trial that one of them refuses costs nothing
 * in those after it.
 */
class OPENMM_EXPORT_CHAINTREE EnergyStages {
public:
    /**
     * What has become of the trials that reached a stage.
     */
    class Statistics {
    public:
        /** The number of trials whose change was computed. */
        long long computed;
        /** How many of them ended there. */
        long long rejected;
    };
    EnergyStages();
    void add(std::unique_ptr<EnergyStage> stage);
    /**
     * Get what became of the trials that reached a stage, since it was added.
     */
    const Statistics& getStatistics(int stage) const
    {
        return entries[stage].statistics;
    }
    /**
     * Begin a series of trials.
     */
    void begin(TrialSession& trials);
    /**
     * Compute by how much U changes if the open trial becomes the state, in kJ/mol; NaN if it has to be refused. Follow
     * this by accept() or reject().
     */
    double computeChange(TrialSession& trials);
    void accept();
    void reject();

private:
    class Entry {
    public:
        std::unique_ptr<EnergyStage> stage;
        bool takesPart;
        Statistics statistics;
    };
    std::vector<Entry> entries;
    /** How many stages the open trial has reached. */
    size_t numAsked;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ENERGYSTAGE_H_*/
