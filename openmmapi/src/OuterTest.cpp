#include "openmmchaintree/internal/OuterTest.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
#include <cmath>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Get the change of an energy; 0 if both are the same infinity.
 */
static double changeOf(double before, double after)
{
    return before == after ? 0 : after - before;
}

OuterTest::OuterTest(TrialSession& trials, NativeEnergy& native, EnergyStages& stages, MoveList& moves,
                     OuterStatistics& statistics, RandomNumberGenerator& random, double temperature, bool softSpheres) :
    trials(trials),
    native(native), stages(stages), moves(moves), statistics(statistics), random(random), temperature(temperature),
    softSpheres(softSpheres), size(native.getTrialsPerOuterTest()), numTrials(0), numAccepted(0), stateIsSaved(false),
    start({{0, {}}, 0})
{
    if (size == 0)
        return;
    start = computeEnergies();
    if (!NativeEnergy::isPossible(start.difference.whole))
        native.refuseState(trials);
}

OuterTest::~OuterTest()
{
    try {
        if (numTrials > 0)
            restore();
    }
    catch (...) {
        // Another exception is being handled. The next step reports the problem, or starts from the present state.
    }
}

OuterTest::Energies OuterTest::computeEnergies()
{
    const NativeEnergy::Difference difference = native.computeDifference(trials);
    if (temperature > 0)
        return {difference, 0};
    return {difference, native.getInnerEnergy() + (softSpheres ? trials.computeSoftEnergy() : 0)};
}

void OuterTest::beginBlock()
{
    savedMoveCounts = moves.getStatistics();
    savedStageCounts = stages.getAllStatistics();
    if (stateIsSaved)
        return;
    trials.save();
    native.save();
    stages.save();
    stateIsSaved = true;
}

void OuterTest::endBlock()
{
    const double drawn = random.drawUniform();
    bool isAccepted = true;
    const Energies proposed = numAccepted > 0 ? computeEnergies() : start;
    if (numTrials == size)
        native.takeNoticeOfTest(start.difference, proposed.difference);
    if (numAccepted > 0) {
        isAccepted = decide(proposed, drawn);
        if (isAccepted) {
            start = proposed;
            stateIsSaved = false;
        }
    }
    if (!isAccepted) {
        statistics.trialsTakenBack += numTrials;
        restore();
    }
    statistics.attempted++;
    statistics.accepted += isAccepted ? 1 : 0;
    numTrials = numAccepted = 0;
}

/**
 * Decide whether to accept a block that has led to a state with these energies.
 */
bool OuterTest::decide(const Energies& proposed, double drawn)
{
    const double change = changeOf(start.difference.whole, proposed.difference.whole);
    if (isfinite(change))
        statistics.add(change);
    if (!NativeEnergy::isPossible(proposed.difference.whole))
        return false;
    if (temperature == 0)
        return changeOf(start.difference.whole + start.inner, proposed.difference.whole + proposed.inner) <= 0;
    return drawn < exp(-change / (BOLTZ * temperature));
}

void OuterTest::restore()
{
    moves.setStatistics(savedMoveCounts);
    stages.setAllStatistics(savedStageCounts);
    numTrials = 0;
    trials.restore();
    native.restore();
    stages.restore();
}
