#ifndef OPENMM_CHAINTREE_OUTERSCHEDULE_H_
#define OPENMM_CHAINTREE_OUTERSCHEDULE_H_

#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * Chooses which foreign energies are left to outer tests, and after how many trials these come.
 *
 * The first tests measure by how much trials change each energy. They begin with few trials, and double their number as
 * long as more than half of the tests can be expected to keep their trials. An energy that changes too much even in the
 * fewest trials is decided about in each trial from then on. What was chosen is fixed afterwards.
 *
 * Each test samples exp(-U/kT), whatever the number of trials before it. That number follows from tests that are past,
 * and changes between two series of trials alone, so nothing that is sampled after the choice depends on it.
 */
class OPENMM_EXPORT_CHAINTREE OuterSchedule {
public:
    OuterSchedule();
    /**
     * Begin a series of trials, and change to the next number of trials if enough was measured with this one.
     *
     * @param energies  what tells the energies apart from those of another System. If it is not what it was, measuring
     *                  starts again
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
     * @param change   by how much they changed all that the test decides about
     */
    void add(const std::vector<double>& changes, double change);
    /**
     * Get or set all that the choice depends on, for checkpoints; nothing as long as there are no energies. Numbers
     * that make no sense start measuring again.
     */
    std::vector<double> getNumbers() const;
    void setNumbers(const std::vector<double>& numbers);

private:
    /** What was measured of one energy. */
    class Spread {
    public:
        void add(double change);
        double getLeastAcceptance() const
        {
            return acceptance < acceptanceBack ? acceptance : acceptanceBack;
        }
        /** Whether tests that decide by these changes alone keep their trials more often than not, either way. */
        bool isSmall() const;
        /** The number of changes, and with which probability tests keep them, and would keep the opposite ones. */
        double count = 0, acceptance = 0, acceptanceBack = 0;
    };
    void beginRound();
    void endRound(int longest);
    void leaveOutLargest();
    std::vector<int> energies;
    std::vector<char> left;
    bool measuring;
    /** How often the number of trials was raised, and what it is. */
    int level, trials;
    /** Of each energy, and of all that tests decide about. */
    std::vector<Spread> spreads;
    Spread whole;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_OUTERSCHEDULE_H_*/
