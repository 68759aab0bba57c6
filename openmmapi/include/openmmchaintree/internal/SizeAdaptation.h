#ifndef OPENMM_CHAINTREE_SIZEADAPTATION_H_
#define OPENMM_CHAINTREE_SIZEADAPTATION_H_

#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>

namespace ChainTreePlugin {

/**
 * Finds the size at which a move has the wanted acceptance: after each block of trials it changes a factor of at most
 * 1, by less and less. This depends on the trials alone, never on time.
 */
class OPENMM_EXPORT_CHAINTREE SizeAdaptation {
public:
    /** The share of trials that should be accepted, unless the move says otherwise. */
    static constexpr double AIM = 0.4;
    /** The number of trials from which the acceptance is estimated. */
    static const int BLOCK = 100;
    /** The least scale. */
    static constexpr double LEAST_SCALE = 1e-4;
    /**
     * Take notice of a trial.
     *
     * @param accepted  whether it was accepted
     * @param scale     the scale of the trial
     * @param aim       the share of trials that should be accepted
     * @return the scale of the next trial
     */
    double countTrial(bool accepted, double scale, double aim = AIM);
    /** The state, for checkpoints: the number of complete blocks, and the counts of the present one.
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
