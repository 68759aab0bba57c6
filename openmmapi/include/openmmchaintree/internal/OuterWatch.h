#ifndef OPENMM_CHAINTREE_OUTERWATCH_H_
#define OPENMM_CHAINTREE_OUTERWATCH_H_

#include "openmmchaintree/internal/OuterStatistics.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"

namespace ChainTreePlugin {

/**
 * Watches whether outer tests keep enough of the trials, and warns once if they do not.
 *
 * What trials see may be so far from U that a chain sits for a long time in a state that they misjudge. The ensemble is
 * right, but means and error estimates of a run say nothing. With few trials to a test, most tests pass even then, by
 * trials that hardly change the difference. Its standard deviation shows that, too.
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
     * Warn if the last tests were enough to tell, and showed that trials are far from U.
     */
    void judge();
    /**
     * Forget all tests: what they decide about has changed.
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
