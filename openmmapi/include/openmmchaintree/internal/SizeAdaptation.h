#ifndef OPENMM_CHAINTREE_SIZEADAPTATION_H_
#define OPENMM_CHAINTREE_SIZEADAPTATION_H_

#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>

namespace ChainTreePlugin {

/**
 * Finds the size at which a move has the acceptance that is wished, from its trials alone: it scales sizes by a factor
 * of at most 1, after each block of trials, by less and less. Nothing else has an influence, such as time.
 */
class OPENMM_EXPORT_CHAINTREE SizeAdaptation {
public:
    /** The share of trials that should be accepted. */
    static constexpr double AIM = 0.4;
    /** The number of trials from which the acceptance is estimated. */
    static const int BLOCK = 100;
    /** No scale is less. */
    static constexpr double LEAST_SCALE = 1e-4;
    /**
     * Take notice of a trial.
     *
     * @param accepted  whether it was accepted
     * @param scale     the scale that it had
     * @return the scale of the next trial
     */
    double countTrial(bool accepted, double scale);
    /** What decides all scales to come, for checkpoints: blocks that are complete, and the counts of the present one.
     */
    typedef std::array<long long, 3> State;
    State getState() const
    {
        return {{numBlocks, numTrials, numAccepted}};
    }
    void setState(const State& state)
    {
        numBlocks = state[0];
        numTrials = state[1];
        numAccepted = state[2];
    }

private:
    long long numBlocks = 0, numTrials = 0, numAccepted = 0;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SIZEADAPTATION_H_*/
