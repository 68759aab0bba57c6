#ifndef OPENMM_CHAINTREE_OUTERTEST_H_
#define OPENMM_CHAINTREE_OUTERTEST_H_

#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/TrialSession.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * What became of outer tests.
 */
class OuterStatistics {
public:
    OuterStatistics();
    void add(double difference);
    /**
     * Get the standard deviation of all differences; 0 if there are fewer than two.
     */
    double getStandardDeviation() const;
    void write(CheckpointWriter& writer) const;
    void read(CheckpointReader& reader);
    void write(OpenMM::SerializationNode& node) const;
    void read(const OpenMM::SerializationNode& node);
    /** The number of tests, and how many of them kept their trials. */
    long long attempted, accepted;
    /** The number of trials, refused ones too, of the tests that did not. */
    long long trialsTakenBack;
    /** Of the differences that tests found: how many there were, their mean, and the sum of the squares of their
     *  deviations from it. */
    long long numDifferences;
    double mean, squares;
};

/**
 * The outer tests of a series of trials. Trials are decided by a part U1 of U, or by something near it; after a number
 * of them, a test keeps all that were accepted since the last test, or takes all back.
 *
 * This samples exp(-U/kT) exactly. The trials of a block are a Markov chain P that is reversible for exp(-U1/kT), and
 * so is any number of them: exp(-U1(x)/kT) P(x, y) = exp(-U1(y)/kT) P(y, x). With D = U - U1, a block that leads from x
 * to y is kept with probability min(1, exp(-(D(y) - D(x))/kT)), whose ratio to that of y to x is the exponential alone.
 * The product of both is detailed balance for exp(-U/kT). All of it hinges on U1 being a function of the state alone
 * during the block, and on x being wholly what the block began with when it is taken back.
 *
 * At a temperature of 0 a block is kept if U has not gone up.
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
     * Take back the trials of an unfinished block: an exception has ended it.
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
     * Take notice that a trial was accepted or not, and test the block if it was its last.
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
     * End the series: test the block that is not complete.
     */
    void end()
    {
        if (numTrials > 0)
            endBlock();
    }

private:
    /** What a test goes by. */
    class Energies {
    public:
        /** U - U1. */
        NativeEnergy::Difference difference;
        /** U1; 0 where the temperature is not. */
        double inner;
    };
    Energies computeEnergies();
    void beginBlock();
    void endBlock();
    bool decide(const Energies& proposed, double drawn);
    void takeBack();
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
    /** The number of trials in the present block, and how many of them were accepted. */
    int numTrials, numAccepted;
    /** Whether what was kept of the state is where the block begins. */
    bool stateIsKept;
    /** Of the state where the block begins. */
    Energies start;
    std::vector<long long> keptMoveCounts;
    std::vector<EnergyStages::Statistics> keptStageCounts;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_OUTERTEST_H_*/
