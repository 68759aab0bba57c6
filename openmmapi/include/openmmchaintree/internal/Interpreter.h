#ifndef OPENMM_CHAINTREE_INTERPRETER_H_
#define OPENMM_CHAINTREE_INTERPRETER_H_

#include "windowsExportChainTree.h"
#include <chrono>

namespace ChainTreePlugin {

/**
 * The interpreter that calls this library, such as Python: handles signals during a call. C++ programs have none.
 */
class OPENMM_EXPORT_CHAINTREE Interpreter {
public:
    virtual ~Interpreter();
    /**
     * Get whether this thread may wait for another one. It may not while it holds a lock that the other may need.
     */
    virtual bool mayWait() = 0;
    /**
     * Begin to watch for signals, such as Ctrl-C. Returns false if this thread handles no signals. This may wait until
     * another thread releases the interpreter's lock.
     */
    virtual bool beginWatch() = 0;
    virtual void endWatch() = 0;
    /**
     * Get whether a signal has come since beginWatch(). This must be cheap.
     */
    virtual bool hasSignal() = 0;
    /**
     * Run the handlers of signals that have come. Returns false if one of them raises an exception. Then the present
     * call must end; the caller gets the exception when the call has returned.
     */
    virtual bool handleSignals() = 0;
    /**
     * Set the interpreter. It is never deleted.
     */
    static void set(Interpreter* interpreter);
    /**
     * Get the interpreter, or NULL if there is none.
     */
    static Interpreter* get();
};

/**
 * Watches for signals while trials run. Handlers run between steps, or within a step if it takes too long. They change
 * no trial.
 */
class OPENMM_EXPORT_CHAINTREE SignalWatch {
public:
    /**
     * Begin to watch if the trials take long enough. Otherwise signals are handled when the present call has returned.
     *
     * @param secondsPerTrial  time per trial in the last call, infinite at first
     */
    SignalWatch(double numTrials, double& secondsPerTrial);
    ~SignalWatch();
    SignalWatch(const SignalWatch&) = delete;
    SignalWatch& operator=(const SignalWatch&) = delete;
    /**
     * Call this after each trial. Returns whether trials should pause for handle(), because a signal has waited too
     * long.
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
    /** The number of trials until the clock is read again, and its initial value. */
    long long trialsToLook, interval;
    const Clock::time_point start;
    Clock::time_point lastLook, signalTime;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_INTERPRETER_H_*/
