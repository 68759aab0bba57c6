#include "openmmchaintree/internal/OuterWatch.h"
#include "openmmchaintree/internal/Warnings.h"
#include <algorithm>
#include <cmath>
#include <sstream>

using namespace ChainTreePlugin;
using namespace std;

static const int TESTS_TO_JUDGE = 100;

/** Both say the same of normally distributed changes, whose standard deviation s lets tests pass by 2 Phi(-s/2). */
static const double LEAST_ACCEPTANCE = 0.3;
static const double LARGEST_DEVIATION = 2; // kT

OuterWatch::OuterWatch() : hasWarned(false)
{
    restart();
}

void OuterWatch::restart()
{
    count = 0;
    acceptance = 0;
    changes = OuterStatistics();
}

void OuterWatch::add(double change)
{
    if (change == 0)
        return;
    count++;
    acceptance += ((isnan(change) ? 0 : min(1.0, exp(-change))) - acceptance) / count;
    if (isfinite(change))
        changes.add(change);
}

void OuterWatch::judge()
{
    if (count < TESTS_TO_JUDGE)
        return;
    const double deviation = changes.getStandardDeviation();
    const double kept = acceptance;
    restart();
    if (hasWarned || (kept >= LEAST_ACCEPTANCE && deviation <= LARGEST_DEVIATION))
        return;
    hasWarned = true;
    ostringstream message;
    message.precision(2);
    message << "TorsionMonteCarloIntegrator: chains move slowly: the energy that trials see differs from U by "
            << deviation << " kT (standard deviation of its changes), so that outer tests keep only "
            << lround(100 * kept) << " % of what trials change. What is sampled is right, but needs many more trials. "
            << "Call renewStandIns(context), set larger cutoffs by setStandInCutoffs, or let fewer trials come before "
            << "a test by setTrialsPerOuterTest";
    warn(message.str());
}
