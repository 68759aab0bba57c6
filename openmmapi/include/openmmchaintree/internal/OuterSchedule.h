#ifndef OPENMM_CHAINTREE_OUTERSCHEDULE_H_
#define OPENMM_CHAINTREE_OUTERSCHEDULE_H_

#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * Chooses which foreign energies are left to outer tests, and the number of trials to a test.
 *
 * The first tests measure by how much trials change each energy. They begin with few trials, and double their number as
 * long as more than half of the tests can be expected to keep their trials. An energy that changes too much even in the
 * fewest trials decides each trial from then on. Afterwards the choice is fixed.
 *
 * Each test samples exp(-U/kT) for any number of trials. The number follows from past tests, and changes only between
 * two series of trials, so the choice has no influence on samples after it.
 */
class OPENMM_EXPORT_CHAINTREE OuterSchedule {
public:
    OuterSchedule();
    /**
     * Begin a series of trials, and change to the next number of trials if enough was measured with this one.
     *
     * @param energies  identifies the energies. If it differs from the last call, measuring starts again
     * @param longest   the largest number of trials to a test
     */
    void begin(const std::vector<int>& energies, int longest);
    /**
     * Start measuring again.
     */
    void restart();
    /**
     * Get whether tests are still measured.
     */
    bool isMeasuring() const
    {
        return measuring;
    }
    /**
     * Get whether an energy is left to outer tests. All are at first.
     */
    bool isLeft(int energy) const
    {
        return energy >= (int)left.size() || left[energy] != 0;
    }
    /**
     * Get the number of trials to an outer test while an energy is left to it.
     */
    int getTrialsPerTest() const
    {
        return trials;
    }
    /**
     * Take notice of a test of getTrialsPerTest() trials while measuring.
     *
     * @param changes  by how much the trials changed each energy that is left to the tests, in kT; others do not matter
     * @param change   by how much they changed the whole energy of the test
     */
    void add(const std::vector<double>& changes, double change);
    /**
     * Get or set the state of the choice, for checkpoints; empty if there are no energies. Invalid numbers start
     * measuring again.
     */
    std::vector<double> getNumbers() const;
    void setNumbers(const std::vector<double>& numbers);

private:
    /** Measurements of one energy. */
    class Spread {
    public:
        void add(double change);
        double getLeastAcceptance() const
        {
            return acceptance < acceptanceBack ? acceptance : acceptanceBack;
        }
        /** Whether tests of these changes alone, and of the opposite changes, keep their trials more often than not. */
        bool isSmall() const;
        /** The number of changes, and the probabilities that tests keep them and the opposite changes. */
        double count = 0, acceptance = 0, acceptanceBack = 0;
    };
    void beginRound();
    void endRound(int longest);
    void leaveOutLargest();
    std::vector<int> energies;
    std::vector<char> left;
    bool measuring;
    /** The number of increases of the number of trials, and the number of trials. */
    int level, trials;
    /** Of each energy, and of the sum of those about which tests decide. */
    std::vector<Spread> spreads;
    Spread whole;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_OUTERSCHEDULE_H_*/
