#include "openmmchaintree/internal/Interpreter.h"
#include <algorithm>
#include <atomic>
#include <limits>

using namespace ChainTreePlugin;
using namespace std;

/** The interval of looking for signals, in seconds, and the time that a step may still take after one has come. */
static const double TIME_BETWEEN_LOOKS = 0.05, PATIENCE = 0.3;

static atomic<Interpreter*> current(NULL);

Interpreter::~Interpreter()
{
}

void Interpreter::set(Interpreter* interpreter)
{
    current = interpreter;
}

Interpreter* Interpreter::get()
{
    return current;
}

/**
 * Get the time since a point in time, in seconds.
 */
static double secondsSince(chrono::steady_clock::time_point time)
{
    return chrono::duration<double>(chrono::steady_clock::now() - time).count();
}

SignalWatch::SignalWatch(double numTrials, double& secondsPerTrial) :
    interpreter(Interpreter::get()), numTrials(numTrials), secondsPerTrial(secondsPerTrial), hasBegun(false),
    isWatching(false), signalWasSeen(false), trialsToLook(1), interval(1), start(Clock::now()), lastLook(start)
{
    if (numTrials * secondsPerTrial > TIME_BETWEEN_LOOKS)
        begin();
}

SignalWatch::~SignalWatch()
{
    if (isWatching)
        interpreter->endWatch();
    secondsPerTrial = secondsSince(start) / numTrials;
}

void SignalWatch::begin()
{
    hasBegun = true;
    isWatching = interpreter != NULL && interpreter->beginWatch();
}

/**
 * Look for signals, and choose the next time to look by the time per trial.
 */
bool SignalWatch::look()
{
    if (!hasBegun && secondsSince(start) > TIME_BETWEEN_LOOKS)
        begin();
    if (hasBegun && !isWatching) {
        trialsToLook = numeric_limits<long long>::max();
        return false;
    }
    const Clock::time_point now = Clock::now();
    const double seconds = chrono::duration<double>(now - lastLook).count();
    lastLook = now;
    if (seconds < TIME_BETWEEN_LOOKS / 2)
        interval *= 2;
    else if (seconds > TIME_BETWEEN_LOOKS)
        interval = max(1LL, (long long)(interval * TIME_BETWEEN_LOOKS / seconds));
    trialsToLook = interval;
    if (isWatching && !signalWasSeen && interpreter->hasSignal()) {
        signalWasSeen = true;
        signalTime = now;
    }
    return signalWasSeen && secondsSince(signalTime) > PATIENCE;
}

bool SignalWatch::handle()
{
    if (!signalWasSeen)
        return true;
    signalWasSeen = false;
    return interpreter->handleSignals();
}
