#ifndef OPENMM_CHAINTREE_INTERPRETER_H_
#define OPENMM_CHAINTREE_INTERPRETER_H_

#include "windowsExportChainTree.h"
#include <chrono>

namespace ChainTreePlugin {

/**
 * What a language such as Python, from which this library is called, has to say while a call runs. C++ alone has
 * nothing to say.
 */
class OPENMM_EXPORT_CHAINTREE Interpreter {
public:
    virtual ~Interpreter();
    /**
     * Get whether this thread may wait for another one. It may not while it holds a lock that the other may need.
     */
    virtual bool mayWait() = 0;
    /**
     * Begin to take notice of signals, such as that of Ctrl-C. Returns false if this thread does not handle any. This
     * may take as long as another thread holds the interpreter's lock.
     */
    virtual bool beginWatch() = 0;
    virtual void endWatch() = 0;
    /**
     * Get whether a signal has come since beginWatch(). This must cost next to nothing.
     */
    virtual bool hasSignal() = 0;
    /**
     * Run the handlers of signals that have come. Returns false if one of them wants the present call to end; it then
     * tells the caller why as soon as the call has returned.
     */
    virtual bool handleSignals() = 0;
    /**
     * Name the interpreter. It is never deleted.
     */
    static void set(Interpreter* interpreter);
    /**
     * Get the interpreter, or NULL if there is none.
     */
    static Interpreter* get();
};

/**
 * This watches for signals while trials run. Handlers run between steps, where the Context is whole, and in the midst
 * of a step only if that takes too long. It changes no trial.
 */
class OPENMM_EXPORT_CHAINTREE SignalWatch {
public:
    /**
     * Begin to watch, if the trials to come take so long that it matters. Signals that come later are handled when the
     * present call has returned.
     *
     * @param secondsPerTrial  what trials took the last time, infinite at first
     */
    SignalWatch(double numTrials, double& secondsPerTrial);
    ~SignalWatch();
    SignalWatch(const SignalWatch&) = delete;
    SignalWatch& operator=(const SignalWatch&) = delete;
    /**
     * Take notice that a trial has ended. Returns whether trials should pause for handle(), since a signal has waited
     * for too long.
     */
    bool isUrgent()
    {
        return --trialsToLook <= 0 && look();
    }
    /**
     * Run the handlers of the signals that were seen, if any. Returns false if the present call has to end.
     */
    bool handle();

private:
    typedef std::chrono::steady_clock Clock;
    bool look();
    void begin();
    Interpreter* const interpreter;
    const double numTrials;
    double& secondsPerTrial;
    bool hasBegun, isWatching, signalWasSeen;
    /** The number of trials until the clock is read again, and how many there were to be the last time. */
    long long trialsToLook, interval;
    const Clock::time_point start;
    Clock::time_point lastLook, signalTime;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_INTERPRETER_H_*/
