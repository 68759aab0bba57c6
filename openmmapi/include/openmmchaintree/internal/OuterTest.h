#ifndef OPENMM_CHAINTREE_OUTERTEST_H_
#define OPENMM_CHAINTREE_OUTERTEST_H_

#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmmchaintree/internal/OuterStatistics.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/TrialSession.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * The outer tests of a series of trials. A part or an approximation U1 of U decides each trial. After a block of
 * trials, a test accepts their final state, or restores the state before them.
 *
 * This samples exp(-U/kT) exactly. The trials of a block are a Markov chain P that is reversible for exp(-U1/kT), and
 * so is any number of them: exp(-U1(x)/kT) P(x, y) = exp(-U1(y)/kT) P(y, x). With D = U - U1, a block that leads from x
 * to y is accepted with probability min(1, exp(-(D(y) - D(x))/kT)), whose ratio to the probability from y to x is the
 * exponential alone. The product of both is detailed balance for exp(-U/kT). This needs that U1 is a function of the
 * state alone during the block, and that a rejected block restores all of x.
 *
 * At a temperature of 0 a block is accepted if U has not gone up.
 */
class OuterTest {
public:
    /**
     * Begin a series of trials, after NativeEnergy and the EnergyStages have begun it.
     */
    OuterTest(TrialSession& trials, NativeEnergy& native, EnergyStages& stages, MoveList& moves,
              OuterStatistics& statistics, RandomNumberGenerator& random, double temperature, bool softSpheres);
    OuterTest(const OuterTest&) = delete;
    OuterTest& operator=(const OuterTest&) = delete;
    /**
     * Restore the state before an unfinished block, which an exception has ended.
     */
    ~OuterTest();
    /**
     * Take notice that a trial begins.
     */
    void beginTrial()
    {
        if (size > 0 && numTrials == 0)
            beginBlock();
    }
    /**
     * Take notice that a trial was accepted or rejected, and test the block after its last trial.
     */
    void endTrial(bool accepted)
    {
        if (size == 0)
            return;
        numAccepted += accepted ? 1 : 0;
        if (++numTrials == size)
            endBlock();
    }
    /**
     * End the series: test the incomplete block.
     */
    void end()
    {
        if (numTrials > 0)
            endBlock();
    }

private:
    /** The energies that a test compares. */
    class Energies {
    public:
        /** U - U1. */
        NativeEnergy::Difference difference;
        /** U1; 0 unless the temperature is 0. */
        double inner;
    };
    Energies computeEnergies();
    void beginBlock();
    void endBlock();
    bool decide(const Energies& proposed, double drawn);
    void restore();
    TrialSession& trials;
    NativeEnergy& native;
    EnergyStages& stages;
    MoveList& moves;
    OuterStatistics& statistics;
    RandomNumberGenerator& random;
    const double temperature;
    const bool softSpheres;
    /** The number of trials in a block; 0 if there is no outer test. */
    const int size;
    /** The numbers of trials and of accepted trials in the present block. */
    int numTrials, numAccepted;
    /** Whether the state where the block begins is saved. */
    bool stateIsSaved;
    /** Of the state where the block begins. */
    Energies start;
    std::vector<MoveList::Counts> savedMoveCounts;
    std::vector<EnergyStages::Statistics> savedStageCounts;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_OUTERTEST_H_*/
