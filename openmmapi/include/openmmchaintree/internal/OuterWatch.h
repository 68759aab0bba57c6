#ifndef OPENMM_CHAINTREE_OUTERWATCH_H_
#define OPENMM_CHAINTREE_OUTERWATCH_H_

#include "openmmchaintree/internal/OuterStatistics.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"

namespace ChainTreePlugin {

/**
 * Watches whether outer tests keep enough of the trials, and warns once if they do not.
 *
 * The energy U1 of trials may be so far from U that a chain stays for a long time in states that U1 misjudges. The
 * ensemble is right, but means and error estimates of a run are meaningless. With few trials to a test, most tests pass
 * even then, because their trials hardly change U - U1. The standard deviation of U - U1 shows that, too.
 */
class OPENMM_EXPORT_CHAINTREE OuterWatch {
public:
    OuterWatch();
    /**
     * Add the change of the difference that an outer test decides about, in kT. Tests of trials that changed nothing
     * are left out.
     */
    void add(double change);
    /**
     * Warn if there were enough tests since the last call, and they show that U1 is far from U.
     */
    void judge();
    /**
     * Forget all tests, because the energies have changed.
     */
    void restart();

private:
    bool hasWarned;
    /** The number of changes, and the mean probability that tests keep them. */
    int count;
    double acceptance;
    /** The finite changes, in kT. */
    OuterStatistics changes;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_OUTERWATCH_H_*/
